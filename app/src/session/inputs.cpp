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

}  // namespace

const char* option_of(InputKind kind) {
  return kind == InputKind::pressures ? "--pressures" : kind == InputKind::each ? "--inputs" : "--moments";
}

std::vector<double> moments_of(const Inputs& inputs, const Session& session) {
  const std::vector<ActuatorSpec> actuators = actuators_of(session.scene());
  const std::string option = inputs.shown.empty() ? option_of(inputs.kind) : inputs.shown;
  if (actuators.empty() && inputs.text.find_first_not_of(" \t") == std::string::npos) return {};
  if (inputs.kind == InputKind::none) {
    constexpr const char* options =
        "--moments \"M, ...\" or --plan RESULT.json, or --pressures \"P, ...\", or --inputs \"V, ...\" in the unit of "
        "each";
    throw InputError(fmt::format("execute needs what moves the scene's {} actuators, expected {}", actuators.size(),
                                 inputs.shown.empty() ? options : inputs.shown));
  }
  std::vector<std::string> texts;
  for (std::size_t from = 0; from <= inputs.text.size();) {
    const std::size_t comma = std::min(inputs.text.find(',', from), inputs.text.size());
    const std::size_t first = inputs.text.find_first_not_of(" \t", from);
    const std::string one = first < comma ? inputs.text.substr(first, comma - first) : "";
    texts.push_back(one.substr(0, one.find_last_not_of(" \t") + 1));
    from = comma + 1;
  }
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
                      "'moment_per_pressure' in [[rod.actuator]], or --moments",
                      where));
    }
    if (inputs.kind == InputKind::moments && actuator.kind != ActuatorKind::moment) {
      throw InputError(fmt::format("{}: found a moment for an actuator of kind \"{}\", expected --inputs", where,
                                   to_string(actuator.kind)));
    }
    const bool told = inputs.kind != InputKind::moments;
    std::optional<std::pair<Dimension, std::string>> hint;
    if (told) {
      hint.emplace(dimension::moment, "--moments takes moments");
    } else if (actuator.knows_pressure()) {
      hint.emplace(dimension::pressure, "--pressures takes pressures");
    }
    const double value =
        read_number(texts[a], told ? actuator.input_dimension() : dimension::moment, where, session.units(), hint);
    if (actuator.kind == ActuatorKind::tendon && value < 0.0) {
      throw InputError(fmt::format(
          "{}: found a tension of {} N, expected one that is not negative: a tendon only pulls", where, value));
    }
    moments.push_back(told ? actuator.moment_of(value) : value);
  }
  if (texts.size() != actuators.size()) {
    throw InputError(fmt::format("{}: found {} {}, expected one for each of the scene's {} actuators", option,
                                 texts.size(), std::string(option_of(inputs.kind)).substr(2), actuators.size()));
  }
  return moments;
}

std::vector<TrajectoryStep> way_points_of(const Inputs& inputs, const Session& session) {
  std::vector<TrajectoryStep> steps;
  const std::string option = inputs.shown.empty() ? option_of(inputs.kind) : inputs.shown;
  if (session.scene().problem == ProblemKind::grasp) {
    throw InputError(option +
                     ": found several lists, but the fingers of a grasp are executed one by one, expected one");
  }
  for (std::size_t from = 0; from <= inputs.text.size();) {
    const std::size_t end = std::min(inputs.text.find(';', from), inputs.text.size());
    Inputs one = inputs;
    one.text = inputs.text.substr(from, end - from);
    one.shown = fmt::format("{}, way point {}", option, steps.size() + 1);
    steps.emplace_back().plan.moments = moments_of(one, session);
    steps.back().target = session.scene().target;
    from = end + 1;
  }
  return steps;
}

std::variant<Execution, Trajectory> execute_result(Session& session, const files::ResultText& earlier,
                                                   const std::optional<Plan>& start) {
  const std::vector<TrajectoryStep> steps = parse_steps(earlier.text, earlier.name, session.scene());
  if (!steps.empty()) return session.execute(steps, start);
  const Plan plan = parse_start(earlier.text, earlier.name, session.scene(), "plan");
  std::optional<double> palm_distance;
  if (plan.grasp) palm_distance = plan.grasp->palm_distance;
  return session.execute(all_moments(plan), start, palm_distance);
}

}  // namespace tendril::app
