#include "grasp_result.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tables.hpp"
#include "tendril/grasp.hpp"
#include "tendril/scale.hpp"
#include "tendril/tolerances.hpp"

namespace tendril::app {

std::vector<std::optional<double>> pressures_of(const Scene& scene, const std::vector<double>& moments) {
  std::vector<std::optional<double>> pressures;
  for (std::size_t a = 0; a < std::min(moments.size(), scene.rod.actuators.size()); ++a) {
    const double per_pressure = scene.rod.actuators[a].moment_per_pressure;
    pressures.push_back(per_pressure == 0.0 ? std::nullopt : std::optional(moments[a] / per_pressure));
  }
  return pressures;
}

std::string_view turning(const Scene& scene, double moment) {
  const double rounding = tolerance::bounds * scale_of(scene).moment();
  if (std::abs(moment) <= rounding) return "";
  return moment > 0.0 ? "opening" : "closing";
}

void add_grasp(Json& json, const Scene& scene, const Plan& plan) {
  Json pressures = Json::array();
  bool any = false;
  for (const std::optional<double>& p : pressures_of(scene, plan.moments)) {
    any = any || p;
    pressures.push_back(p ? number(*p) : Json(nullptr));
  }
  if (any || plan.grasp) json["pressures"] = std::move(pressures);
  if (!plan.grasp) return;
  const GraspPlan& grasp = *plan.grasp;
  json["palm_distance"] = number(grasp.palm_distance);
  json["net_force"] = numbers({grasp.net_force.x, grasp.net_force.y});
  Json quality{
      {"object",
       {{"center", numbers({grasp.object_center.x, grasp.object_center.y})}, {"radius", number(grasp.object_radius)}}},
      {"axial_force", number(grasp.axial_force)},
      {"lateral_force", number(grasp.lateral_force)}};
  if (grasp.quality) {
    const GraspQuality& q = *grasp.quality;
    quality["force_to_limit"] = numbers(q.force_margins);
    quality["axial_stiffness"] = number(q.axial_stiffness);
    quality["lateral_stiffness"] = number(q.lateral_stiffness);
    quality["holds_object_along_axis"] = q.axial_stiffness > 0.0;
    Json by_moment = Json::array();
    for (const Vec2 f : q.force_by_moment) by_moment.push_back(numbers({f.x, f.y}));
    quality["force_by_1_percent_of_moment"] = std::move(by_moment);
    quality["force_by_1_mm_of_place"] = numbers({-1e-3 * q.axial_stiffness, -1e-3 * q.lateral_stiffness});
  }
  json["grasp"] = std::move(quality);
}

std::string grasp_text(const Scene& scene, const Plan& plan) {
  if (!plan.grasp) return "";
  const DisplayUnits units(scene.rod.length());
  const GraspPlan& grasp = *plan.grasp;
  const auto newtons = [](double f) { return fmt::format("{:.6g} N", f); };
  const auto pair = [&](double along, double across) {
    return newtons(along) + " along, " + newtons(across) + " across the axis";
  };
  Grid grid;
  grid.row({"grasp", ""});
  grid.row({"palm distance", units.lengths(grasp.palm_distance)});
  grid.row({"net force", newtons(grasp.axial_force) + " along the axis (positive: away from the palm)"});
  grid.row({"each finger presses", newtons(grasp.lateral_force) + " across the axis"});
  if (grasp.quality) {
    const GraspQuality& q = *grasp.quality;
    for (const double margin : q.force_margins) {
      grid.row({"force to its limit", std::isfinite(margin) ? newtons(margin) : "no limit"});
    }
    grid.row({"stiffness of the object",
              fmt::format("{:.6g} N/m along, {:.6g} N/m across the axis{}", q.axial_stiffness, q.lateral_stiffness,
                          q.axial_stiffness > 0.0 ? "" : "; at held moments it is driven out along the axis")});
    for (std::size_t a = 0; a < q.force_by_moment.size(); ++a) {
      const std::string_view turns = turning(scene, plan.moments[a]);
      grid.row({fmt::format("1 % of moment {}{}", a + 1, turns.empty() ? "" : fmt::format(" ({})", turns)),
                pair(q.force_by_moment[a].x, q.force_by_moment[a].y)});
    }
    grid.row({"1 mm of its place", pair(-1e-3 * q.axial_stiffness, -1e-3 * q.lateral_stiffness)});
  }
  return '\n' + grid.text("");
}

void add_gripper(FigureScene& figure, const Scene& scene, const Plan& plan) {
  if (!scene.gripper || !plan.grasp) return;
  figure.gripper = scene.gripper;
  figure.base = palm_to_world(*scene.gripper, {0.0, scene.gripper->half_palm});
  figure.base_angle = scene.gripper->angle + scene.gripper->finger_angle;
  FigureScene::Shape object;
  object.name = "object";
  constexpr int corners = 180;
  for (int i = 0; i < corners; ++i) {
    const double turn = 2.0 * std::numbers::pi * i / corners;
    object.outline.push_back(plan.grasp->object_center +
                             plan.grasp->object_radius * Vec2{std::cos(turn), std::sin(turn)});
  }
  figure.obstacles.clear();
  figure.obstacles.push_back(std::move(object));
}

}  // namespace tendril::app
