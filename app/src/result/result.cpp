#include "tendril/app/result.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "result/grasp_result.hpp"
#include "result/result_object.hpp"
#include "result/uncertainty_result.hpp"
#include "tendril/app/files.hpp"
#include "tendril/app/input_error.hpp"
#include "tendril/coordinate_model.hpp"
#include "tendril/version.hpp"

namespace tendril::app {

namespace {

Json certificate_json(const Certificate& certificate) {
  Json json{{"equilibrium", number(certificate.equilibrium)},
            {"penetration", number(certificate.penetration)},
            {"complementarity", number(certificate.complementarity)},
            {"closest_point", number(certificate.closest_point)},
            {"force_balance", number(certificate.balance)},
            {"stationarity", number(certificate.stationarity)},
            {"stationarity_kind", certificate.stationarity_kind},
            {"bounds", number(certificate.bounds)},
            {"stability", number(certificate.stability)},
            {"moment_balance", number(certificate.moment_balance)},
            {"contact_convexity", number(certificate.contact_convexity)},
            {"quadrature", number(certificate.quadrature)},
            {"failures", certificate.failures}};
  if (certificate.least_stretch < 1.0) json["least_stretch"] = number(certificate.least_stretch);
  if (certificate.friction) json["friction"] = number(*certificate.friction);
  if (certificate.held_lengths > 0) json["held_lengths"] = certificate.held_lengths;
  if (certificate.out_of_plane) json["out_of_plane"] = number(*certificate.out_of_plane);
  return json;
}

Json solver_json(const Plan& plan) {
  const OptimalityReport& report = plan.solver;
  return {{"name", plan.solver_name},
          {"status", to_string(report.status)},
          {"native_status", report.native_status},
          {"message", report.message},
          {"iterations", report.iterations},
          {"evaluations",
           {{"values", report.evaluations.values},
            {"first_derivatives", report.evaluations.first_derivatives},
            {"hessians", report.evaluations.hessians}}},
          {"infeasibility", number(report.infeasibility)},
          {"stationarity", number(report.stationarity)},
          {"multipliers_recovered", report.multipliers_recovered},
          {"seconds", number(report.seconds)},
          {"seconds_evaluating", number(report.seconds_evaluating)},
          {"options", report.effective_options}};
}

/// Values by name; a name that occurs again gets a number ("tip_pose 2").
Json terms_json(const std::vector<std::pair<std::string, double>>& terms) {
  Json object = Json::object();
  for (const auto& [name, value] : terms) {
    std::string unique = name;
    for (int i = 2; object.contains(unique); ++i) unique = fmt::format("{} {}", name, i);
    object[unique] = number(value);
  }
  return object;
}

Json counts_json(const std::vector<Description::Count>& counts, bool with_kind) {
  Json array = Json::array();
  for (const Description::Count& count : counts) {
    Json entry{{"name", count.name}, {"count", count.count}};
    if (with_kind) entry["kind"] = count.kind;
    array.push_back(std::move(entry));
  }
  return array;
}

/// A value of a scene in SI: text with a unit is a length, an angle or a pure number, whichever reads it.
Json si_json(const RawValue& value, const QuantityReader& read) {
  if (const auto* list = std::get_if<RawValue::List>(&value.value)) {
    Json array = Json::array();
    for (const RawValue& entry : *list) array.push_back(si_json(entry, read));
    return array;
  }
  if (const auto* flag = std::get_if<bool>(&value.value)) return *flag;
  if (const auto* whole = std::get_if<std::int64_t>(&value.value)) return *whole;
  if (const auto* real = std::get_if<double>(&value.value)) return number(*real);
  const std::string& text = std::get<std::string>(value.value);
  for (const Dimension& dimension : {dimension::length, dimension::angle}) {
    try {
      if (read) return number(read(text, dimension));
    } catch (const Error&) {
      continue;
    }
  }
  return text;
}

Json place_json(const ObstaclePlace& place) {
  return {{"shift", numbers({place.shift.x, place.shift.y})}, {"turn", number(place.turn)}};
}

Json obstacles_json(const Scene& scene) {
  Json array = Json::array();
  for (std::size_t i = 0; i < scene.obstacles.size(); ++i) {
    const ObstacleSpec& obstacle = scene.obstacles[i];
    Json one{{"name", obstacle.name}, {"shape", obstacle.shape}};
    for (const auto& [name, value] : obstacle.options) one[name] = si_json(value, scene.read_quantity);
    if (const double friction = friction_of(scene, i); friction > 0.0) one["friction"] = friction;
    if (obstacle.place.moves()) one.update(place_json(obstacle.place));
    array.push_back(std::move(one));
  }
  return array;
}

}  // namespace

Json number(double value) { return std::isfinite(value) ? Json(value + 0.0) : Json(nullptr); }

Json numbers(const std::vector<double>& values) {
  Json::array_t array;
  array.reserve(values.size());
  for (const double value : values) array.push_back(number(value));
  return array;
}

Json contacts_json(const std::vector<PlannedContact>& contacts, const std::string& finger) {
  Json array = Json::array();
  for (const PlannedContact& contact : contacts) {
    array.push_back({{"obstacle", contact.obstacle_name},
                     {"obstacle_index", contact.obstacle},
                     {"at_tip", contact.at_tip},
                     {"arc_length", number(contact.arc_length)},
                     {"point", {number(contact.point.x), number(contact.point.y)}},
                     {"normal", {number(contact.normal.x), number(contact.normal.y)}},
                     {"force", number(contact.force)},
                     {"gap", number(contact.gap)}});
    if (!finger.empty()) array.back()["finger"] = finger;
    if (contact.tangential != 0.0 || contact.sticks) {
      array.back()["tangential_force"] = number(contact.tangential);
      array.back()["state"] = contact.sticks ? "stick" : "slip";
    }
    if (contact.extended) array.back()["extended"] = true;
  }
  return array;
}

/// What may be moved of the rod.
void add_place(Json& json, const RodPlace& place) {
  if (place.insertion) json["insertion"] = number(*place.insertion);
  if (!place.base) return;
  const auto& [position, angle] = *place.base;
  json["base"] = {{"x", number(position.x)}, {"y", number(position.y)}, {"angle", number(angle)}};
}

Json friction_json(const Scene& scene, const Plan& plan) {
  Json array = Json::array();
  const bool both = plan.grasp && plan.grasp->lower;
  for (const FrictionRange& state : plan.friction) {
    const auto lower =
        state.contacts.begin() + static_cast<std::ptrdiff_t>(both ? plan.contacts.size() : state.contacts.size());
    Json contacts = contacts_json({state.contacts.begin(), lower}, both ? "upper" : "");
    for (Json& contact : contacts_json({lower, state.contacts.end()}, "lower")) contacts.push_back(std::move(contact));
    array.push_back(
        {{"ratios", numbers(state.ratios)},
         {"tip", {{"x", number(state.tip_x)}, {"y", number(state.tip_y)}, {"angle", number(state.tip_angle)}}},
         {"contacts", std::move(contacts)},
         {"stability", number(state.stability)}});
    if (state.target_error) array.back()["target_error"] = number(*state.target_error);
    if (!plan.grasp || state.contacts.empty()) continue;
    const Vec2 left = force_on_object(scene, plan, state);
    array.back()["net_force"] = numbers({left.x, left.y});
  }
  return array;
}

Json backbone_json(const std::vector<BackbonePoint>& points) {
  Json::array_t array;
  array.reserve(points.size());
  for (const BackbonePoint& p : points) array.push_back(numbers({p.s, p.x, p.y, p.angle, p.curvature}));
  return array;
}

void add_thickness(Json& json, const RodSpec& rod, const std::vector<BackbonePoint>& backbone) {
  const BodyRadius radius = rod.body();
  if (!radius) return;
  Json::array_t array;
  array.reserve(backbone.size());
  for (const BackbonePoint& p : backbone) array.push_back(number(2.0 * radius(p.s)));
  json["thickness"] = std::move(array);
}

Json target_json(const TargetSpec& target) {
  Json json = Json::object();
  if (target.position) json["position"] = numbers({target.position->x, target.position->y});
  if (target.angle) json["angle"] = number(*target.angle);
  return json;
}

Json moved_obstacles_json(const Scene& scene, const std::vector<MovedObstacle>& moved) {
  Json array = Json::array();
  for (const MovedObstacle& m : moved) {
    Json one = place_json(m.place);
    one["obstacle"] = scene.obstacles[static_cast<std::size_t>(m.obstacle)].name;
    array.push_back(std::move(one));
  }
  return array;
}

void add_surroundings(Json& json, const Scene& scene) {
  json["obstacles"] = obstacles_json(scene);
  json["contact_mode"] = to_string(scene.contact.mode);
  if (scene.gravity) json["gravity"] = numbers({scene.gravity->x, scene.gravity->y});
}

Json left_out_json(const std::vector<LeftOut>& items) {
  Json array = Json::array();
  for (const LeftOut& item : items) array.push_back({{"what", item.what}, {"why", item.why}});
  return array;
}

Json components_json(const std::vector<UsedComponent>& components) {
  Json array = Json::array();
  for (const UsedComponent& component : components) {
    array.push_back({{"kind", component.kind},
                     {"name", component.name},
                     {"file", component.file.empty() ? Json(nullptr) : Json(component.file)}});
  }
  return array;
}

Json versions_json() {
  return {{"tendril", TENDRIL_VERSION},
          {"plugin_interface", TENDRIL_INTERFACE_VERSION},
          {"eigen", fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
          {"nlohmann_json", fmt::format("{}.{}.{}", NLOHMANN_JSON_VERSION_MAJOR, NLOHMANN_JSON_VERSION_MINOR,
                                        NLOHMANN_JSON_VERSION_PATCH)},
          {"fmt", fmt::format("{}.{}.{}", FMT_VERSION / 10000, FMT_VERSION / 100 % 100, FMT_VERSION % 100)},
          {"compiler", __VERSION__}};
}

std::string written(const Json& json) {
  // Text that is not UTF-8 (a file name, for instance) must not cost the whole result.
  std::string text = json.dump(2, ' ', false, Json::error_handler_t::replace);
  text += '\n';
  return text;
}

/// `problem` is what was done with the scene: a scene of another kind can be executed.
Json plan_object(const Scene& scene, ProblemKind problem, const Plan& plan) {
  Json json;
  json["schema"] = 1;
  json["status"] = to_string(plan.status);
  json["message"] = plan.message;
  if (plan.search_cut) json["search_cut"] = true;
  if (!plan.notes.empty()) json["notes"] = plan.notes;
  json["scene"] = scene.file;
  json["title"] = scene.title;
  json["problem"] = to_string(problem);
  json["coordinates"] = {{"name", plan.coordinates_name},
                         {"order", plan.order},
                         {"split_at_contact", plan.split_at_contact},
                         {"dimension", plan.coordinates.size()},
                         {"values", numbers(plan.coordinates)}};
  json["solver"] = solver_json(plan);
  // A plan that came to no shape has no tip and no objective either.
  const bool has_shape = !plan.backbone.empty();
  json["objective"] = has_shape ? number(plan.objective) : Json(nullptr);
  json["terms"] = terms_json(plan.terms);
  json["tip"] = {{"x", has_shape ? number(plan.tip_x) : Json(nullptr)},
                 {"y", has_shape ? number(plan.tip_y) : Json(nullptr)},
                 {"angle", has_shape ? number(plan.tip_angle) : Json(nullptr)}};
  if (Json target = target_json(scene.target); !target.empty()) json["target"] = std::move(target);
  json["target_error"] = plan.target_error ? number(*plan.target_error) : Json(nullptr);
  json["moments"] = numbers(all_moments(plan));
  add_place(json, plan.place);
  json["contacts"] = Json::array();
  for (const ShownFinger& finger : fingers_of(scene, plan)) {
    for (Json& contact : contacts_json(finger.state.contacts, finger.name))
      json["contacts"].push_back(std::move(contact));
  }
  add_grasp(json, scene, plan);
  json["certificate"] = certificate_json(plan.certificate);
  if (!plan.friction.empty()) json["friction_range"] = friction_json(scene, plan);
  if (!plan.verification.empty()) {
    json["model_error"] = plan.model_error ? number(*plan.model_error) : Json(nullptr);
    json["local_model_error"] = plan.local_model_error ? number(*plan.local_model_error) : Json(nullptr);
    json["verification"] = plan.verification;
  }
  Json modes = Json::array();
  for (const ModeRecord& mode : plan.modes) {
    modes.push_back({{"mode", mode.mode},
                     {"outcome", mode.outcome},
                     {"solves", mode.solves},
                     {"polishes", mode.polishes},
                     {"iterations", mode.iterations},
                     {"evaluations", mode.evaluations},
                     {"seconds", number(mode.seconds)}});
  }
  json["modes"] = std::move(modes);
  Json minima = Json::array();
  for (const PlanMinimum& minimum : plan.minima) {
    Json sides = Json::array();
    for (std::size_t o = 0; o < minimum.sides.size() && o < scene.obstacles.size(); ++o) {
      if (!minimum.sides[o].empty())
        sides.push_back({{"obstacle", scene.obstacles[o].name}, {"side", minimum.sides[o]}});
    }
    minima.push_back({{"mode", minimum.mode},
                      {"sides", std::move(sides)},
                      {"objective", number(minimum.objective)},
                      {"moments", numbers(minimum.moments)}});
  }
  json["minima"] = std::move(minima);
  if (plan.scan) {
    json["scan"] = {{"steps", numbers(plan.scan->steps)},
                    {"equilibria", plan.scan->equilibria},
                    {"lost", plan.scan->lost},
                    {"unresolved", plan.scan->unresolved},
                    {"whole", plan.scan->whole},
                    {"complete", plan.scan->complete()}};
  }
  json["left_out"] = left_out_json(plan.left_out);
  json["seconds"] = {{"assemble", number(plan.seconds_assemble)},
                     {"solve", number(plan.seconds_solve)},
                     {"certify", number(plan.seconds_certify)}};
  if (plan.self_overlap) json["self_overlap"] = {number(plan.self_overlap->first), number(plan.self_overlap->second)};
  json["backbone"] = backbone_json(plan.backbone);
  add_thickness(json, fingers_of(scene, plan).front().rod, plan.backbone);
  return json;
}

Json plan_object(const Scene& scene, const Plan& plan) { return plan_object(scene, scene.problem, plan); }

namespace {

/// What stands once in a result: what is around the rod, and what the command did around the planner.
void add_run(Json& json, const Scene& scene, const RunInfo& run) {
  add_surroundings(json, scene);
  if (!run.uncertainties.empty()) json["uncertainty"] = uncertainty_json(run.uncertainties.front());
  json["seconds"]["read"] = number(run.seconds_read);
  json["seconds"]["open"] = number(run.seconds_open);
  json["plugins"] = components_json(run.components);
  json["versions"] = versions_json();
}

/// A state beside a snap. Its tip is the end of its backbone.
Json state_json(const std::vector<BackbonePoint>& shape, const std::vector<PlannedContact>& contacts) {
  const BackbonePoint tip = shape.empty() ? BackbonePoint{} : shape.back();
  return {{"tip", {{"x", number(tip.x)}, {"y", number(tip.y)}, {"angle", number(tip.angle)}}},
          {"contacts", contacts_json(contacts)},
          {"backbone", backbone_json(shape)}};
}

}  // namespace

Json snaps_json(const std::vector<Snap>& snaps) {
  Json all = Json::array();
  for (const Snap& snap : snaps) {
    all.push_back({{"kind", to_string(snap.kind)},
                   {"load", number(snap.load)},
                   {"moments", numbers(snap.moments)},
                   {"stability_after", number(snap.stability_after)},
                   {"before", state_json(snap.before, snap.contacts_before)},
                   {"after", state_json(snap.after, snap.contacts_after)}});
  }
  return all;
}

Json plan_result(const Scene& scene, const Plan& plan, const RunInfo& run) {
  Json json = plan_object(scene, plan);
  if (!plan.start_backbone.empty()) json["start_backbone"] = backbone_json(plan.start_backbone);
  add_run(json, scene, run);
  return json;
}

std::string plan_json(const Scene& scene, const Plan& plan, const RunInfo& run) {
  return written(plan_result(scene, plan, run));
}

std::string execution_json(const Scene& scene, const Execution& execution, const RunInfo& run) {
  return written(execution_result(scene, execution, run));
}

Json execution_result(const Scene& scene, const Execution& execution, const RunInfo& run) {
  Json json = plan_object(scene, ProblemKind::execute, execution.result);
  add_run(json, scene, run);
  json["load"] = {
      {"reached", number(execution.load)}, {"steps", execution.steps}, {"contact_changes", execution.contact_changes}};
  if (execution.tendon_changes > 0) json["load"]["tendon_changes"] = execution.tendon_changes;
  json["basis"] = {{"name", LegendreBasis::name}, {"order", execution.result.order}, {"pieces", execution.pieces}};
  json["snaps"] = snaps_json(execution.snaps);
  return json;
}

std::string description_json(const Scene& scene, const Description& description, const RunInfo& run) {
  Json json;
  json["schema"] = 1;
  json["scene"] = scene.file;
  json["title"] = scene.title;
  json["problem"] = to_string(scene.problem);
  json["variables"] = counts_json(description.variables, false);
  json["rows"] = counts_json(description.rows, true);
  json["terms"] = description.terms;
  json["energies"] = description.energies;
  json["plugins"] = components_json(run.components);
  json["left_out"] = left_out_json(description.left_out);
  Json modes = Json::array();
  for (const Description::Mode& mode : description.modes) {
    modes.push_back({{"name", mode.name},
                     {"variables", counts_json(mode.variables, false)},
                     {"rows", counts_json(mode.rows, true)}});
  }
  json["modes"] = std::move(modes);
  json["units"] = {{"length", number(description.length_unit)}, {"force", number(description.force_unit)}};
  json["versions"] = versions_json();
  return written(json);
}

}  // namespace tendril::app
