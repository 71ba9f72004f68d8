#include <algorithm>
#include <cmath>

#include "grasp/frames.hpp"

namespace tendril {
namespace {

/// The object between the finger and its mirror image, or the other finger.
class PinchedObject : public Grip {
 public:
  int starts() const override { return grasp_starts; }
  StartShape start(const Task& task, const Mode& mode, int index) const override {
    return grasp_start(task, mode, index);
  }
  std::string obstruction(const Task& data, double reach) const override;
  void finish(const Task& data, PoseProgram& program, ConstVectorRef x, Plan& plan) const override;
};

/// The distance from the axis that a finger's base may have, as near as can be to this one.
double base_near(const Rod& rod, double across) {
  double low = rod.base.y;
  double high = low;
  for (const Rod::Move& m : rod.moves) {
    low += m.minimum * m.along.y;
    high += m.maximum * m.along.y;
  }
  return std::clamp(across, low, high);
}

std::string metres(double value) { return shown(value) + " m"; }

/// The largest force of one contact, dimensionless.
double carried_by(const Task& finger) {
  return finger.max_force * (finger.friction.empty() ? 1.0 : std::hypot(1.0, finger.friction.front()));
}

/// Why contacts that carry so much, in units of `finger`, cannot hold such a load; empty: they may.
std::string too_heavy(const Task& finger, double load, double carried) {
  if (!(load > carried)) return "";
  const auto newtons = [&](double force) { return shown(finger.scale.to_si(force, dimension::force)) + " N"; };
  return "the object is too heavy: it is loaded with " + newtons(load) + ", and all contacts at their limits carry " +
         newtons(carried);
}

std::string PinchedObject::obstruction(const Task& data, double reach) const {
  const double radius = data.obstacles[0]->smallest_radius();
  const double length = data.scale.length;
  const double farthest = data.palm->maximum;
  if (farthest < radius) {
    return "the object is too large: its radius of " + metres(radius * length) +
           " is more than the largest palm distance, " + metres(farthest * length);
  }
  const bool mirrored = !plans_both_fingers(data.scene);
  if (mirrored) {
    const double carried = data.scene.contact.count * carried_by(data);
    std::string heavy = too_heavy(data, 2.0 * std::abs(data.palm->load), 2.0 * carried);
    if (!heavy.empty()) return heavy;
  }
  // One balanced contact is where the object's normal is square to the axis, if the other finger is the mirror image
  // and nothing but normal forces acts.
  const bool balanced =
      mirrored && data.palm->balance && data.scene.contact.count == 1 && !data.palm->loaded && data.friction.empty();
  const double nearest = data.palm->minimum;
  const double away = balanced ? std::hypot(nearest, base_near(data.rod, radius) - radius)
                               : std::hypot(nearest, base_near(data.rod, 0.0)) - radius;
  if (!(away > reach)) return "";
  const bool by_limit = nearest > radius;
  return std::string("out of reach: the object is too ") + (by_limit ? "far away" : "large") +
         ": at a palm distance of " + metres(nearest * length) +
         (by_limit ? ", the smallest allowed, " : ", its own radius, ") + "the contact is at least " +
         metres(away * length) + " from the finger's base, and this part of the finger ends " + metres(reach * length) +
         " from it";
}

void PinchedObject::finish(const Task& data, PoseProgram& program, ConstVectorRef x, Plan& plan) const {
  const double distance = program.palm_distance(x) * data.scale.length;
  finger_to_world(*data.scene.gripper, distance, plan);
  plan.grasp = grasp_of(data.scene, distance, plan.contacts);
  const FingerResponse one = finger_response(program, x, data.scale);
  // Both fingers answer alike to a move along the axis, and oppositely to one across it, which the mirror image turns
  // into the same sum.
  GraspQuality& quality = plan.grasp->quality.emplace();
  add_finger(quality, FingerName::upper, one, plan.contacts, data.scene.contact.max_force);
  quality.axial_stiffness *= 2.0;
  quality.lateral_stiffness *= 2.0;
}

}  // namespace

std::unique_ptr<const Grip> pinched_object() { return std::make_unique<PinchedObject>(); }

std::string pair_obstruction(const Task& upper, double upper_reach, double lower_reach) {
  // Contacts C + r n and C - r n at distances from the bases (0, w) and (0, -w) of at most a and b: the parallelogram
  // law gives |C|^2 + |r n - (0, w)|^2 <= (a^2 + b^2) / 2. Of bases that are not as far from the axis w is the mean.
  const Task& lower = *upper.lower;
  const double from_lower = lower.term_units.force / upper.term_units.force;
  std::string heavy =
      too_heavy(upper, norm(load_along(upper.scene, upper.scale)), carried_by(upper) + from_lower * carried_by(lower));
  if (!heavy.empty()) return heavy;
  // Normals that tilt are not opposite.
  if (upper.palm->loaded || !upper.friction.empty()) return "";
  const double radius = upper.obstacles[0]->smallest_radius() * upper.scale.length;
  const double nearest = upper.palm->minimum * upper.scale.length;
  const double half_palm = base_near(upper.rod, radius / upper.scale.length) * upper.scale.length;
  const double away = std::hypot(nearest, half_palm - radius);
  const double reach = std::hypot(upper_reach, lower_reach) / std::sqrt(2.0);
  if (!(away > reach)) return "";
  const bool by_limit = nearest > radius * (1.0 + 1e-9);
  return std::string("out of reach: the object is too ") + (by_limit ? "far away" : "large") +
         ": at a palm distance of " + metres(nearest) + (by_limit ? ", the smallest allowed, " : ", its radius, ") +
         "opposite contacts are at least " + metres(away) +
         " from the fingers' bases (root mean square), and these parts of the fingers end " + metres(upper_reach) +
         " and " + metres(lower_reach) + " from them";
}

}  // namespace tendril
