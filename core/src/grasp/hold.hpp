#pragma once

#include <vector>

#include "tendril/plan.hpp"

namespace tendril {

struct Task;

/// A contact that may press on a round object: the object's outward normal there, and the largest normal force.
struct Pad {
  Vec2 normal{};
  double limit = 1.0;
};

/// The coefficient of friction above which contacts with these normals hold a round object against any force and moment
/// if they press hard enough. 0: any friction does. Infinity: none does.
TENDRIL_API double closure_friction(const std::vector<Vec2>& normals);

/// What disturbs a round object (of radius 1) without breaking the hold of rigid contacts: a force on its centre and a
/// moment about it. Each contact presses with 0 to its limit and pushes across with at most `friction` (> 0) times as
/// much. These wrenches are a sum of triangles, so that what is left of them beside the object's own load is a
/// polyhedron: its facets span an edge of one triangle and one of another, and tell every linear program over the cones
/// exactly.
class TENDRIL_API HeldDisturbances {
 public:
  HeldDisturbances(const std::vector<Pad>& pads, double friction, Vec2 load);

  bool holds_load() const { return holds_load_; }
  /// The largest force along a unit vector, without moment, that is held; 0 where the load alone is not.
  double along(Vec2 direction) const;
  /// The smallest force, without moment, beyond which nothing is held in its own direction.
  Vec2 breaking_force() const;
  /// The largest moment of this sign (1 or -1), without force.
  double moment(double sign) const;
  /// Corners of the forces held without moment, in order.
  std::vector<Vec2> corners() const;

 private:
  /// Disturbances are held with force . F + moment M <= room.
  struct Facet {
    Vec2 force{};
    double moment = 0.0;
    double room = 0.0;
  };
  std::vector<Facet> facets_;
  double reach_ = 0.0;  ///< no force beyond is held
  bool holds_load_ = true;
};

/// What friction does for a solved plan; what is not told is left out with its reason.
void tell_hold(const Task& task, Plan& plan);

}  // namespace tendril
