#include "grasp/frames.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "obstacle/circle.hpp"
#include "obstacle/wall.hpp"
#include "tendril/grasp.hpp"

namespace tendril {
namespace {

/// What an exact rotation leaves of a direction along the axis is rounding.
constexpr double rounding_of_direction = 1e-12;

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

/// What the object carries stays as it is in the world where gravity is turned or mirrored for a finger.
void keep_load(const Scene& scene, GripperSpec& gripper) {
  gripper.object_force = object_load(scene);
  gripper.object_mass = 0.0;
}

/// What is known of a grasp before anything touches.
GraspPlan object_at(const Scene& scene, double palm_distance) {
  GraspPlan grasp;
  grasp.palm_distance = palm_distance;
  grasp.object_radius = 0.5 * scene.gripper->object_diameter;
  grasp.object_center = palm_to_world(*scene.gripper, {palm_distance, 0.0});
  grasp.load = object_load(scene);
  return grasp;
}

/// Force of contacts (in the world) on the object, in the palm's frame.
Vec2 pressing(const GripperSpec& gripper, const std::vector<PlannedContact>& contacts) {
  Vec2 force{};
  for (const PlannedContact& c : contacts) {
    if (c.obstacle != 0) continue;
    force += -c.force * rotated(c.normal, -gripper.angle);
    if (c.tangential != 0.0) force += -c.tangential * rotated(c.tangent, -gripper.angle);
  }
  return force;
}

Vec2 mirrored_direction(const GripperSpec& gripper, Vec2 direction) {
  const Vec2 local = rotated(direction, -gripper.angle);
  return rotated({local.x, -local.y}, gripper.angle);
}

/// A finger at the other side of the axis. Moments and coordinates stay those of the upper of the two.
FingerPlan reflected(const GripperSpec& gripper, FingerPlan finger) {
  for (PlannedContact& c : finger.contacts) {
    c.point = mirrored(gripper, c.point);
    c.normal = mirrored_direction(gripper, c.normal);
    c.tangent = mirrored_direction(gripper, c.tangent);
  }
  const auto angle_of = [&](double angle) { return 2.0 * gripper.angle - angle; };
  for (BackbonePoint& p : finger.backbone) {
    const Vec2 at = mirrored(gripper, p.position());
    p = {p.s, at.x, at.y, angle_of(p.angle), -p.curvature};
  }
  if (finger.place.base) {
    BasePose& base = *finger.place.base;
    base = {mirrored(gripper, base.position), angle_of(base.angle)};
  }
  const Vec2 tip = mirrored(gripper, {finger.tip_x, finger.tip_y});
  finger.tip_x = tip.x;
  finger.tip_y = tip.y;
  finger.tip_angle = angle_of(finger.tip_angle);
  return finger;
}

}  // namespace

Vec2 palm_to_world(const GripperSpec& gripper, Vec2 point) { return gripper.position + rotated(point, gripper.angle); }

Vec2 mirrored(const GripperSpec& gripper, Vec2 point) {
  const Vec2 local = rotated(point - gripper.position, -gripper.angle);
  return palm_to_world(gripper, {local.x, -local.y});
}

Vec2 object_load(const Scene& scene) {
  const GripperSpec& gripper = *scene.gripper;
  return scene.gravity ? gripper.object_force + gripper.object_mass * *scene.gravity : gripper.object_force;
}

std::string_view to_string(FingerName finger) { return finger == FingerName::upper ? "upper" : "lower"; }

bool plans_both_fingers(const Scene& scene) {
  if (!scene.gripper || scene.gripper->fingers == Fingers::mirrored) return false;
  if (scene.gripper->fingers == Fingers::both || !scene.fingers.empty()) return true;
  const bool heavy = scene.tip_load.mass != 0.0 ||
                     std::any_of(scene.rod.segments.begin(), scene.rod.segments.end(), [](const SegmentSpec& s) {
                       return s.linear_density != 0.0 || !s.more_linear_density.empty();
                     });
  const auto across = [&](Vec2 direction) {
    return std::abs(rotated(direction, -scene.gripper->angle).y) > rounding_of_direction * norm(direction);
  };
  return (scene.gravity && heavy && across(*scene.gravity)) || across(object_load(scene));
}

Scene finger_of(const Scene& scene, FingerName name) {
  Scene finger = scene;
  GripperSpec& gripper = *finger.gripper;
  keep_load(scene, gripper);
  gripper.fingers = Fingers::both;
  if (!scene.fingers.empty()) {
    const FingerSpec& own = scene.fingers[name == FingerName::upper ? 0 : 1];
    finger.rod = own.rod;
    gripper.finger_angle = own.finger_angle;
    gripper.finger_angle_range = own.finger_angle_range;
    finger.contact.min_force = own.min_force;
    finger.contact.max_force = own.max_force;
    finger.fingers.clear();
  }
  if (name == FingerName::lower && finger.gravity) {
    const Vec2 local = rotated(*finger.gravity, -gripper.angle);
    finger.gravity = rotated({local.x, -local.y}, gripper.angle);
  }
  return finger;
}

Plan plan_of_finger(const Scene& scene, const Plan& plan, FingerName name) {
  Plan own = plan;
  if (name == FingerName::lower) {
    set_finger(own, reflected(*scene.gripper, *plan.grasp->lower));
  }
  own.grasp->lower.reset();
  return own;
}

FingerPlan lower_in_world(const Scene& scene, const Plan& plan) {
  return reflected(*scene.gripper, finger_state(plan));
}

FingerPlan finger_state(const Plan& plan) {
  return {plan.coordinates, plan.moments,   plan.contacts,     plan.backbone, plan.tip_x,
          plan.tip_y,       plan.tip_angle, plan.self_overlap, plan.turns,    plan.place};
}

void set_finger(Plan& plan, FingerPlan finger) {
  plan.coordinates = std::move(finger.coordinates);
  plan.moments = std::move(finger.moments);
  plan.turns = std::move(finger.turns);
  plan.place = finger.place;
  plan.contacts = std::move(finger.contacts);
  plan.backbone = std::move(finger.backbone);
  plan.tip_x = finger.tip_x;
  plan.tip_y = finger.tip_y;
  plan.tip_angle = finger.tip_angle;
  plan.self_overlap = finger.self_overlap;
}

Scene finger_in_world(const Scene& scene) {
  const GripperSpec& gripper = *scene.gripper;
  Scene finger =
      plans_both_fingers(scene) ? finger_scene(scene, {"object"}) : finger_scene(scene, {"object", "other finger"});
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
  if (plans_both_fingers(scene)) return all;
  all.push_back(std::make_unique<Wall>(Vec2{length(gripper.position.x), length(gripper.position.y)},
                                       rotated({0.0, 1.0}, gripper.angle)));
  return all;
}

Scene finger_in_palm_frame(const Scene& scene) {
  const GripperSpec& gripper = *scene.gripper;
  const bool both = plans_both_fingers(scene);
  Scene finger =
      both ? finger_scene(scene, {"object", "palm"}) : finger_scene(scene, {"object", "other finger", "palm"});
  // Gravity is turned below: from here on it says nothing about the axis.
  keep_load(scene, *finger.gripper);
  finger.gripper->fingers = both ? Fingers::both : Fingers::mirrored;
  finger.rod.base_position = {0.0, gripper.half_palm};
  finger.rod.base_angle = gripper.finger_angle;
  if (gripper.half_palm_range) {
    const auto [low, high] = *gripper.half_palm_range;
    finger.rod.base_position_range = {{0.0, low}, {0.0, high}};
  }
  finger.rod.base_angle_range = gripper.finger_angle_range;
  if (finger.gravity) finger.gravity = rotated(*finger.gravity, -gripper.angle);
  finger.tip_load.force = rotated(finger.tip_load.force, -gripper.angle);
  for (RodLoadSpec& load : finger.rod.loads) load.force = rotated(load.force, -gripper.angle);
  finger.contact.mode = ContactModeName::require;
  return finger;
}

Vec2 load_along(const Scene& scene, const Scale& scale) {
  const Vec2 load = rotated(object_load(scene), -scene.gripper->angle);
  Vec2 out{scale.to_dimensionless(load.x, dimension::force), scale.to_dimensionless(load.y, dimension::force)};
  if (std::abs(out.y) <= rounding_of_direction * norm(out)) out.y = 0.0;
  return out;
}

void set_up_grasp(Task& data) {
  const GripperSpec& gripper = *data.scene.gripper;
  const bool mirrored = !plans_both_fingers(data.scene);
  if (std::abs(data.rod.gravity.y) <= rounding_of_direction) data.rod.gravity.y = 0.0;
  if (mirrored && data.rod.has_gravity() && data.rod.gravity.y != 0.0) {
    throw SceneError("gravity",
                     "gravity has a component across the axis of the gripper, so that mirrored fingers cannot both be "
                     "in equilibrium; expected fingers = \"both\" in [gripper], gravity along the axis, or fingers "
                     "without mass");
  }
  const Vec2 load = load_along(data.scene, data.scale);
  if (mirrored && std::abs(load.y) > rounding_of_direction * norm(load)) {
    throw SceneError("gripper.fingers",
                     "what the object carries has a component across the axis, which mirrored fingers cannot balance; "
                     "expected fingers = \"both\"");
  }
  if (norm(load) != 0.0 && !gripper.exact_balance) {
    throw SceneError("gripper.balance", "found \"objective\", but the object is loaded; expected \"exact\"");
  }
  const auto length = [&](double si) { return data.scale.to_dimensionless(si, dimension::length); };
  const double radius = length(0.5 * gripper.object_diameter);
  data.own_obstacles.push_back(std::make_unique<Circle>(Vec2{0.0, 0.0}, radius));
  if (mirrored) data.own_obstacles.push_back(std::make_unique<Wall>(Vec2{0.0, 0.0}, Vec2{0.0, 1.0}));
  data.own_obstacles.push_back(std::make_unique<Wall>(Vec2{0.0, 0.0}, Vec2{1.0, 0.0}));
  for (const auto& obstacle : data.own_obstacles) data.obstacles.push_back(obstacle.get());
  const FrictionState state = data.scene.contact.friction_state;
  if (const double friction = friction_of(data.scene, 0);
      (state == FrictionState::any || state == FrictionState::worst) && friction > 0.0) {
    data.friction.assign(data.obstacles.size(), friction);
  }
  data.carried = 1;
  data.contact_obstacles = 1;

  PalmSetup palm;
  palm.balance = gripper.exact_balance;
  palm.loaded = norm(load) != 0.0;
  if (mirrored) palm.load = 0.5 * load.x;
  // Without a range: from the palm at the object to the object at the tip of a straight finger.
  palm.minimum = radius;
  palm.maximum = 1.0 + radius;
  if (gripper.palm_distance) palm.minimum = palm.maximum = length(*gripper.palm_distance);
  if (gripper.palm_distance_range) {
    palm.minimum = std::max(radius, length(gripper.palm_distance_range->first));
    palm.maximum = std::min(1.0 + radius, length(gripper.palm_distance_range->second));
  }
  if (palm.minimum > palm.maximum) palm.minimum = palm.maximum;
  if (!data.friction.empty() && state == FrictionState::worst) {
    if (!mirrored) {
      throw SceneError("contact.friction_state",
                       "found \"worst\", which is for fingers that are each other's mirror image; expected \"range\", "
                       "\"any\" or \"none\" where both are planned");
    }
    if (!palm.balance) {
      throw SceneError("gripper.balance",
                       "found \"objective\", but its object has to be in balance without friction; expected \"exact\"");
    }
  }
  data.palm = palm;
  data.grip = pinched_object();
  const double unit = std::isfinite(data.max_force) ? data.max_force : 1.0;
  data.min_force =
      std::max(data.scale.to_dimensionless(data.scene.contact.min_force, dimension::force), least_share * unit);
}

void finger_to_world(const GripperSpec& gripper, double distance, Plan& plan) {
  for (PlannedContact& c : plan.contacts) {
    c.point = palm_to_world(gripper, c.point + Vec2{distance, 0.0});
    c.normal = rotated(c.normal, gripper.angle);
    c.tangent = rotated(c.tangent, gripper.angle);
  }
  for (BackbonePoint& p : plan.backbone) {
    const Vec2 at = palm_to_world(gripper, {p.x + distance, p.y});
    p.x = at.x;
    p.y = at.y;
    p.angle += gripper.angle;
  }
  if (plan.place.base) {
    BasePose& base = *plan.place.base;
    base = {palm_to_world(gripper, base.position + Vec2{distance, 0.0}), base.angle + gripper.angle};
  }
  if (!plan.backbone.empty()) {
    plan.tip_x = plan.backbone.back().x;
    plan.tip_y = plan.backbone.back().y;
    plan.tip_angle = plan.backbone.back().angle;
  }
}

GraspPlan grasp_of(const Scene& scene, double palm_distance, const std::vector<PlannedContact>& contacts) {
  const GripperSpec& gripper = *scene.gripper;
  GraspPlan grasp = object_at(scene, palm_distance);
  const Vec2 force = pressing(gripper, contacts);
  grasp.axial_force = 2.0 * force.x + rotated(grasp.load, -gripper.angle).x;
  grasp.lateral_force = -force.y;
  grasp.net_force = rotated({grasp.axial_force, 0.0}, gripper.angle);
  return grasp;
}

GraspPlan grasp_of(const Scene& scene, double palm_distance, const std::vector<PlannedContact>& upper,
                   const std::vector<PlannedContact>& lower) {
  const GripperSpec& gripper = *scene.gripper;
  GraspPlan grasp = object_at(scene, palm_distance);
  const Vec2 from_above = pressing(gripper, upper);
  const Vec2 from_below = pressing(gripper, lower);
  const Vec2 net = from_above + from_below + rotated(grasp.load, -gripper.angle);
  grasp.axial_force = net.x;
  grasp.lateral_force = 0.5 * (from_below.y - from_above.y);
  grasp.net_force = rotated(net, gripper.angle);
  return grasp;
}

}  // namespace tendril
