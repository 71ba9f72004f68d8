#include "grasp.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tendril/circle.hpp"
#include "tendril/grasp.hpp"
#include "tendril/wall.hpp"

namespace tendril {
namespace {

/// A contact that holds with less than this share of its limit (without a limit: of EI/L^2) is no grasp.
constexpr double least_share = 1e-3;

Vec2 rotated(Vec2 v, double angle) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  return {c * v.x - s * v.y, s * v.x + c * v.y};
}

Scene finger_scene(const Scene& scene, const std::vector<const char*>& obstacles) {
  Scene finger = scene;
  finger.obstacles.clear();
  for (const char* name : obstacles) {
    ObstacleSpec spec;
    spec.name = name;
    finger.obstacles.push_back(std::move(spec));
  }
  return finger;
}

std::string metres(double value) {
  char text[48];
  std::snprintf(text, sizeof text, "%.6g m", value);
  return text;
}

}  // namespace

Vec2 palm_to_world(const GripperSpec& gripper, Vec2 point) { return gripper.position + rotated(point, gripper.angle); }

Vec2 mirrored(const GripperSpec& gripper, Vec2 point) {
  const Vec2 local = rotated(point - gripper.position, -gripper.angle);
  return palm_to_world(gripper, {local.x, -local.y});
}

Scene finger_in_world(const Scene& scene) {
  const GripperSpec& gripper = *scene.gripper;
  Scene finger = finger_scene(scene, {"object", "other finger"});
  finger.problem = ProblemKind::execute;
  finger.rod.base_position = palm_to_world(gripper, {0.0, gripper.half_palm});
  finger.rod.base_angle = gripper.angle + gripper.finger_angle;
  finger.contact.mode = ContactModeName::allow;
  finger.objectives.clear();
  finger.gripper.reset();
  return finger;
}

std::vector<std::unique_ptr<Obstacle>> obstacles_of_finger(const Scene& scene, double palm_distance) {
  const GripperSpec& gripper = *scene.gripper;
  const Scale scale = scale_of(scene);
  const auto length = [&](double si) { return scale.to_dimensionless(si, dimension::length); };
  const Vec2 center = palm_to_world(gripper, {palm_distance, 0.0});
  std::vector<std::unique_ptr<Obstacle>> all;
  all.push_back(
      std::make_unique<Circle>(Vec2{length(center.x), length(center.y)}, length(0.5 * gripper.object_diameter)));
  all.push_back(std::make_unique<Wall>(Vec2{length(gripper.position.x), length(gripper.position.y)},
                                       rotated({0.0, 1.0}, gripper.angle)));
  return all;
}

Scene finger_in_palm_frame(const Scene& scene) {
  const GripperSpec& gripper = *scene.gripper;
  Scene finger = finger_scene(scene, {"object", "other finger", "palm"});
  finger.rod.base_position = {0.0, gripper.half_palm};
  finger.rod.base_angle = gripper.finger_angle;
  if (finger.gravity) finger.gravity = rotated(*finger.gravity, -gripper.angle);
  finger.tip_load.force = rotated(finger.tip_load.force, -gripper.angle);
  finger.contact.mode = ContactModeName::require;
  return finger;
}

void set_up_grasp(Problem::Data& data) {
  const GripperSpec& gripper = *data.scene.gripper;
  // What an exact rotation leaves of gravity along the axis is rounding.
  if (data.rod.has_gravity() && std::abs(data.rod.gravity.y) > 1e-12) {
    throw SceneError(
        "gravity",
        "gravity has a component across the axis of the gripper: both fingers would have to be planned, "
        "which is not available in this version; expected gravity along the axis, or fingers without mass");
  }
  data.rod.gravity.y = 0.0;
  const auto length = [&](double si) { return data.scale.to_dimensionless(si, dimension::length); };
  const double radius = length(0.5 * gripper.object_diameter);
  data.own_obstacles.push_back(std::make_unique<Circle>(Vec2{0.0, 0.0}, radius));
  data.own_obstacles.push_back(std::make_unique<Wall>(Vec2{0.0, 0.0}, Vec2{0.0, 1.0}));
  data.own_obstacles.push_back(std::make_unique<Wall>(Vec2{0.0, 0.0}, Vec2{1.0, 0.0}));
  for (const auto& obstacle : data.own_obstacles) data.obstacles.push_back(obstacle.get());
  data.carried = 1;
  data.contact_obstacles = 1;

  PalmSetup palm;
  palm.balance = gripper.exact_balance;
  // Without a range: from the palm at the object to the object at the tip of a straight finger.
  palm.minimum = radius;
  palm.maximum = 1.0 + radius;
  if (gripper.palm_distance) palm.minimum = palm.maximum = length(*gripper.palm_distance);
  if (gripper.palm_distance_range) {
    palm.minimum = std::max(radius, length(gripper.palm_distance_range->first));
    palm.maximum = std::min(1.0 + radius, length(gripper.palm_distance_range->second));
  }
  if (palm.minimum > palm.maximum) palm.minimum = palm.maximum;
  data.palm = palm;
  const double unit = std::isfinite(data.max_force) ? data.max_force : 1.0;
  data.min_force =
      std::max(data.scale.to_dimensionless(data.scene.contact.min_force, dimension::force), least_share * unit);
}

std::string grasp_obstruction(const Problem::Data& data, double reach) {
  const double radius = data.obstacles[0]->smallest_radius();
  const double length = data.scale.length;
  const double farthest = data.palm->maximum;
  if (farthest < radius) {
    return "the object is too large: its radius of " + metres(radius * length) +
           " is more than the largest palm distance, " + metres(farthest * length);
  }
  // One balanced contact is where the object's normal is square to the axis.
  const Vec2 base = data.rod.base;
  const bool balanced = data.palm->balance && data.scene.contact.count == 1;
  const double nearest = data.palm->minimum;
  const double away = balanced ? std::hypot(nearest, base.y - radius) : std::hypot(nearest, base.y) - radius;
  if (!(away > reach)) return "";
  const bool by_limit = nearest > radius;
  return std::string("out of reach: the object is too ") + (by_limit ? "far away" : "large") +
         ": at a palm distance of " + metres(nearest * length) +
         (by_limit ? ", the smallest allowed, " : ", its own radius, ") + "the contact is at least " +
         metres(away * length) + " from the finger's base, and this part of the finger ends " + metres(reach * length) +
         " from it";
}

void finish_grasp(const Problem::Data& data, PoseProgram& program, ConstVectorRef x, Plan& plan) {
  const GripperSpec& gripper = *data.scene.gripper;
  const double length = data.scale.length;
  const double distance = program.palm_distance(x) * length;
  for (PlannedContact& c : plan.contacts) {
    c.point = palm_to_world(gripper, c.point + Vec2{distance, 0.0});
    c.normal = rotated(c.normal, gripper.angle);
  }
  plan.grasp = grasp_of(data.scene, distance, plan.contacts);
  plan.grasp->quality = grasp_quality(program, x, data.scale);
  for (const PlannedContact& c : plan.contacts) {
    plan.grasp->quality->force_margins.push_back(data.scene.contact.max_force - c.force);
  }
  for (BackbonePoint& p : plan.backbone) {
    const Vec2 at = palm_to_world(gripper, {p[1] + distance, p[2]});
    p[1] = at.x;
    p[2] = at.y;
    p[3] += gripper.angle;
  }
  if (!plan.backbone.empty()) {
    plan.tip_x = plan.backbone.back()[1];
    plan.tip_y = plan.backbone.back()[2];
    plan.tip_angle = plan.backbone.back()[3];
  }
}

GraspPlan grasp_of(const Scene& scene, double palm_distance, const std::vector<PlannedContact>& contacts) {
  const GripperSpec& gripper = *scene.gripper;
  GraspPlan grasp;
  grasp.palm_distance = palm_distance;
  grasp.object_radius = 0.5 * gripper.object_diameter;
  grasp.object_center = palm_to_world(gripper, {palm_distance, 0.0});
  for (const PlannedContact& c : contacts) {
    if (c.obstacle != 0) continue;
    const Vec2 normal = rotated(c.normal, -gripper.angle);
    grasp.axial_force -= 2.0 * c.force * normal.x;
    grasp.lateral_force += c.force * normal.y;
  }
  grasp.net_force = rotated({grasp.axial_force, 0.0}, gripper.angle);
  return grasp;
}

}  // namespace tendril
