#include <algorithm>
#include <cmath>
#include <string>

#include "rod/rod.hpp"
#include "tendril/scene.hpp"

namespace tendril {
namespace {

void require_finite(double value, const std::string& path) {
  if (!std::isfinite(value)) throw SceneError(path, "the value " + shown(value) + " must be finite");
}

void require_positive(double value, const std::string& path, const char* what, const char* unit) {
  if (!std::isfinite(value) || !(value > 0.0)) {
    throw SceneError(path, std::string(what) + " must be positive and finite, but is " + shown(value) + " " + unit);
  }
}

void require_not_negative(double value, const std::string& path, const char* what, const char* unit) {
  if (!std::isfinite(value) || value < 0.0) {
    throw SceneError(path, std::string(what) + " must not be negative, but is " + shown(value) + " " + unit);
  }
}

void require_place(const ObstaclePlace& place, const std::string& path) {
  require_finite(place.turn, path + ".turn");
  require_finite(place.shift.x, path + ".shift");
  require_finite(place.shift.y, path + ".shift");
}

void validate_trajectory(const Scene& scene) {
  const std::vector<TargetSpec>& targets = scene.trajectory.targets;
  if (scene.problem != ProblemKind::trajectory) {
    if (!targets.empty()) throw SceneError("trajectory", "[trajectory] needs problem = \"trajectory\"");
    return;
  }
  if (targets.empty()) throw SceneError("trajectory", "problem \"trajectory\" needs targets in [trajectory]");
  if (scene.target.position || scene.target.angle) {
    throw SceneError("target", "a trajectory takes its targets from [trajectory], expected no [target] beside it");
  }
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const std::string index = "[" + std::to_string(i) + "]";
    if (!targets[i].position && !targets[i].angle) throw SceneError("trajectory", "target " + index + " is empty");
    if (targets[i].position) {
      require_finite(targets[i].position->x, "trajectory.positions" + index);
      require_finite(targets[i].position->y, "trajectory.positions" + index);
    }
    if (targets[i].angle) require_finite(*targets[i].angle, "trajectory.angles" + index);
    for (std::size_t k = 0; k < targets[i].obstacles.size(); ++k) {
      const MovedObstacle& m = targets[i].obstacles[k];
      if (m.obstacle < 0 || m.obstacle >= static_cast<int>(scene.obstacles.size())) {
        throw SceneError("trajectory", "target " + index + " moves obstacle " + std::to_string(m.obstacle) + " of " +
                                           std::to_string(scene.obstacles.size()));
      }
      require_place(m.place, "trajectory.obstacle[" + std::to_string(k) + "]");
    }
  }
  if (scene.trajectory.replan_every < 0) {
    throw SceneError("trajectory.replan_every", "expected 0 (only where needed) or more steps, found " +
                                                    std::to_string(scene.trajectory.replan_every));
  }
}

/// Beyond this a coefficient is no friction but glue, or a percentage.
constexpr double largest_friction = 10.0;

void require_friction(double value, const std::string& path) {
  require_not_negative(value, path, "the coefficient of friction", "");
  if (value > largest_friction) {
    throw SceneError(path, "the coefficient of friction is " + shown(value) + ", expected 0 to " +
                               shown(largest_friction) + " (most dry contacts have 0.1 to 1)");
  }
}

void validate_friction(const Scene& scene) {
  require_friction(scene.contact.friction, "contact.friction");
  std::string path = scene.contact.friction > 0.0 ? "contact.friction" : "";
  for (std::size_t i = 0; i < scene.obstacles.size(); ++i) {
    const std::optional<double>& own = scene.obstacles[i].friction;
    const std::string at = "obstacle[" + std::to_string(i) + "].friction";
    if (own) require_friction(*own, at);
    require_place(scene.obstacles[i].place, "obstacle[" + std::to_string(i) + "]");
    if (own.value_or(0.0) > 0.0 && path.empty()) path = at;
  }
  const FrictionState state = scene.contact.friction_state;
  const bool planned = state == FrictionState::any || state == FrictionState::worst;
  const std::string name = state == FrictionState::any ? "\"any\"" : "\"worst\"";
  if (path.empty() && planned) {
    throw SceneError("contact.friction_state", "found " + name + " without friction, expected 'friction' beside it");
  }
  if (path.empty() || state == FrictionState::none) return;
  if (scene.contact.mode == ContactModeName::ignore || scene.contact.mode == ContactModeName::avoid) {
    throw SceneError(path, "there is no friction where contact is not planned (contact mode \"" +
                               std::string(to_string(scene.contact.mode)) + "\")");
  }
  if (!planned || scene.problem == ProblemKind::execute) return;
  if (scene.problem == ProblemKind::estimate) {
    throw SceneError("contact.friction_state",
                     "found " + name + ", which is for plans of poses and grasps, expected \"range\" or \"none\"");
  }
  if (!scene.coordinates.split_at_contact) {
    throw SceneError("coordinates.split_at_contact",
                     "found false, but where tangential forces are planned a rod has a knot at its contact; expected "
                     "true");
  }
}

/// `at`: the actuator.
void validate_law(const ActuatorSpec& a, const std::string& at) {
  const bool tendon = a.kind == ActuatorKind::tendon;
  const std::string path = at + (tendon ? ".moment_per_tension" : ".moment_per_pressure");
  const std::string effort = tendon ? "tension" : "pressure";
  require_finite(a.moment_per_pressure, path);
  for (const double c : a.more_moment_per_pressure) require_finite(c, path);
  if (a.kind == ActuatorKind::pressure && !a.knows_pressure()) {
    throw SceneError(at, "an actuator of kind \"pressure\" has no 'moment_per_pressure'");
  }
  if (tendon && a.has_law()) {
    const double most = a.moment_of(std::isfinite(a.most_pressure) ? a.most_pressure : 1.0);
    if (most * a.largest_offset() < 0.0) {
      throw SceneError(path,
                       "the moment under tension turns the rod away from the tendon, expected one with the sign "
                       "of its offset");
    }
  }
  if (a.more_moment_per_pressure.empty()) return;
  if (!std::isfinite(a.least_pressure) || !std::isfinite(a.most_pressure) || !(a.least_pressure < a.most_pressure)) {
    throw SceneError(path, "a law of several coefficients holds between two values, expected limits of the " + effort);
  }
  constexpr int samples = 200;
  double last = a.moment_of(a.least_pressure);
  double side = 0.0;
  for (int i = 1; i <= samples; ++i) {
    const double p = a.least_pressure + i * (a.most_pressure - a.least_pressure) / samples;
    const double moment = a.moment_of(p);
    if (side == 0.0) side = moment > last ? 1.0 : -1.0;
    if (!(side * (moment - last) > 0.0)) {
      throw SceneError(path, "the moment turns back at a " + effort + " of " + shown(p) + (tendon ? " N" : " Pa") +
                                 ", expected it to rise, or to fall, all the way between the limits of the " + effort);
    }
    last = moment;
  }
}

/// The axial force of a pressure goes with its moment, or the moment tells the pressure.
void validate_pull(const ActuatorSpec& a, const std::string& path) {
  if (a.force_per_pressure.empty()) return;
  for (const double c : a.force_per_pressure) require_finite(c, path);
  if (!a.knows_pressure())
    throw SceneError(path, "an axial force comes with a pressure, expected 'moment_per_pressure'");
  if (a.force_per_pressure.size() > 1 && !(std::isfinite(a.least_pressure) && std::isfinite(a.most_pressure))) {
    throw SceneError(path, "a law of several coefficients needs limits of the pressure on both sides");
  }
  if (a.pulls_in_proportion()) return;
  constexpr int samples = 200;
  const bool limited = !a.more_moment_per_pressure.empty();
  for (int i = 0; limited && i <= samples; ++i) {
    const double p = a.least_pressure + i * (a.most_pressure - a.least_pressure) / samples;
    if (std::isfinite(a.pull_of(a.moment_of(p)).slope)) continue;
    throw SceneError(path, "the moment does not change with the pressure at " + shown(p) +
                               " Pa, expected it to wherever the axial force goes by a law of its own");
  }
}

/// `path`: of the key. `length`: of the rod.
void validate_offset(const ActuatorSpec& a, const std::string& path, double length) {
  if (a.kind != ActuatorKind::tendon) {
    if (!a.offset.empty()) throw SceneError(path, "an offset belongs to an actuator of kind \"tendon\"");
    if (a.by_length) {
      throw SceneError(path.substr(0, path.rfind('.')) + ".control",
                       "a length is held by an actuator of kind \"tendon\"");
    }
    return;
  }
  for (std::size_t i = 0; i < a.offset.size(); ++i) {
    require_finite(a.offset[i].arc_length, path);
    require_finite(a.offset[i].offset, path);
    // The same rounding as at the ends of actuators, and knots that are one are no part.
    if (i > 0 && !(a.offset[i].arc_length > a.offset[i - 1].arc_length + length * knot_merge_distance)) {
      throw SceneError(path, "the table of offsets must ascend, but " + shown(a.offset[i].arc_length) +
                                 " m stands behind " + shown(a.offset[i - 1].arc_length) + " m");
    }
  }
  if (a.largest_offset() == 0.0) {
    throw SceneError(path,
                     "a tendon bends the rod by its distance from the backbone, expected an offset that is not 0");
  }
  const double rounding = length * knot_merge_distance;
  if (a.offset.size() > 1 && (std::abs(a.offset.front().arc_length - a.from) > rounding ||
                              std::abs(a.offset.back().arc_length - a.to) > rounding)) {
    throw SceneError(path, "the table of offsets reaches from " + shown(a.offset.front().arc_length) + " m to " +
                               shown(a.offset.back().arc_length) + " m, expected from " + shown(a.from) + " m to " +
                               shown(a.to) + " m as the tendon does");
  }
  if (std::isnan(a.least_shortening) || std::isnan(a.most_shortening) || a.least_shortening > a.most_shortening ||
      a.least_shortening == infinity || a.most_shortening == -infinity) {
    throw SceneError(path.substr(0, path.rfind('.')) + ".min",
                     "the limits contradict each other: shorter by at least " + shown(a.least_shortening) +
                         " m and at most " + shown(a.most_shortening) + " m");
  }
  const double low = std::min(a.minimum / a.largest_offset(), a.maximum / a.largest_offset());
  if (low < 0.0) {
    throw SceneError(path.substr(0, path.rfind('.')) + ".min",
                     "a tendon only pulls, expected a tension that is not negative, found " + shown(low) + " N");
  }
}

void validate_tolerances(const TargetSpec& target) {
  const auto check = [](double value, bool wanted, const std::string& of, const char* unit) {
    if (value == infinity) return;
    const std::string path = "target." + of + "_tolerance";
    require_positive(value, path, "the tolerance", unit);
    if (!wanted) throw SceneError(path, "found a tolerance without a target, expected '" + of + "' beside it");
  };
  check(target.position_tolerance, target.position.has_value(), "position", "m");
  check(target.angle_tolerance, target.angle.has_value(), "angle", "rad");
}

/// A property that changes along its segment: it has to keep within its range everywhere.
void require_along(double start, const std::vector<double>& more, bool positive, const std::string& path,
                   const char* what, const char* unit) {
  if (more.empty()) return;
  constexpr int samples = 200;
  for (int i = 0; i <= samples; ++i) {
    const double x = static_cast<double>(i) / samples;
    double value = 0.0;
    for (auto c = more.rbegin(); c != more.rend(); ++c) value = (value + *c) * x;
    value += start;
    if (std::isfinite(value) && (positive ? value > 0.0 : value >= 0.0)) continue;
    throw SceneError(path, std::string(what) + " must be " + (positive ? "positive" : "0 or more") +
                               " all along the segment, but is " + shown(value) + " " + unit + " at " + shown(x) +
                               " of its length");
  }
}

void validate_load(const RodLoadSpec& load, double length, const std::string& path) {
  // A part in 1e9 of the length is the rounding of unit conversions, not a mistake.
  if (!(load.from >= 0.0 && load.to >= load.from && load.to > 0.0 && load.to <= length * (1.0 + 1e-9))) {
    throw SceneError(path, "the load acts from " + shown(load.from) + " m to " + shown(load.to) +
                               " m, but the rod reaches from 0 to " + shown(length) + " m");
  }
  require_finite(load.force.x, path + ".force");
  require_finite(load.force.y, path + ".force");
  require_not_negative(load.mass, path + ".mass", "the mass", "kg");
  if (load.mass != 0.0 && load.to != load.from) {
    throw SceneError(path + ".mass", "a mass hangs at one arc length, expected 'from' and 'to' to be equal");
  }
}

constexpr int most_stretch_order = 32;

/// A rod that stretches, and what is not known of one yet.
void validate_stretch(const Scene& scene) {
  const int order = scene.coordinates.stretch_order;
  const std::string path = "coordinates.stretch_order";
  if (order < 0 || order > most_stretch_order) {
    throw SceneError(path, "expected 0 (the rod does not stretch) to " + std::to_string(most_stretch_order) +
                               ", found " + std::to_string(order));
  }
  if (order == 0) return;
  const auto refuse = [&](const std::string& what) {
    throw SceneError(path, what + ", expected a rod that does not stretch");
  };
  if (scene.problem == ProblemKind::grasp) refuse("grasps are planned with fingers of fixed length");
  if (scene.problem == ProblemKind::estimate || !scene.measurement.points.empty()) {
    refuse("forces are estimated on rods of fixed length");
  }
  const std::vector<ActuatorSpec>& actuators = scene.rod.actuators;
  if (std::any_of(actuators.begin(), actuators.end(),
                  [](const ActuatorSpec& a) { return a.kind == ActuatorKind::tendon && a.has_law(); })) {
    refuse("a tendon whose moment goes by 'moment_per_tension' pulls along the rod as its offset has it");
  }
  const std::vector<SegmentSpec>& segments = scene.rod.segments;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const std::string key =
        (segments.size() == 1 ? "rod" : "rod.segment[" + std::to_string(i) + "]") + ".axial_stiffness";
    const SegmentSpec& s = segments[i];
    if (!(s.axial_stiffness > 0.0) || !std::isfinite(s.axial_stiffness)) {
      throw SceneError(key, "a rod that stretches needs an axial stiffness above 0, found " + shown(s.axial_stiffness) +
                                " N, expected 'axial_stiffness', or 'youngs_modulus' and 'diameter'");
    }
    require_along(s.axial_stiffness, s.more_axial_stiffness, true, key, "the axial stiffness", "N");
    if (!s.more_thickness.empty() && needs_obstacles(scene)) {
      refuse("a body whose diameter changes along it touches obstacles where it does not stretch");
    }
  }
}

/// Where something of a base may be moved to holds where searches begin with it.
void require_around(double low, double high, double own, const std::string& path, const char* what,
                    const std::string& unit) {
  require_finite(low, path);
  require_finite(high, path);
  if (low > high) {
    throw SceneError(
        path, "the limits contradict each other: at least " + shown(low) + unit + " and at most " + shown(high) + unit);
  }
  if (own < low || own > high) {
    throw SceneError(path, std::string(what) + " of the base, " + shown(own) + unit + ", lies outside of " +
                               shown(low) + unit + " to " + shown(high) + unit);
  }
}

/// Where the rod may be moved to. `at`: its table.
void validate_place(const RodSpec& rod, const std::string& at) {
  if (rod.base_position_range) {
    const auto& [low, high] = *rod.base_position_range;
    require_around(low.x, high.x, rod.base_position.x, at + ".base.position_range", "the x coordinate", " m");
    require_around(low.y, high.y, rod.base_position.y, at + ".base.position_range", "the y coordinate", " m");
  }
  if (rod.base_angle_range) {
    const auto& [low, high] = *rod.base_angle_range;
    require_around(low, high, rod.base_angle, at + ".base.angle_range", "the angle", " rad");
  }
  if (!(rod.most_drawn_in >= 0.0 && rod.most_drawn_in < rod.length())) {
    throw SceneError(at + ".insertion", "the rod is " + shown(rod.length()) + " m long, but " +
                                            shown(rod.most_drawn_in) +
                                            " m of it are to be drawn into its port, expected at least 0 and less");
  }
  if (!(rod.drawn_in >= 0.0 && rod.drawn_in <= rod.most_drawn_in)) {
    throw SceneError(at + ".insertion", "the rod begins with " + shown(rod.length() - rod.drawn_in) +
                                            " m of it out of its port, expected at least " +
                                            shown(rod.length() - rod.most_drawn_in) + " m and at most " +
                                            shown(rod.length()) + " m");
  }
}

/// What a problem, or another key, has no use for.
void validate_moves(const Scene& scene) {
  const RodSpec& rod = scene.rod;
  const bool inserts = rod.most_drawn_in > 0.0;
  if (!inserts && !rod.base_position_range && !rod.base_angle_range) return;
  const std::string path = inserts ? "rod.insertion" : "rod.base";
  if (scene.problem == ProblemKind::grasp) {
    throw SceneError(path, inserts ? "fingers keep their length, expected no [rod.insertion] of a grasp"
                                   : "the fingers stand on the palm, expected 'half_palm_range' and "
                                     "'finger_angle_range' in [gripper]");
  }
  if (scene.problem == ProblemKind::estimate) {
    throw SceneError(path, "forces are estimated on rods that stand still, expected none of its ranges");
  }
  if (inserts && !scene.coordinates.split_at_contact) {
    throw SceneError(path,
                     "a rod whose insertion is chosen has knots that move with it, expected split_at_contact = "
                     "true in [coordinates]");
  }
}

void require_range(const std::optional<LoadRange>& range, const std::string& path) {
  if (!range) return;
  const auto& [low, high] = *range;
  if (!(low.x <= high.x && low.y <= high.y)) {
    throw SceneError(path, "found a range from (" + shown(low.x) + ", " + shown(low.y) + ") to (" + shown(high.x) +
                               ", " + shown(high.y) + "), expected the least coordinates first");
  }
}

/// `at`: the table of the rod.
void validate_rod(const RodSpec& rod, const std::string& at) {
  if (rod.segments.empty()) throw SceneError(at, "the rod has no length");
  for (std::size_t i = 0; i < rod.segments.size(); ++i) {
    const std::string path = rod.segments.size() == 1 ? at : at + ".segment[" + std::to_string(i) + "]";
    const SegmentSpec& s = rod.segments[i];
    require_positive(s.length, path + ".length", "the length", "m");
    require_positive(s.bending_stiffness, path + ".bending_stiffness", "the bending stiffness", "N m^2");
    require_not_negative(s.linear_density, path + ".linear_density", "the linear density", "kg/m");
    require_finite(s.rest_curvature, path + ".rest_curvature");
    for (const double c : s.more_rest_curvature) require_finite(c, path + ".rest_curvature");
    require_not_negative(s.thickness, path + ".thickness", "the thickness", "m");
    require_not_negative(s.torsional_stiffness, path + ".torsional_stiffness", "the torsional stiffness", "N m^2");
    require_not_negative(s.out_of_plane_stiffness, path + ".out_of_plane_stiffness", "the stiffness out of the plane",
                         "N m^2");
    if ((s.torsional_stiffness > 0.0) != (rod.segments.front().torsional_stiffness > 0.0)) {
      throw SceneError(path + ".torsional_stiffness",
                       "the torsional stiffness must be known of all segments or of none");
    }
    require_along(s.bending_stiffness, s.more_bending_stiffness, true, path + ".bending_stiffness",
                  "the bending stiffness", "N m^2");
    require_along(s.linear_density, s.more_linear_density, false, path + ".linear_density", "the linear density",
                  "kg/m");
    require_along(s.thickness, s.more_thickness, false, path + ".thickness", "the thickness", "m");
  }
  require_finite(rod.base_position.x, at + ".base.position");
  require_finite(rod.base_position.y, at + ".base.position");
  require_finite(rod.base_angle, at + ".base.angle");
  validate_place(rod, at);
  require_range(rod.calibrated_gravity, at + ".calibrated_gravity");
  require_range(rod.calibrated_tip_force, at + ".calibrated_tip_force");
  const double length = rod.length();
  for (std::size_t i = 0; i < rod.loads.size(); ++i) {
    const std::string path = at + ".load[" + std::to_string(i) + "]";
    validate_load(rod.loads[i], length, path);
    require_range(rod.loads[i].calibrated, path + ".calibrated");
  }
  for (std::size_t i = 0; i < rod.actuators.size(); ++i) {
    const std::string path = at + ".actuator[" + std::to_string(i) + "]";
    const ActuatorSpec& a = rod.actuators[i];
    // A part in 1e9 of the length is the rounding of unit conversions, not a mistake.
    if (!(a.from >= 0.0 && a.from < length)) {
      throw SceneError(path + ".from", "the actuator starts at " + shown(a.from) +
                                           " m, but the rod reaches from 0 to " + shown(length) + " m");
    }
    if (!(a.to > a.from && a.to <= length * (1.0 + 1e-9))) {
      throw SceneError(path + ".to", "the actuator ends at " + shown(a.to) + " m, expected more than its start (" +
                                         shown(a.from) + " m) and at most the rod's length (" + shown(length) + " m)");
    }
    if (std::isnan(a.minimum) || std::isnan(a.maximum) || a.minimum > a.maximum) {
      throw SceneError(path + (a.minimum > a.maximum ? ".min" : ".limit"),
                       "the limits contradict each other: at least " + shown(a.minimum) + " N m and at most " +
                           shown(a.maximum) + " N m");
    }
    if (a.minimum == infinity || a.maximum == -infinity) {
      throw SceneError(path + ".limit", "no moment is within the limits");
    }
    if (!(a.calibrated_from <= a.calibrated_to)) {
      throw SceneError(path + ".calibrated", "found a range from " + shown(a.calibrated_from) + " down to " +
                                                 shown(a.calibrated_to) + ", expected the smaller one first");
    }
    validate_law(a, path);
    validate_pull(a, path + ".force_per_pressure");
    validate_offset(a, path + ".offset", length);
  }
}

/// `at`: the table that has the limits.
void require_force_limits(double least, double largest, const std::string& at) {
  require_not_negative(least, at + ".min_force", "the least contact force", "N");
  if (std::isnan(largest) || largest < 0.0) {
    throw SceneError(at + ".max_force",
                     "the largest contact force must not be negative, but is " + shown(largest) + " N");
  }
  if (least > largest) {
    throw SceneError(at + ".min_force", "the limits contradict each other: at least " + shown(least) +
                                            " N and at most " + shown(largest) + " N");
  }
}

void validate_gripper(const Scene& scene) {
  if (scene.problem != ProblemKind::grasp) {
    if (scene.gripper) throw SceneError("gripper", "[gripper] needs problem = \"grasp\"");
    if (!scene.fingers.empty()) throw SceneError("finger", "[[finger]] needs problem = \"grasp\"");
    return;
  }
  if (!scene.gripper) throw SceneError("gripper", "problem \"grasp\" needs a [gripper]");
  const GripperSpec& g = *scene.gripper;
  require_positive(g.half_palm, "gripper.half_palm", "half the palm's width", "m");
  require_positive(g.object_diameter, "gripper.object_diameter", "the object's diameter", "m");
  require_not_negative(g.object_mass, "gripper.object_mass", "the object's mass", "kg");
  require_finite(g.object_force.x, "gripper.object_force");
  require_finite(g.object_force.y, "gripper.object_force");
  if (g.object_mass > 0.0 && !scene.gravity) {
    throw SceneError("gripper.object_mass",
                     "the object of " + shown(g.object_mass) + " kg weighs nothing, expected 'gravity' in the scene");
  }
  constexpr double square = 1.57079632679489662;
  const auto require_away = [](double angle, const std::string& path) {
    if (std::abs(angle) < square) return;
    throw SceneError(path,
                     "the fingers have to point away from the palm: expected an angle between "
                     "-pi/2 and pi/2, found " +
                         shown(angle) + " rad");
  };
  require_away(g.finger_angle, "gripper.finger_angle");
  const auto require_turning = [&](const auto& range, double own, const std::string& path) {
    if (!range) return;
    require_around(range->first, range->second, own, path, "the angle", " rad");
    require_away(range->first, path);
    require_away(range->second, path);
  };
  require_turning(g.finger_angle_range, g.finger_angle, "gripper.finger_angle_range");
  if (g.half_palm_range) {
    const auto& [low, high] = *g.half_palm_range;
    require_around(low, high, g.half_palm, "gripper.half_palm_range", "the distance from the axis", " m");
    require_positive(low, "gripper.half_palm_range", "half the palm's width", "m");
  }
  if (!scene.fingers.empty() && scene.fingers.size() != 2) {
    throw SceneError("finger",
                     "found " + std::to_string(scene.fingers.size()) +
                         " [[finger]], expected two, the upper one and then the lower one; what a finger does "
                         "not state is taken from [rod], [contact] and [gripper]");
  }
  if (!scene.fingers.empty() && g.fingers == Fingers::mirrored) {
    throw SceneError(
        "gripper.fingers",
        "found \"mirrored\" beside [[finger]], expected \"both\": fingers that are described one by one are "
        "planned one by one");
  }
  for (std::size_t i = 0; i < scene.fingers.size(); ++i) {
    const FingerSpec& finger = scene.fingers[i];
    const std::string path = "finger[" + std::to_string(i) + "]";
    validate_rod(finger.rod, path);
    require_away(finger.finger_angle, path + ".angle");
    require_turning(finger.finger_angle_range, finger.finger_angle, path + ".angle_range");
    require_force_limits(finger.min_force, finger.max_force, path);
    if (finger.max_force == 0.0) throw SceneError(path + ".max_force", "a grasp needs a max_force above 0");
    const RodSpec& own = finger.rod;
    if (own.base_position.x != 0.0 || own.base_position.y != 0.0 || own.base_angle != 0.0 || own.base_position_range ||
        own.base_angle_range || own.most_drawn_in > 0.0) {
      throw SceneError(path, "the fingers stand on the palm, expected their place in [gripper]");
    }
  }
  require_finite(g.position.x, "gripper.position");
  require_finite(g.position.y, "gripper.position");
  require_finite(g.angle, "gripper.angle");
  if (g.palm_distance && g.palm_distance_range) {
    throw SceneError("gripper.palm_distance_range",
                     "found 'palm_distance_range' beside 'palm_distance', expected one of them");
  }
  if (g.palm_distance) require_positive(*g.palm_distance, "gripper.palm_distance", "the palm distance", "m");
  if (g.palm_distance_range) {
    require_not_negative(g.palm_distance_range->first, "gripper.palm_distance_range", "the palm distance", "m");
    require_positive(g.palm_distance_range->second, "gripper.palm_distance_range", "the largest palm distance", "m");
    if (g.palm_distance_range->first > g.palm_distance_range->second) {
      throw SceneError("gripper.palm_distance_range", "the limits contradict each other: at least " +
                                                          shown(g.palm_distance_range->first) + " m and at most " +
                                                          shown(g.palm_distance_range->second) + " m");
    }
  }
  if (!scene.obstacles.empty()) {
    throw SceneError("obstacle", "the object of a grasp is in [gripper], expected no [[obstacle]] beside it");
  }
  if (scene.target.position || scene.target.angle) {
    throw SceneError("target", "a grasp has no target pose, expected no [target]");
  }
  if (scene.rod.base_position.x != 0.0 || scene.rod.base_position.y != 0.0 || scene.rod.base_angle != 0.0) {
    throw SceneError("rod.base", "the fingers stand on the palm, expected their place in [gripper]");
  }
  if (scene.contact.mode == ContactModeName::ignore || scene.contact.mode == ContactModeName::avoid) {
    throw SceneError("contact.mode", "a grasp needs contact, expected \"allow\" or \"require\"");
  }
  if (scene.contact.max_force == 0.0) throw SceneError("contact.max_force", "a grasp needs a max_force above 0");
}

/// Beyond this load (EI/L^2) rounding alone is more than bends the rod.
constexpr double largest_load = 1e12;

void validate_loads(const Scene& scene) {
  double mass = scene.tip_load.mass;
  for (const SegmentSpec& s : scene.rod.segments) mass += s.linear_density * s.length;
  double force = norm(scene.tip_load.force);
  if (scene.gripper) {
    mass += scene.gripper->object_mass;
    force += norm(scene.gripper->object_force);
  }
  const double weight = scene.gravity ? mass * norm(*scene.gravity) : 0.0;
  const double load = (weight + force) / scale_of(scene).force();
  if (load <= largest_load) return;
  throw SceneError("rod", "weight and loads are " + shown(load, 3) +
                              " times EI/L^2, the force that bends the rod, and no shape can be computed under more "
                              "than " +
                              shown(largest_load, 3) +
                              ": are the units of length, stiffness, density and loads right?");
}

}  // namespace

void validate(const Scene& scene) {
  validate_rod(scene.rod, "rod");
  validate_stretch(scene);
  validate_moves(scene);
  if (scene.gravity) {
    require_finite(scene.gravity->x, "gravity");
    require_finite(scene.gravity->y, "gravity");
  }
  require_finite(scene.start_tip_angle, "start.tip_angle");
  require_not_negative(scene.tip_load.mass, "tip_load.mass", "the mass", "kg");
  require_finite(scene.tip_load.force.x, "tip_load.force");
  require_finite(scene.tip_load.force.y, "tip_load.force");
  validate_loads(scene);
  if (scene.target.position) {
    require_finite(scene.target.position->x, "target.position");
    require_finite(scene.target.position->y, "target.position");
  }
  if (scene.target.angle) require_finite(*scene.target.angle, "target.angle");
  if (scene.target.turns && !scene.target.angle) {
    throw SceneError("target.turns", "found turns without a direction, expected 'angle' beside them");
  }
  validate_tolerances(scene.target);
  if (!scene.start_points.empty() && (scene.problem == ProblemKind::grasp || scene.problem == ProblemKind::estimate)) {
    throw SceneError("start.points", "found points in a scene of kind \"" + std::string(to_string(scene.problem)) +
                                         "\", expected them for \"pose\" or \"trajectory\"");
  }
  for (const Vec2& point : scene.start_points) {
    require_finite(point.x, "start.points");
    require_finite(point.y, "start.points");
  }

  validate_trajectory(scene);
  validate_gripper(scene);

  const ContactSpec& c = scene.contact;
  require_force_limits(c.min_force, c.max_force, "contact");
  if (c.count < 1) throw SceneError("contact.count", "expected at least 1 contact, found " + std::to_string(c.count));
  if (c.check_points < 0 || c.check_points > 10000) {
    throw SceneError("contact.check_points",
                     "expected 0 (chosen by the planner) to 10000, found " + std::to_string(c.check_points));
  }
  require_positive(c.beta, "contact.beta", "beta", "");
  validate_friction(scene);
  if (c.mode == ContactModeName::require) {
    if (scene.obstacles.empty() && !scene.gripper)
      throw SceneError("contact.mode", "\"require\" needs an obstacle, but the scene has none");
    if (!(c.min_force > 0.0)) {
      throw SceneError("contact.min_force", "\"require\" needs a min_force above 0");
    }
    if (c.max_force == 0.0) throw SceneError("contact.max_force", "\"require\" contradicts a max_force of 0");
  }

  for (std::size_t i = 0; i < scene.objectives.size(); ++i) {
    require_not_negative(scene.objectives[i].weight, "objective[" + std::to_string(i) + "].weight", "the weight", "");
  }
  require_positive(scene.solver.tolerance, "solver.tolerance", "the tolerance", "");
  if (std::isnan(scene.solver.time_limit) || !(scene.solver.time_limit > 0.0)) {
    throw SceneError("solver.time_limit",
                     "the time limit must be positive, but is " + shown(scene.solver.time_limit) + " s");
  }
  if (scene.solver.max_iterations < 1) {
    throw SceneError("solver.max_iterations",
                     "expected at least 1 iteration, found " + std::to_string(scene.solver.max_iterations));
  }
}

Scale scale_of(const Scene& scene) { return {scene.rod.length(), scene.rod.segments.front().bending_stiffness}; }

bool needs_term(const ObjectiveSpec& objective) { return objective.weight != 0.0; }

double friction_of(const Scene& scene, std::size_t i) {
  if (scene.contact.friction_state == FrictionState::none) return 0.0;
  return scene.obstacles[i].friction.value_or(scene.contact.friction);
}

bool needs_obstacles(const Scene& scene) {
  return !scene.obstacles.empty() && scene.contact.mode != ContactModeName::ignore;
}

}  // namespace tendril
