#include "session/inputs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <utility>

#include "result/grasp_result.hpp"
#include "tendril/app/input_error.hpp"

namespace tendril::app {

namespace {

bool is_quantity(const std::string& text, const Dimension& dimension, const Units& units) {
  try {
    units.read(text, dimension);
    return true;
  } catch (const QuantityError&) {
    return false;
  }
}

/// SI, or with a unit. `hint`: what else the text may be, and the option that takes it.
double read_number(const std::string& text, const Dimension& wanted, const std::string& where, const Units& units,
                   const std::optional<std::pair<Dimension, std::string>>& hint) {
  double value = 0.0;
  const char* const end = text.data() + text.size();
  const auto [rest, code] = std::from_chars(text.data(), end, value);
  if (code == std::errc{} && rest == end && std::isfinite(value)) return value;
  try {
    return units.read(text, wanted);
  } catch (const QuantityError& error) {
    std::string words = error.what();
    if (hint && is_quantity(text, hint->first, units)) words += "; " + hint->second;
    throw InputError(fmt::format("{}: {}", where, words));
  }
}

/// What messages call an option of the command: where a program names the inputs, its argument.
std::string named(const Inputs& inputs, const std::string& option) {
  return inputs.shown.empty() || inputs.shown.starts_with("--") ? option : option.substr(2);
}

std::string name_of(const Inputs& inputs) { return inputs.shown.empty() ? option_of(inputs.kind) : inputs.shown; }
std::string insertion_of(const Inputs& inputs) { return named(inputs, "--insertion"); }
std::string base_of(const Inputs& inputs) { return named(inputs, "--base"); }

std::string trimmed(const std::string& text) {
  const std::size_t first = std::min(text.find_first_not_of(" \t"), text.size());
  return text.substr(first, text.find_last_not_of(" \t") + 1 - first);
}

/// What stands between separators, at least one.
std::vector<std::string> parts_of(const std::string& text, char separator) {
  std::vector<std::string> parts;
  for (std::size_t from = 0; from <= text.size();) {
    const std::size_t end = std::min(text.find(separator, from), text.size());
    parts.push_back(trimmed(text.substr(from, end - from)));
    from = end + 1;
  }
  return parts;
}

}  // namespace

const char* option_of(InputKind kind) {
  return kind == InputKind::pressures ? "--pressures" : kind == InputKind::each ? "--inputs" : "--moments";
}

std::vector<double> moments_of(const Inputs& inputs, const Session& session) {
  const std::vector<ActuatorSpec> actuators = actuators_of(session.scene());
  const std::string option = name_of(inputs);
  const bool empty = inputs.text.find_first_not_of(" \t") == std::string::npos;
  if (actuators.empty() && empty) return {};
  if (inputs.kind == InputKind::none) {
    constexpr const char* options =
        "--moments \"M, ...\" or --plan RESULT.json, or --pressures \"P, ...\", or --inputs \"V, ...\" in the unit of "
        "each";
    throw InputError(fmt::format("execute needs what moves the scene's {} actuators, expected {}", actuators.size(),
                                 inputs.shown.empty() ? options : inputs.shown));
  }
  std::vector<std::string> texts = parts_of(inputs.text, ',');
  if (empty) texts.clear();
  std::vector<double> moments;
  moments.reserve(texts.size());
  for (std::size_t a = 0; a < texts.size(); ++a) {
    // One too many is told below; what it says is read all the same, so that what is no number is told as such.
    const bool known = a < actuators.size();
    const ActuatorSpec actuator = known ? actuators[a] : ActuatorSpec{};
    const std::string where = fmt::format("{}, number {}", option, a + 1);
    if (known && inputs.kind == InputKind::pressures && actuator.input() != ActuatorKind::pressure) {
      throw InputError(
          fmt::format("{}: the scene does not say what moment a pressure gives, expected "
                      "'moment_per_pressure' in [[rod.actuator]], or {}",
                      where, named(inputs, "--moments")));
    }
    if (inputs.kind == InputKind::moments && actuator.kind != ActuatorKind::moment) {
      throw InputError(fmt::format("{}: found a moment for an actuator of kind \"{}\", expected {}", where,
                                   to_string(actuator.kind), named(inputs, "--inputs")));
    }
    const bool told = inputs.kind != InputKind::moments;
    std::optional<std::pair<Dimension, std::string>> hint;
    if (told) {
      hint.emplace(dimension::moment, named(inputs, "--moments") + " takes moments");
    } else if (actuator.knows_pressure()) {
      hint.emplace(dimension::pressure, named(inputs, "--pressures") + " takes pressures");
    }
    const double value =
        read_number(texts[a], told ? actuator.input_dimension() : dimension::moment, where, session.units(), hint);
    if (actuator.kind == ActuatorKind::tendon && !actuator.by_length && value < 0.0) {
      throw InputError(fmt::format(
          "{}: found a tension of {} N, expected one that is not negative: a tendon only pulls", where, value));
    }
    moments.push_back(told && !actuator.by_length ? actuator.moment_of(value) : value);
  }
  if (texts.size() != actuators.size()) {
    throw InputError(fmt::format("{}: found {} {}, expected one for each of the scene's {} actuators", option,
                                 texts.size(), std::string(option_of(inputs.kind)).substr(2), actuators.size()));
  }
  return moments;
}

RodPlace place_of(const Inputs& inputs, const Session& session) {
  RodPlace place;
  const std::string insertion = insertion_of(inputs), base = base_of(inputs);
  const auto number = [&](const std::string& text, const Dimension& wanted, const std::string& option) {
    return read_number(text, wanted, option, session.units(), {});
  };
  if (session.scene().problem == ProblemKind::grasp && !(inputs.insertion.empty() && inputs.base.empty())) {
    throw InputError(
        fmt::format("{}: the fingers of a grasp stand on the palm", inputs.insertion.empty() ? base : insertion));
  }
  if (!inputs.insertion.empty()) place.insertion = number(trimmed(inputs.insertion), dimension::length, insertion);
  if (inputs.base.empty()) return place;
  const std::vector<std::string> texts = parts_of(inputs.base, ',');
  if (texts.size() != 3) {
    throw InputError(fmt::format("{}: found {} numbers, expected three: x, y, angle", base, texts.size()));
  }
  place.base = {{number(texts[0], dimension::length, base), number(texts[1], dimension::length, base)},
                number(texts[2], dimension::angle, base)};
  return place;
}

Plan held_of(const Inputs& inputs, const Session& session, const std::optional<Plan>& start) {
  Plan plan;
  plan.place = place_of(inputs, session);
  const bool only_moves = inputs.kind == InputKind::none && (plan.place.insertion || plan.place.base);
  plan.moments = only_moves && start ? all_held(session.scene(), *start) : moments_of(inputs, session);
  return plan;
}

bool are_way_points(const Inputs& inputs) {
  const auto several = [](const std::string& text) { return text.find(';') != std::string::npos; };
  return several(inputs.text) || several(inputs.insertion) || several(inputs.base);
}

std::vector<TrajectoryStep> way_points_of(const Inputs& inputs, const Session& session,
                                          const std::optional<Plan>& start) {
  std::vector<TrajectoryStep> steps;
  const std::string option = name_of(inputs);
  if (session.scene().problem == ProblemKind::grasp) {
    throw InputError(option +
                     ": found several lists, but the fingers of a grasp are executed one by one, expected one");
  }
  const std::vector<std::string> texts = parts_of(inputs.text, ';');
  const std::vector<std::string> insertions = parts_of(inputs.insertion, ';');
  const std::vector<std::string> bases = parts_of(inputs.base, ';');
  const std::size_t count = std::max({texts.size(), insertions.size(), bases.size()});
  const auto one_of = [&](const std::vector<std::string>& all, std::size_t i, const std::string& name) {
    if (all.size() == count) return all[i];
    if (all.size() == 1) return all.front();
    throw InputError(fmt::format("{}: found {} way points, expected {}, or one for all", name, all.size(), count));
  };
  for (std::size_t i = 0; i < count; ++i) {
    Inputs one = inputs;
    one.text = one_of(texts, i, option);
    one.insertion = one_of(insertions, i, insertion_of(inputs));
    one.base = one_of(bases, i, base_of(inputs));
    one.shown = fmt::format("{}, way point {}", option, i + 1);
    Plan& plan = steps.emplace_back().plan = held_of(one, session, start);
    plan.turns.assign(plan.moments.size(), 0.0);
    for (std::size_t a = 0; a < plan.moments.size(); ++a) {
      const ActuatorSpec& actuator = session.scene().rod.actuators[a];
      if (actuator.by_length) plan.turns[a] = std::exchange(plan.moments[a], 0.0) / actuator.largest_offset();
    }
    steps.back().target = session.scene().target;
  }
  return steps;
}

std::variant<Execution, Trajectory> execute_result(Session& session, const files::ResultText& earlier,
                                                   const std::optional<Plan>& start, const Inputs& moved) {
  const auto over = [](RodPlace own, const RodPlace& place) {
    if (place.insertion) own.insertion = place.insertion;
    if (place.base) own.base = place.base;
    return own;
  };
  const Scene& scene = session.scene();
  std::vector<TrajectoryStep> steps = parse_steps(earlier.text, earlier.name, scene);
  if (!steps.empty()) {
    if (are_way_points(moved)) {
      throw InputError(
          fmt::format("{}: found several way points, but the result has its own, expected one place",
                      moved.insertion.find(';') != std::string::npos ? insertion_of(moved) : base_of(moved)));
    }
    const RodPlace place = place_of(moved, session);
    for (TrajectoryStep& step : steps) step.plan.place = over(step.plan.place, place);
    return session.execute(steps, start);
  }
  const Plan plan = parse_start(earlier.text, earlier.name, scene, "plan");
  if (are_way_points(moved)) {
    steps = way_points_of(moved, session, plan);
    for (TrajectoryStep& step : steps) step.plan.place = over(plan.place, step.plan.place);
    return session.execute(steps, start);
  }
  std::optional<double> palm_distance;
  if (plan.grasp) palm_distance = plan.grasp->palm_distance;
  return session.execute(all_held(scene, plan), start, palm_distance, over(plan.place, place_of(moved, session)),
                         lower_place_of(plan));
}

}  // namespace tendril::app
