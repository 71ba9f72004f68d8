#pragma once

#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "program/pose_program.hpp"

namespace tendril {

/// Curvature, times L, as a function of the arc length s/L, and the stretch eps of a rod that stretches.
class Curvature : public std::function<double(double)> {
 public:
  using Along = std::function<double(double)>;
  using Along::Along;
  Curvature() = default;
  Curvature(Along curvature, Along stretched = {}) : Along(std::move(curvature)), stretch(std::move(stretched)) {}
  Along stretch{};  ///< empty: none
};

/// A contact and where it stands, dimensionless.
struct PointContact {
  ContactSetup setup;
  double s = 1.0;
  double force = 0.0;
  bool extended = false;  ///< one of a run that stands for a stretch along which the rod lies
  double shear = 0.0;     ///< tangential force along the obstacle's turned normal, where it sticks
  Anchor anchor{};        ///< likewise: from where
};

/// A tendon that is held by its length and pulls.
struct TautTendon {
  int actuator = 0;
  double moment = 0.0;
};

/// A state of the rod, whatever the basis; dimensionless.
struct State {
  Curvature curvature;
  std::vector<PointContact> contacts;
  double load = 0.0;  ///< fraction of a path of loads
  std::vector<TautTendon> tendons{};
};

/// The curvature of coordinates on the pieces of a backbone, which it outlives.
Curvature curvature_of(std::shared_ptr<const CoordinateModel> basis, const Backbone& backbone,
                       ConstVectorRef coordinates);

/// curvature + factor * along.
Curvature moved(const Curvature& curvature, double factor, const Curvature& along);

/// Sorts contacts along the rod, those at the tip last.
void sort_contacts(std::vector<PointContact>& contacts);

/// Puts a contact inside the rod at s, `clearance` off the ends of the stretch between fixed knots that s lies in.
void place_inside(PointContact& contact, double s, const std::vector<double>& knots, double clearance);
/// Hands a contact over the end of its stretch: `clearance` into the next one, or to the tip. False at the base.
bool hand_over(PointContact& contact, bool upward, const std::vector<double>& knots, double clearance);

}  // namespace tendril
