#include "consistency.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tendril::results {
namespace {

/// Of sums and products of a few numbers.
constexpr double of_sums = 1e-12;

double sum_of(const Json& list, const char* key) {
  double sum = 0.0;
  for (const Json& entry : list) sum += entry.at(key).get<double>();
  return sum;
}

/// Actuators in the order of "moments": those of the upper finger, then those of the lower one.
std::vector<ActuatorSpec> actuators_of(const Json& result, const Scene& scene) {
  std::vector<ActuatorSpec> all;
  for (const ShownRod& shown : shown_rods(result, scene)) {
    all.insert(all.end(), shown.rod.actuators.begin(), shown.rod.actuators.end());
  }
  return all;
}

void check_moments(const Json& result, const Scene& scene, Findings& found) {
  const std::vector<ActuatorSpec> actuators = actuators_of(result, scene);
  const Json& moments = result.at("moments");
  found.that(moments.size() == actuators.size(), "one moment for each actuator");
  const bool known = std::any_of(actuators.begin(), actuators.end(),
                                 [](const ActuatorSpec& a) { return a.moment_per_pressure != 0.0; });
  found.that(result.contains("pressures") == (known || result.contains("grasp")), "pressures where they are known");
  if (!result.contains("pressures") || moments.size() != actuators.size()) return;
  for (std::size_t i = 0; i < actuators.size(); ++i) {
    const Json& pressure = result.at("pressures").at(i);
    const double per_pressure = actuators[i].moment_per_pressure;
    found.that(pressure.is_null() == (per_pressure == 0.0), "a pressure exactly where the scene says what it does");
    if (pressure.is_null()) continue;
    const double moment = moments.at(i).get<double>();
    found.near("pressure times moment per pressure", pressure.get<double>() * per_pressure, moment,
               of_sums * std::abs(moment));
  }
}

/// Terms whose formulas are known, for objectives without options.
void check_terms(const Json& result, const Scene& scene, const TargetSpec& target, Findings& found) {
  const double length = scene.rod.length();
  const double moment_unit = force_unit(scene.rod) * length;
  double sum = 0.0;
  double size = 0.0;
  for (const auto& [name, value] : result.at("terms").items()) {
    sum += value.get<double>();
    size += std::abs(value.get<double>());
  }
  found.near("objective against the sum of its terms", result.at("objective").get<double>(), sum, of_sums * size);
  for (const ObjectiveSpec& term : scene.objectives) {
    if (!term.options.empty() || !result.at("terms").contains(term.plugin)) continue;
    double expected = 0.0;
    if (term.plugin == "tip_pose") {
      const Json& tip = result.at("tip");
      if (target.position) {
        const double x = (tip.at("x").get<double>() - target.position->x) / length;
        const double y = (tip.at("y").get<double>() - target.position->y) / length;
        expected += x * x + y * y;
      }
      // A direction: full turns do not count.
      if (target.angle) {
        expected += std::pow(std::remainder(tip.at("angle").get<double>() - *target.angle, 2.0 * std::numbers::pi), 2);
      }
    } else if (term.plugin == "actuation_effort") {
      for (const Json& moment : result.at("moments")) expected += std::pow(moment.get<double>() / moment_unit, 2);
    } else if (term.plugin == "contact_force") {
      expected = -sum_of(result.at("contacts"), "force") / force_unit(scene.rod);
    } else {
      continue;
    }
    // Squares of differences that are small against what they are differences of, which data are rounded to 1e-12 of.
    found.near(term.plugin, result.at("terms").at(term.plugin).get<double>(), term.weight * expected,
               term.weight * (1e-9 * std::abs(expected) + 1e-13));
  }
}

void check_target(const Json& result, const Scene& scene, const TargetSpec& target, Findings& found) {
  const Json& error = result.at("target_error");
  const bool asked = target.position.has_value() && scene.problem != ProblemKind::grasp;
  found.that(error.is_number() == asked, "an error of the target exactly where there is one");
  if (!asked || !error.is_number()) return;
  const Json& tip = result.at("tip");
  found.near("target error", error.get<double>(),
             std::hypot(tip.at("x").get<double>() - target.position->x, tip.at("y").get<double>() - target.position->y),
             1e-11 * scene.rod.length());
}

void check_seconds(const Json& result, Findings& found) {
  for (const auto& [part, seconds] : result.at("seconds").items()) {
    found.that(seconds.get<double>() >= 0.0, "negative seconds of " + part);
  }
  const Json& solver = result.at("solver");
  found.that(solver.at("seconds_evaluating").get<double>() <= solver.at("seconds").get<double>(),
             "the solver evaluates longer than it runs");
  const double all = result.at("seconds").at("solve").get<double>() + result.at("seconds").at("certify").get<double>() +
                     result.at("seconds").at("assemble").get<double>();
  found.that(sum_of(result.at("modes"), "seconds") <= all + 1e-6,
             "ways of being in contact take longer than the whole");
}

void check_state(const Json& state, const ShownRod& shown, const Scene& scene, const Json& result, bool certified,
                 Findings& found) {
  const Findings::Place place(found, shown.name.empty() ? "rod" : shown.name + " finger");
  check_shape(state, shown, certified, found);
  check_contacts(state, shown, scene, result, certified, found);
}

void check_plan(const Json& result, const Scene& scene, const TargetSpec& target, Findings& found) {
  const bool solved = result.at("status") == "solved";
  // An execution that went well still tells that its start lay inside an obstacle.
  const std::string message = result.at("message");
  found.that(!solved || message.empty() || message.rfind("the start shape lies ", 0) == 0,
             "a solved plan has a message");
  found.that(!solved || result.at("certificate").at("failures").empty(), "a solved plan has failures");
  found.that(solved || result.at("message") != "", "a plan that is not solved does not say why");
  found.that(result.at("coordinates").at("values").size() == result.at("coordinates").at("dimension"), "the dimension");
  check_seconds(result, found);
  if (result.at("backbone").empty()) {
    found.that(!solved, "a solved plan has no shape");
    return;
  }
  const std::vector<ShownRod> rods = shown_rods(result, scene);
  for (std::size_t i = 0; i < rods.size(); ++i) {
    check_state(rods.size() == 1 ? result : result.at("fingers").at(i), rods[i], scene, result, solved, found);
  }
  if (rods.size() == 2) {
    // What stands at the top is the upper finger; moments and contacts are those of both.
    for (const char* key : {"backbone", "tip"}) {
      found.that(result.at(key) == result.at("fingers").at(0).at(key), std::string(key) + " of the upper finger");
    }
    for (const char* key : {"moments", "contacts"}) {
      Json both = result.at("fingers").at(0).at(key);
      for (const Json& entry : result.at("fingers").at(1).at(key)) both.push_back(entry);
      found.that(result.at(key) == both, std::string(key) + " of both fingers");
    }
  }
  check_moments(result, scene, found);
  check_target(result, scene, target, found);
  check_terms(result, scene, target, found);
  if (result.contains("grasp")) check_grasp(result, scene, found);
  for (const Json& snap : result.value("snaps", Json::array())) {
    const Findings::Place place(found, "snap");
    for (const char* side : {"before", "after"}) check_state(snap.at(side), rods.front(), scene, result, false, found);
    found.that(snap.at("load").get<double>() > 0.0 && snap.at("load").get<double>() <= 1.0, "a load of the path");
  }
}

void add_effort(const Json& part, Json& sum) {
  for (const auto& [key, value] : part.items()) {
    if (value.is_object()) {
      if (!sum.contains(key)) sum[key] = Json::object();
      add_effort(value, sum[key]);
    } else {
      sum[key] = sum.value(key, 0) + value.get<int>();
    }
  }
}

void check_trajectory(const Json& result, const Scene& scene, Findings& found) {
  const Json& steps = result.at("steps");
  found.that(steps.size() == scene.trajectory.targets.size(), "one step for each target");
  std::string status = "solved";
  Json effort = Json::object();
  for (std::size_t i = 0; i < steps.size() && i < scene.trajectory.targets.size(); ++i) {
    const Findings::Place place(found, "step " + std::to_string(i + 1));
    const TargetSpec& target = scene.trajectory.targets[i];
    const Json& step = steps[i];
    if (status == "solved") status = step.at("status").get<std::string>();
    found.that(step.at("target").contains("position") == target.position.has_value(), "the position of the target");
    if (target.position) {
      found.that(step.at("target").at("position") == Json({target.position->x, target.position->y}), "its target");
    }
    add_effort(step.at("effort"), effort);
    check_plan(step, scene, target, found);
  }
  found.that(result.at("status") == status, "the status is that of the first step that is not solved");
  found.that(result.at("effort") == effort, "the effort is the sum of the steps'");
}

}  // namespace

std::vector<std::string> inconsistencies(const Json& result, const Scene& scene) {
  Findings found;
  found.that(result.at("schema") == 1, "the schema");
  found.that(result.at("scene") == scene.file, "the scene's name");
  found.that(result.at("title") == scene.title, "the title");
  if (result.contains("steps")) {
    check_trajectory(result, scene, found);
  } else if (result.at("problem") == "estimate") {
    check_estimate(result, scene, found);
  } else {
    check_plan(result, scene, scene.target, found);
  }
  return found.list();
}

}  // namespace tendril::results
