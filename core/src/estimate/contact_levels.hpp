#pragma once

#include <Eigen/Core>
#include <vector>

#include "estimate/estimate_fit.hpp"

namespace tendril {

/// A contact is shown by the points if they would look like it without one less often than this.
inline constexpr double significance = 0.01;

/// All local minima with one number of contacts, best first; the test against one contact less.
struct Level {
  int contacts = 0;
  std::vector<ShapeFit> fits;  ///< without friction
  ShapeFit best;               ///< with whatever friction is allowed
  double probability = 1.0;    ///< at most: of such an improvement without this contact; 1 for none
  bool supported = false;      ///< The points show that many contacts: the test is passed.

  bool converged() const { return !fits.empty(); }
};

/// Bound on the probability that `best`, which has a force more than `fewer`, is better by noise alone.
double chance_of_improvement(const LoadedRod& rod, const MeasuredShape& measured, const ShapeFit& fewer,
                             const ShapeFit& best);

/// Fits with no contact, one, and so on, each tested against the one before; fewer where time is over. `most_chance`:
/// of a contact that is not there.
std::vector<Level> fit_levels(const LoadedRod& rod, const MeasuredShape& measured, int most_contacts, double friction,
                              double most_chance, const Deadline& deadline, int& starts);
/// The one with the most contacts that the points show; null: no equilibrium was found.
const Level* supported_level(const std::vector<Level>& levels);

/// Of force and place of each contact in turn, at this variance of a coordinate.
Eigen::MatrixXd covariance_of(const ShapeFit& fit, double variance);

}  // namespace tendril
