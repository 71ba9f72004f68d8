// What only a grasp has.

#include <cmath>

#include "consistency.hpp"

namespace tendril::results {
namespace {

constexpr double of_grasps = 1e-11;

/// A vector of the palm's frame in the world.
Vec2 turned_by(double angle, Vec2 v) {
  return {std::cos(angle) * v.x - std::sin(angle) * v.y, std::sin(angle) * v.x + std::cos(angle) * v.y};
}

/// What the contacts with the object press on it, in the palm's frame, N.
Vec2 pressed(const Json& contacts, const GripperSpec& gripper) {
  Vec2 sum{};
  for (const Json& contact : contacts) {
    if (contact.at("obstacle_index") == 0) sum += -contact.at("force").get<double>() * pair_of(contact.at("normal"));
  }
  return turned_by(-gripper.angle, sum);
}

}  // namespace

std::vector<ShownRod> shown_rods(const Json& result, const Scene& scene) {
  if (!result.contains("grasp")) return {{"", scene.rod, scene.rod.base_position, scene.rod.base_angle}};
  const GripperSpec& gripper = *scene.gripper;
  std::vector<ShownRod> rods;
  const std::size_t count = result.contains("fingers") ? 2 : 1;
  for (std::size_t i = 0; i < count; ++i) {
    const double side = i == 0 ? 1.0 : -1.0;
    ShownRod shown;
    if (count == 2) shown.name = i == 0 ? "upper" : "lower";
    shown.rod = scene.fingers.empty() ? scene.rod : scene.fingers[i].rod;
    shown.base = gripper.position + turned_by(gripper.angle, {0.0, side * gripper.half_palm});
    const double opened = scene.fingers.empty() ? gripper.finger_angle : scene.fingers[i].finger_angle;
    shown.base_angle = gripper.angle + side * opened;
    rods.push_back(shown);
  }
  return rods;
}

void check_grasp(const Json& result, const Scene& scene, Findings& found) {
  const GripperSpec& gripper = *scene.gripper;
  const Json& grasp = result.at("grasp");
  const double length = scene.rod.length();
  const double palm_distance = result.at("palm_distance").get<double>();
  const Vec2 center = gripper.position + turned_by(gripper.angle, {palm_distance, 0.0});
  const Vec2 written = pair_of(grasp.at("object").at("center"));
  found.near("x of the object", written.x, center.x, of_grasps * length);
  found.near("y of the object", written.y, center.y, of_grasps * length);
  found.near("radius of the object", grasp.at("object").at("radius").get<double>(), gripper.object_diameter / 2.0,
             of_grasps * length);

  Vec2 above = pressed(result.at("contacts"), gripper);
  Vec2 below{above.x, -above.y};
  if (result.contains("fingers")) {
    above = pressed(result.at("fingers").at(0).at("contacts"), gripper);
    below = pressed(result.at("fingers").at(1).at("contacts"), gripper);
  }
  const double size = of_grasps * std::max(1.0, norm(above));
  const double axial = above.x + below.x;
  found.near("axial force", grasp.at("axial_force").get<double>(), axial, size);
  found.near("lateral force", grasp.at("lateral_force").get<double>(), (below.y - above.y) / 2.0, size);
  // Mirrored fingers leave nothing across the axis.
  const Vec2 net = turned_by(gripper.angle, above + below);
  found.near("x of the net force", result.at("net_force").at(0).get<double>(), net.x, size);
  found.near("y of the net force", result.at("net_force").at(1).get<double>(), net.y, size);
  if (!grasp.contains("force_to_limit")) return;

  std::size_t at = 0;
  for (const Json& contact : result.at("contacts")) {
    if (contact.at("obstacle_index") != 0) continue;
    const double limit = scene.fingers.empty() ? scene.contact.max_force : scene.fingers[at].max_force;
    const Json& margin = grasp.at("force_to_limit").at(at++);
    if (std::isfinite(limit)) {
      found.near("force to its limit", margin.get<double>(), limit - contact.at("force").get<double>(), size);
    } else {
      found.that(margin.is_null(), "a force without limit has a distance to it");
    }
  }
  const double stiffness[] = {grasp.at("axial_stiffness").get<double>(), grasp.at("lateral_stiffness").get<double>()};
  found.that(grasp.at("holds_object_along_axis").get<bool>() == (stiffness[0] > 0.0), "whether the object is held");
  for (std::size_t i = 0; i < 2; ++i) {
    found.near("force by 1 mm of place", grasp.at("force_by_1_mm_of_place").at(i).get<double>(), -1e-3 * stiffness[i],
               1e-12 * std::abs(stiffness[i]));
  }
  found.that(grasp.at("force_by_1_percent_of_moment").size() == result.at("moments").size(),
             "one change of the force for each moment");
}

}  // namespace tendril::results
