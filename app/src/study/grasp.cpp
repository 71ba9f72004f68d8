#include "study/grasp.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "result/grasp_result.hpp"
#include "study/case.hpp"
#include "system/tables.hpp"
#include "tendril/grasp.hpp"
#include "tendril/tolerances.hpp"

namespace tendril::app {

namespace {

std::size_t actuators(const StudyResult& result) {
  std::size_t most = 0;
  for (const Json& value : result.values) {
    const auto found = value.find("moments");
    if (found != value.end()) most = std::max(most, found->size());
  }
  return most;
}

bool of_grasps(const StudyResult& result) {
  return std::any_of(result.values.begin(), result.values.end(),
                     [](const Json& value) { return value.contains("axial_force"); });
}

double number_in(const Json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_number() ? found->get<double>() : std::nan("");
}

}  // namespace

void run_grasp_case(Session& session, const StudyCase& one, Json& json) {
  Plan plan = session.plan_from(nullptr);
  const Scene& scene = session.scene();
  json["diameter"] = number(scene.gripper->object_diameter);
  json["force_limit"] = number(scene.contact.max_force);
  json["moment_change"] = nullptr;
  if (one.pressure) json["pressure_change"] = number(*one.pressure);
  Plan reached = plan;
  Plan applied = plan;  // whose moments were applied
  if (plan.status == PlanStatus::solved) {
    reached = session.verify(plan, std::nullopt)->result;
    applied = plan;
    std::vector<double> told = held_of(finger_in_world(scene), plan);
    const double distance = plan.grasp->palm_distance;
    json["model_error"] = plan.model_error ? number(*plan.model_error) : Json(nullptr);
    if (one.changes_input() && !told.empty()) {
      applied.moments.back() = told.back() = one.held(scene.rod.actuators.back(), told.back());
      json["moment_change"] = number(one.moment.value_or(told.back() - plan.moments.back()));
      ExecuteControl control;
      control.start = &plan;
      reached = execute(finger_in_world(scene), obstacles_of_finger(scene, distance), told, control).result;
      if (reached.status != PlanStatus::solved) {
        plan.status = reached.status;
        plan.message = fmt::format("with the {} changed: {}", one.pressure ? "pressure" : "moment", reached.message);
      }
    }
    const GraspPlan held = reached.grasp && reached.grasp->lower
                               ? grasp_of(scene, distance, reached.contacts, reached.grasp->lower->contacts)
                               : grasp_of(scene, distance, reached.contacts);
    json["palm_distance"] = number(distance);
    json["axial_force"] = number(held.axial_force);
    json["lateral_force"] = number(held.lateral_force);
    json["planned_axial_force"] = number(plan.grasp->axial_force);
    json["planned_moment"] = plan.moments.empty() ? Json(nullptr) : number(plan.moments.back());
    json["at_tip"] = std::any_of(reached.contacts.begin(), reached.contacts.end(),
                                 [](const PlannedContact& c) { return c.at_tip && c.obstacle == 0; });
    json["axial_stiffness"] = plan.grasp->quality ? number(plan.grasp->quality->axial_stiffness) : Json(nullptr);
    Json object = Json::array();
    object.push_back(numbers({held.object_center.x, held.object_center.y, held.object_radius}));
    json["objects"] = std::move(object);
  }
  json["status"] = to_string(plan.status);
  // What is carried out may hold moments beyond their limits.
  json["message"] = plan.message.empty() ? reached.message : plan.message;
  json["bounds"] = number(reached.certificate.bounds);
  json["moments"] = numbers(all_moments(applied));
  Json where = Json::array();
  for (const ShownActuator& a : shown_actuators(scene, applied)) where.push_back(a.where);
  json["where"] = std::move(where);
  Json pressures = Json::array();
  for (const std::optional<double>& p : pressures_of(scene, applied))
    pressures.push_back(p ? number(*p) : Json(nullptr));
  json["pressures"] = std::move(pressures);
  double force = 0.0;
  for (const PlannedContact& c : plan.contacts) force += c.force;
  json["contact_force"] = plan.backbone.empty() ? Json(nullptr) : number(force);
  Json lines = Json::array();
  if (!reached.backbone.empty()) {
    Json upper = Json::array();
    Json lower = Json::array();
    const std::size_t stride = std::max<std::size_t>(1, reached.backbone.size() / 40);
    const bool both = reached.grasp && reached.grasp->lower;
    for (std::size_t i = 0; i < reached.backbone.size(); i += stride) {
      const Vec2 p = reached.backbone[i].position();
      const Vec2 q = mirrored(*scene.gripper, p);
      upper.push_back(numbers({p.x, p.y}));
      if (!both) lower.push_back(numbers({q.x, q.y}));
    }
    if (both) {
      const std::vector<BackbonePoint>& backbone = reached.grasp->lower->backbone;
      const std::size_t step = std::max<std::size_t>(1, backbone.size() / 40);
      for (std::size_t i = 0; i < backbone.size(); i += step) lower.push_back(numbers({backbone[i].x, backbone[i].y}));
    }
    lines.push_back(std::move(upper));
    lines.push_back(std::move(lower));
  }
  json["lines"] = std::move(lines);
  json["plan"] = plan_object(scene, plan);
}

std::string grasp_columns(const StudyResult& result) {
  if (!of_grasps(result)) return "";
  std::string text =
      ",diameter_m,force_limit_N,moment_change_Nm,palm_distance_m,axial_force_N,lateral_force_N,axial_stiffness_N_per_"
      "m";
  for (std::size_t i = 0; i < actuators(result); ++i) text += fmt::format(",pressure_{}_Pa", i + 1);
  return text;
}

std::string grasp_cells(const StudyResult& result, std::size_t index) {
  if (!of_grasps(result)) return "";
  const Json& value = result.values[index];
  std::string text = fmt::format(",{},{},{},{},{},{},{}", csv_number(value, "diameter"),
                                 csv_number(value, "force_limit"), csv_number(value, "moment_change"),
                                 csv_number(value, "palm_distance"), csv_number(value, "axial_force"),
                                 csv_number(value, "lateral_force"), csv_number(value, "axial_stiffness"));
  for (std::size_t i = 0; i < actuators(result); ++i) text += ',' + csv_number(value, "pressures", i);
  return text;
}

std::string grasp_study_report(const Scene& scene, const StudyResult& result) {
  const DisplayUnits units(scene);
  const bool sweep =
      std::any_of(result.cases.begin(), result.cases.end(), [](const StudyCase& c) { return c.changes_input(); });
  // Changes of a moment are changes of a pressure where the two go together.
  const bool linear = !scene.rod.actuators.empty() && scene.rod.actuators.back().more_moment_per_pressure.empty();
  const double per_pressure = linear ? scene.rod.actuators.back().moment_per_pressure : 0.0;
  const auto changed = [&](const StudyCase& c, const Json& value) {
    const double moment = number_in(value, "moment_change");
    if (!std::isfinite(moment)) return std::string("-");
    const double pressure = c.pressure ? *c.pressure : per_pressure == 0.0 ? std::nan("") : moment / per_pressure + 0.0;
    return units.moment(moment) + (std::isfinite(pressure) ? " (" + units.pressure(pressure) + ")" : "");
  };
  Grid grid;
  grid.row({"diameter", "force limit", "status", sweep ? "last moment" : "contact", "palm distance", "moments",
            "pressures", "where", "lateral force", "axial force", "axial stiffness", "model error"});
  std::string trouble;
  bool opening = false;
  for (std::size_t i = 0; i < result.cases.size(); ++i) {
    const Json& v = result.values[i];
    const auto text = [&](const char* key, const char* unit) {
      const double x = number_in(v, key);
      return std::isfinite(x) ? fmt::format("{:.4g} {}", x, unit) : std::string("-");
    };
    const auto length = [&](const char* key) {
      const double x = number_in(v, key);
      return std::isfinite(x) ? units.lengths(x) : std::string("-");
    };
    const auto listed = [&](const char* key, const auto& shown) {
      std::string all;
      const auto list = v.find(key);
      for (const Json& x : list != v.end() ? *list : Json::array()) all += (all.empty() ? "" : ", ") + shown(x);
      return all;
    };
    const std::string moments =
        listed("moments", [&](const Json& m) { return m.is_number() ? units.moment(m) : std::string("-"); });
    const std::string pressures =
        listed("pressures", [&](const Json& p) { return p.is_number() ? units.pressure(p) : std::string("-"); });
    const std::string where = listed("where", [](const Json& w) { return w.get<std::string>(); });
    const std::string status = v.value("status", "");
    const std::string place = sweep ? changed(result.cases[i], v) : v.value("at_tip", false) ? "tip" : "inside";
    const double error = number_in(v, "model_error");
    grid.row({length("diameter"), text("force_limit", "N"), status, place, length("palm_distance"), moments, pressures,
              where, text("lateral_force", "N"), text("axial_force", "N"), text("axial_stiffness", "N/m"),
              std::isfinite(error) ? fmt::format("{:.1e} m", error) : "-"});
    opening = opening || (sweep && turning(scene, number_in(v, "planned_moment")) == "opening");
    const std::string message = v.value("message", "");
    if (status != to_string(PlanStatus::solved) || !message.empty()) {
      trouble += fmt::format("case {}: {}: {}\n", i, status, printable(message));
    }
  }
  std::string text = study_heading(scene) + grid.text("");
  text += "\nlateral: of each finger; axial: of both, positive away from the palm\n";
  if (opening)
    text += "the planned moment of the last actuator is an opening one: a larger one opens the finger further\n";
  return text + trouble;
}

}  // namespace tendril::app
