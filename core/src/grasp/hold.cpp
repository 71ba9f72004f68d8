#include "grasp/hold.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "search/task.hpp"
#include "tendril/grasp.hpp"
#include "tendril/tolerances.hpp"

namespace tendril {
namespace {

constexpr double rounding = 1e-12;  ///< of unit vectors and of forces in the largest limit

/// A wrench: force, and moment about the centre of an object of radius 1.
struct Wrench {
  Vec2 force{};
  double moment = 0.0;
};

Wrench operator-(const Wrench& a, const Wrench& b) { return {a.force - b.force, a.moment - b.moment}; }
double dot(const Wrench& a, const Wrench& b) { return dot(a.force, b.force) + a.moment * b.moment; }
Wrench cross(const Wrench& a, const Wrench& b) {
  return {{a.force.y * b.moment - a.moment * b.force.y, a.moment * b.force.x - a.force.x * b.moment},
          cross(a.force, b.force)};
}

/// What a contact that is about to slip does to the object per unit of its normal force; `lean`: along the turned
/// normal.
Wrench slipping(Vec2 normal, double lean) { return {-(normal + lean * turned(normal)), -lean}; }

/// Corners of a convex area that lie in along . p <= room, and those that the line makes.
std::vector<Vec2> clipped(const std::vector<Vec2>& corners, Vec2 along, double room) {
  std::vector<Vec2> left;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec2 a = corners[i];
    const Vec2 b = corners[(i + 1) % corners.size()];
    const double over_a = dot(along, a) - room;
    const double over_b = dot(along, b) - room;
    if (over_a <= 0.0) left.push_back(a);
    if ((over_a < 0.0 && over_b > 0.0) || (over_a > 0.0 && over_b < 0.0)) {
      left.push_back(a + (over_a / (over_a - over_b)) * (b - a));
    }
  }
  return left;
}

}  // namespace

/// A force and a moment are not held only if some motion, a shift along v with a rotation, is opposed by no contact:
/// v . n >= friction |v . tau + rotation| for all of them. That asks for normals within a half plane, and then any two
/// of them, at angles a and b from v, leave a rotation only if friction tan((a - b) / 2) <= 1.
double closure_friction(const std::vector<Vec2>& normals) {
  constexpr double full = 2.0 * std::numbers::pi;
  std::vector<double> angles;
  angles.reserve(normals.size());
  for (const Vec2 n : normals) angles.push_back(std::atan2(n.y, n.x));
  std::sort(angles.begin(), angles.end());
  if (angles.empty()) return infinity;
  double gap = angles.front() + full - angles.back();
  for (std::size_t i = 1; i < angles.size(); ++i) gap = std::max(gap, angles[i] - angles[i - 1]);
  const double half = 0.5 * (full - gap);
  if (half >= 0.5 * std::numbers::pi - rounding) return 0.0;
  return half > rounding ? 1.0 / std::tan(half) : infinity;
}

HeldDisturbances::HeldDisturbances(const std::vector<Pad>& pads, double friction, Vec2 load) {
  std::vector<Wrench> edges;
  for (const Pad& pad : pads) {
    const Wrench one = slipping(pad.normal, friction);
    const Wrench other = slipping(pad.normal, -friction);
    edges.insert(edges.end(), {one, other, one - other});
    reach_ += pad.limit * norm(one.force);
  }
  reach_ += norm(load);
  const auto add = [&](const Wrench& along) {
    double room = -dot(along.force, load);
    for (const Pad& pad : pads) {
      const double most =
          std::max(-dot(along, slipping(pad.normal, friction)), -dot(along, slipping(pad.normal, -friction)));
      room += pad.limit * std::max(0.0, most);
    }
    holds_load_ = holds_load_ && room >= -rounding * reach_;
    facets_.push_back({along.force, along.moment, std::max(0.0, room)});
  };
  for (std::size_t i = 0; i < edges.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const Wrench normal = cross(edges[i], edges[j]);
      const double size = std::sqrt(dot(normal, normal));
      const double sizes = std::sqrt(dot(edges[i], edges[i]) * dot(edges[j], edges[j]));
      if (!(size > rounding * sizes)) continue;
      for (const double sign : {1.0, -1.0}) add({(sign / size) * normal.force, sign / size * normal.moment});
    }
  }
}

double HeldDisturbances::along(Vec2 direction) const {
  double most = holds_load_ ? infinity : 0.0;
  for (const Facet& f : facets_) {
    const double rise = dot(f.force, direction);
    if (rise > rounding) most = std::min(most, f.room / rise);
  }
  return most;
}

Vec2 HeldDisturbances::breaking_force() const {
  double least = holds_load_ ? infinity : 0.0;
  Vec2 direction{};
  for (const Facet& f : facets_) {
    const double size = norm(f.force);
    if (!(size > rounding) || !(f.room < least * size)) continue;
    least = f.room / size;
    direction = (1.0 / size) * f.force;
  }
  return least < infinity ? least * direction : Vec2{infinity, infinity};
}

double HeldDisturbances::moment(double sign) const {
  double most = holds_load_ ? infinity : 0.0;
  for (const Facet& f : facets_) {
    if (sign * f.moment > rounding) most = std::min(most, f.room / (sign * f.moment));
  }
  return most;
}

std::vector<Vec2> HeldDisturbances::corners() const {
  if (!holds_load_) return {};
  const double far = 2.0 * reach_;
  std::vector<Vec2> area{{far, far}, {-far, far}, {-far, -far}, {far, -far}};
  for (const Facet& f : facets_) {
    if (norm(f.force) > rounding) area = clipped(area, f.force, f.room);
  }
  // Facets that meet in a corner leave it more than once.
  std::vector<Vec2> corners;
  for (const Vec2 p : area) {
    if (corners.empty() || norm(p - corners.back()) > 1e3 * rounding * reach_) corners.push_back(p);
  }
  while (corners.size() > 1 && norm(corners.front() - corners.back()) <= 1e3 * rounding * reach_) corners.pop_back();
  return corners;
}

std::optional<GraspLift> lift_of(const Scene& scene, const GraspPlan& grasp) {
  const double mass = scene.gripper ? scene.gripper->object_mass : 0.0;
  const double gravity = scene.gravity ? norm(*scene.gravity) : 0.0;
  if (!grasp.hold || grasp.hold->held_forces.size() < 3 || !(mass * gravity > 0.0)) return std::nullopt;
  const std::vector<Vec2>& corners = grasp.hold->held_forces;
  const Vec2 weight = mass * *scene.gravity;
  GraspLift lift{infinity, infinity};
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec2 edge = corners[(i + 1) % corners.size()] - corners[i];
    const Vec2 out = (1.0 / norm(edge)) * turned_back(edge);
    // How far from the object's weight, and from none, the forces beyond this edge are.
    const double room = std::max(0.0, dot(out, corners[i]));
    const double along = dot(out, weight);
    if (along > 0.0) lift.acceleration = std::min(lift.acceleration, gravity * room / along);
    lift.heaviest_turned = std::min(lift.heaviest_turned, std::max(0.0, room + along) / gravity);
  }
  return lift;
}

void tell_hold(const Task& task, Plan& plan) {
  if (!plan.grasp || plan.status != PlanStatus::solved) return;
  const double friction = friction_of(task.scene, 0);
  if (!(friction > 0.0)) return;
  const GripperSpec& gripper = *task.scene.gripper;
  const double trace = tolerance::force * task.scene_scale.force();
  std::vector<Pad> pads;
  const auto add = [&](const std::vector<PlannedContact>& contacts, double limit, bool image) {
    for (const PlannedContact& c : contacts) {
      if (c.obstacle != 0 || !(c.force > trace)) continue;
      pads.push_back({image ? mirrored(gripper, c.normal) - mirrored(gripper, {}) : c.normal, limit});
    }
  };
  const double limit = task.scene.contact.max_force;
  const bool both = plan.grasp->lower.has_value();
  add(plan.contacts, limit, false);
  add(both ? plan.grasp->lower->contacts : plan.contacts, both ? task.lower->scene.contact.max_force : limit, !both);

  GraspHold& hold = plan.grasp->hold.emplace();
  std::vector<Vec2> normals;
  double unit = 0.0;
  for (const Pad& pad : pads) {
    normals.push_back(pad.normal);
    unit = std::max(unit, pad.limit);
  }
  hold.friction = friction;
  hold.closure_friction = closure_friction(normals);
  // At the edge of its cone a planned contact is so exactly, but for rounding.
  hold.closure = friction > hold.closure_friction * (1.0 + tolerance::bounds);
  hold.breaking_force = {infinity, infinity};
  hold.least_moment = -infinity;
  hold.largest_moment = infinity;
  if (!std::isfinite(unit)) {
    plan.left_out.push_back(
        {"disturbances that the grasp holds", "contact forces have no limit ([contact] max_force)"});
    return;
  }
  for (Pad& pad : pads) pad.limit /= unit;
  const HeldDisturbances held(pads, friction, (1.0 / unit) * plan.grasp->load);
  for (const Vec2 corner : held.corners()) hold.held_forces.push_back(unit * corner);
  hold.breaking_force = unit * held.breaking_force();
  hold.least_moment = -unit * plan.grasp->object_radius * held.moment(-1.0);
  hold.largest_moment = unit * plan.grasp->object_radius * held.moment(1.0);
}

}  // namespace tendril
