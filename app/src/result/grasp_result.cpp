#include "result/grasp_result.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "system/tables.hpp"
#include "tendril/execute.hpp"
#include "tendril/grasp.hpp"
#include "tendril/scale.hpp"
#include "tendril/tolerances.hpp"

namespace tendril::app {

std::vector<ShownFinger> fingers_of(const Scene& scene, const Plan& plan) {
  const FingerPlan first{plan.coordinates, plan.moments,   plan.contacts,     plan.backbone, plan.tip_x,
                         plan.tip_y,       plan.tip_angle, plan.self_overlap, plan.turns,    plan.place};
  if (!plan.grasp || !plan.grasp->lower) {
    return {{"", plans_both_fingers(scene) ? finger_of(scene, FingerName::upper).rod : scene.rod, first}};
  }
  const auto shown = [&](FingerName name, const FingerPlan& state) {
    return ShownFinger{std::string(to_string(name)), finger_of(scene, name).rod, state};
  };
  return {shown(FingerName::upper, first), shown(FingerName::lower, *plan.grasp->lower)};
}

std::vector<double> all_moments(const Plan& plan) {
  std::vector<double> moments = plan.moments;
  if (plan.grasp && plan.grasp->lower) {
    const std::vector<double>& lower = plan.grasp->lower->moments;
    moments.insert(moments.end(), lower.begin(), lower.end());
  }
  return moments;
}

std::vector<double> all_held(const Scene& scene, const Plan& plan) {
  std::vector<double> held;
  for (const ShownFinger& finger : fingers_of(scene, plan)) {
    Scene own;
    own.rod = finger.rod;
    Plan state;
    state.moments = finger.state.moments;
    state.turns = finger.state.turns;
    const std::vector<double> one = held_of(own, state);
    held.insert(held.end(), one.begin(), one.end());
  }
  return held;
}

RodPlace lower_place_of(const Plan& plan) {
  return plan.grasp && plan.grasp->lower ? plan.grasp->lower->place : RodPlace{};
}

std::vector<ActuatorSpec> actuators_of(const Scene& scene) {
  if (!plans_both_fingers(scene)) return scene.rod.actuators;
  std::vector<ActuatorSpec> all = finger_of(scene, FingerName::upper).rod.actuators;
  const std::vector<ActuatorSpec> lower = finger_of(scene, FingerName::lower).rod.actuators;
  all.insert(all.end(), lower.begin(), lower.end());
  return all;
}

std::vector<ShownActuator> shown_actuators(const Scene& scene, const Plan& plan) {
  std::vector<ShownActuator> all;
  for (const ShownFinger& finger : fingers_of(scene, plan)) {
    const std::vector<double>& moments = finger.state.moments;
    for (std::size_t a = 0; a < std::min(moments.size(), finger.rod.actuators.size()); ++a) {
      const ActuatorSpec& actuator = finger.rod.actuators[a];
      // What a moment may miss, and the rounding of its own digits.
      const double close = tolerance::bounds * (scale_of(scene).moment() + std::abs(moments[a]));
      const std::vector<double>& turns = finger.state.turns;
      const double shortening = a < turns.size() ? turns[a] * actuator.largest_offset() + 0.0 : 0.0;
      double over = excess(actuator, moments[a]);
      if (actuator.by_length) {
        // A tendon that is slack is at no limit of its tension.
        if (std::abs(moments[a]) <= close) over = -infinity;
        const double beyond = std::max(actuator.least_shortening - shortening, shortening - actuator.most_shortening);
        over = std::max(over, beyond / std::abs(actuator.largest_offset()) * scale_of(scene).moment());
      }
      const char* where = over > close ? "beyond its limit" : over >= -close ? "at its limit" : "inside";
      all.push_back({finger.name, a + 1, where, moments[a], actuator.minimum, actuator.maximum, actuator, shortening});
    }
  }
  return all;
}

std::vector<std::optional<double>> pressures_of(const Scene& scene, const Plan& plan) {
  std::vector<std::optional<double>> pressures;
  for (const ShownActuator& a : shown_actuators(scene, plan)) {
    pressures.push_back(a.is(ActuatorKind::pressure) ? std::optional(a.input()) : std::nullopt);
  }
  return pressures;
}

bool touches(const Scene& scene, const PlannedContact& contact) {
  const Scale scale = scale_of(scene);
  return contact.force > tolerance::force * scale.force() || contact.gap <= tolerance::complementarity * scale.length;
}

std::string_view turning(const Scene& scene, double moment) {
  const double rounding = tolerance::bounds * scale_of(scene).moment();
  if (std::abs(moment) <= rounding) return "";
  return moment > 0.0 ? "opening" : "closing";
}

namespace {

Json hold_json(const Scene& scene, const GraspPlan& grasp) {
  const GraspHold& hold = *grasp.hold;
  Json corners = Json::array();
  for (const Vec2 f : hold.held_forces) corners.push_back(numbers({f.x, f.y}));
  Json json{{"coefficient", number(hold.friction)},
            {"closure", hold.closure},
            {"closure_coefficient", number(hold.closure_friction)},
            {"breaking_force", numbers({hold.breaking_force.x, hold.breaking_force.y})},
            {"held_forces", std::move(corners)},
            {"held_moments", numbers({hold.least_moment, hold.largest_moment})}};
  if (const std::optional<GraspLift> lift = lift_of(scene, grasp)) {
    json["lift"] = {{"acceleration", number(lift->acceleration)}, {"heaviest_turned", number(lift->heaviest_turned)}};
  }
  return json;
}

void add_hold(Grid& grid, const Scene& scene, const GraspPlan& grasp, const DisplayUnits& units) {
  const GraspHold& hold = *grasp.hold;
  std::string closure = fmt::format("{:.6g}: the cones ", hold.friction);
  closure += hold.closure ? "hold any disturbance if pressed hard enough" : "do not hold every disturbance";
  closure += hold.closure_friction > 0.0 ? fmt::format(", which takes more than {:.6g}", hold.closure_friction) : "";
  grid.row({"friction", closure});
  const double force = norm(hold.breaking_force);
  if (!std::isfinite(force)) return;
  const double direction = std::atan2(hold.breaking_force.y, hold.breaking_force.x);
  grid.row({"least force that breaks the hold",
            force > 0.0 ? fmt::format("{:.6g} N, towards {:.4g} deg", force, direction * 180.0 / std::numbers::pi)
                        : "none is held"});
  grid.row({"moments held", units.moment(hold.least_moment) + " to " + units.moment(hold.largest_moment)});
  if (const std::optional<GraspLift> lift = lift_of(scene, grasp)) {
    grid.row({"lifted with at most", fmt::format("{:.6g} m/s^2", lift->acceleration)});
    grid.row({"heaviest object held however it is turned", fmt::format("{:.6g} kg", lift->heaviest_turned)});
  }
}

}  // namespace

Vec2 force_on_object(const Scene& scene, const Plan& plan, const FrictionRange& state) {
  const double distance = plan.grasp->palm_distance;
  if (!plan.grasp->lower) return grasp_of(scene, distance, state.contacts).net_force;
  const auto lower = state.contacts.begin() + static_cast<std::ptrdiff_t>(plan.contacts.size());
  return grasp_of(scene, distance, {state.contacts.begin(), lower}, {lower, state.contacts.end()}).net_force;
}

void add_grasp(Json& json, const Scene& scene, const Plan& plan) {
  Json pressures = Json::array();
  Json inputs = Json::array();
  bool any = false;
  for (const ShownActuator& a : shown_actuators(scene, plan)) {
    const bool pressure = a.is(ActuatorKind::pressure);
    Json input{{"kind", to_string(a.spec.input())},
               {"value", number(a.input())},
               {"unit", a.spec.input_dimension().unit},
               {"moment", number(a.moment)},
               {"where", a.where}};
    if (pressure) input["pressure"] = number(a.input());
    if (a.is(ActuatorKind::tendon)) {
      input["control"] = a.spec.by_length ? "length" : "tension";
      input["tension"] = number(a.input_of(a.moment));
      input["shortening"] = number(a.shortening);
    }
    if (!a.finger.empty()) input["finger"] = a.finger;
    inputs.push_back(std::move(input));
    pressures.push_back(pressure ? number(a.input()) : Json(nullptr));
    any = any || pressure;
  }
  json["inputs"] = std::move(inputs);
  if (any || plan.grasp) json["pressures"] = std::move(pressures);
  if (!plan.grasp) return;
  const GraspPlan& grasp = *plan.grasp;
  json["palm_distance"] = number(grasp.palm_distance);
  json["net_force"] = numbers({grasp.net_force.x, grasp.net_force.y});
  Json quality{
      {"palm",
       {{"position", numbers({scene.gripper->position.x, scene.gripper->position.y})},
        {"angle", number(scene.gripper->angle)},
        {"half_palm", number(scene.gripper->half_palm)}}},
      {"object",
       {{"center", numbers({grasp.object_center.x, grasp.object_center.y})}, {"radius", number(grasp.object_radius)}}},
      {"axial_force", number(grasp.axial_force)},
      {"lateral_force", number(grasp.lateral_force)}};
  if (norm(grasp.load) != 0.0) quality["object"]["load"] = numbers({grasp.load.x, grasp.load.y});
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
  if (grasp.hold) quality["friction"] = hold_json(scene, grasp);
  json["grasp"] = std::move(quality);
  if (!grasp.lower) return;
  Json fingers = Json::array();
  for (const ShownFinger& finger : fingers_of(scene, plan)) {
    const FingerPlan& state = finger.state;
    fingers.push_back(
        {{"finger", finger.name},
         {"moments", numbers(state.moments)},
         {"tip", {{"x", number(state.tip_x)}, {"y", number(state.tip_y)}, {"angle", number(state.tip_angle)}}},
         {"contacts", contacts_json(state.contacts, finger.name)},
         {"coordinates", numbers(state.coordinates)},
         {"backbone", backbone_json(state.backbone)}});
    add_place(fingers.back(), state.place);
    add_thickness(fingers.back(), finger.rod, state.backbone);
    if (state.self_overlap)
      fingers.back()["self_overlap"] = {number(state.self_overlap->first), number(state.self_overlap->second)};
  }
  json["fingers"] = std::move(fingers);
}

std::string grasp_text(const Scene& scene, const Plan& plan) {
  if (!plan.grasp) return "";
  const DisplayUnits units(scene);
  const GraspPlan& grasp = *plan.grasp;
  const auto newtons = [](double f) { return fmt::format("{:.6g} N", f); };
  const auto pair = [&](double along, double across) {
    return newtons(along) + " along, " + newtons(across) + " across the axis";
  };
  Grid grid;
  grid.row({"grasp", ""});
  grid.row({"palm distance", units.lengths(grasp.palm_distance)});
  grid.row({"net force", newtons(grasp.axial_force) + " along the axis (positive: away from the palm)"});
  if (norm(grasp.load) != 0.0) {
    grid.row({"the object carries", fmt::format("[{:.6g}, {:.6g}] N", grasp.load.x, grasp.load.y)});
  }
  grid.row({"each finger presses", newtons(grasp.lateral_force) + " across the axis"});
  if (grasp.quality) {
    const GraspQuality& q = *grasp.quality;
    std::size_t contact = 0;
    for (const ShownFinger& finger : fingers_of(scene, plan)) {
      for (std::size_t k = 0; k < finger.state.contacts.size() && contact < q.force_margins.size(); ++k, ++contact) {
        const double margin = q.force_margins[contact];
        grid.row({(finger.name.empty() ? "" : finger.name + " ") + "force to its limit",
                  std::isfinite(margin) ? newtons(margin) : "no limit"});
      }
    }
    grid.row({"stiffness of the object",
              fmt::format("{:.6g} N/m along, {:.6g} N/m across the axis{}", q.axial_stiffness, q.lateral_stiffness,
                          q.axial_stiffness > 0.0 ? "" : "; at held moments it is driven out along the axis")});
    std::size_t at = 0;
    for (const ShownFinger& finger : fingers_of(scene, plan)) {
      for (std::size_t a = 0; a < finger.state.moments.size() && at < q.force_by_moment.size(); ++a, ++at) {
        const std::string_view turns = turning(scene, finger.state.moments[a]);
        grid.row({fmt::format("1 % of {}{}moment {}{}", finger.name, finger.name.empty() ? "" : " ", a + 1,
                              turns.empty() ? "" : fmt::format(" ({})", turns)),
                  pair(q.force_by_moment[at].x, q.force_by_moment[at].y)});
      }
    }
    grid.row({"1 mm of its place", pair(-1e-3 * q.axial_stiffness, -1e-3 * q.lateral_stiffness)});
  }
  if (grasp.hold) add_hold(grid, scene, grasp, units);
  return '\n' + grid.text("");
}

}  // namespace tendril::app
