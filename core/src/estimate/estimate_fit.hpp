#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "base/deadline.hpp"
#include "estimate/loaded_rod.hpp"

namespace tendril {

/// What is known of force and arc length of each contact in turn before the points are seen: `root` times what they
/// differ from `mean` by are independent numbers, each with the standard deviation of a coordinate. No rows: nothing.
struct Belief {
  Eigen::VectorXd mean{};
  Eigen::MatrixXd root{};
};

/// Measured backbone points, dimensionless.
struct MeasuredShape {
  std::vector<double> arc_lengths;
  Eigen::VectorXd points;      ///< x and y in turn
  double noise = 0.0;          ///< standard deviation of a coordinate; 0: not known
  double least_noise = 1e-12;  ///< where it is not known: rounding
  Belief before{};             ///< of as many contacts as are fitted, where the noise is known

  int degrees_of_freedom(int contacts) const { return static_cast<int>(points.size()) - 2 * contacts; }
  /// Variance of a coordinate, as far as it is known when `sum` of squares is left over by `contacts`.
  double variance(double sum, int contacts) const;
};

/// A rod shape that comes as near to the measured points as forces and their places allow, locally.
struct ShapeFit {
  LoadedRod::Shape shape;
  LoadedRod::Response response;  ///< its rates end with the rows of what was known before
  Eigen::VectorXd residual;      ///< points of the shape less measured ones; likewise
  double sum = 0.0;              ///< of its squares
  bool converged = false;

  int contacts() const { return static_cast<int>(shape.forces.size()); }
};

/// Share of the length by which a measured point may lie beyond the tip and counts as there: the rounding of six
/// digits, as tables have them, in another unit than the rod's.
inline constexpr double beyond_tip = 1e-5;

/// A fit has converged when the next step is this small, in standard deviations of what is estimated: while places are
/// still compared, and at the end.
inline constexpr double search_accuracy = 1e-2;
inline constexpr double final_accuracy = 1e-6;

/// Levenberg and Marquardt's method over the places of the contacts, from `start`. In each step the forces, which act
/// almost linearly, follow at their best (variable projection): contacts close together would else form a long curved
/// valley. The shape follows by the implicit function theorem. Leans stay as they are, or are fitted, too, within plus
/// and minus `friction`.
ShapeFit fit_shape(const LoadedRod& rod, const MeasuredShape& measured, const LoadedRod::Shape& start, double accuracy,
                   int most_steps, const Deadline& deadline, double friction = 0.0);

/// The backbone's curvature as the measured points show it: a smooth polynomial through the directions of chords. Good
/// enough to start from.
LoadedRod::Curvature measured_curvature(const Rod& rod, const MeasuredShape& measured);
/// Largest change of direction between chords, a measure of how far the rod turns (radians).
double measured_turn(const Rod& rod, const MeasuredShape& measured);

/// Fits with `contacts` contacts (1 or 2) from many starts, and with them the local minima.
/// `fewer`: the fit with one contact less, if it converged. Best first; those
/// that ran out of steps are not converged.
std::vector<ShapeFit> search(const LoadedRod& rod, const MeasuredShape& measured, const LoadedRod::Curvature& curvature,
                             int contacts, const ShapeFit& fewer, const Deadline& deadline, int& starts);

/// Arc lengths spread over the rod, none at its ends.
std::vector<NormalForce> spread_places(int count);

/// LoadedRod::influence() on the residuals of a fit: what was known before does not move.
Eigen::MatrixXd influence_of(const LoadedRod& rod, const MeasuredShape& measured, const ShapeFit& fit,
                             std::span<const NormalForce> places);

/// Forces to begin a fit with, and by how much they would lessen the sum of squares if the rod answered linearly.
struct Candidate {
  std::vector<NormalForce> forces;
  double improvement = 0.0;
};
/// One force more than a fit has, while the others follow at their best; at most `count`, best first.
std::vector<Candidate> one_more(const LoadedRod& rod, const MeasuredShape& measured, const ShapeFit& fit,
                                std::size_t count);

}  // namespace tendril
