#include "tendril/app/commands.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "command/estimate_command.hpp"
#include "command/result_files.hpp"
#include "command/trajectory_command.hpp"
#include "result/grasp_result.hpp"
#include "system/output.hpp"
#include "system/tables.hpp"
#include "tendril/app/figure.hpp"
#include "tendril/app/files.hpp"
#include "tendril/app/input_error.hpp"
#include "tendril/app/plugin_list.hpp"
#include "tendril/app/report.hpp"
#include "tendril/app/result.hpp"

namespace tendril::app {

namespace {

void note_dropped(const Session& session) {
  for (const std::string& warning : session.scene().warnings) note(printable(warning));
  std::string text;
  for (const LeftOut& item : session.dropped())
    text += fmt::format("{}{} ({})", text.empty() ? "dropped " : ", ", item.what, item.why);
  if (!text.empty()) note(printable(text));
}

ResultForms forms_of(Session& session, const Plan& plan, std::function<std::string()> json,
                     std::function<std::string()> report) {
  ResultForms forms{std::move(json), std::move(report), {}, "the plan came to no shape"};
  if (plan.backbone.empty()) return forms;
  forms.draw = [&session, &plan](StagedFiles& files, const std::string& stem, const std::vector<Picture>& pictures) {
    FigureScene figure = figure_scene(session.scene(), session.make_obstacles());
    add_gripper(figure, session.scene(), plan);
    if (plan.status != PlanStatus::solved) figure.doubt = to_string(plan.status);
    draw_figure(figure, plan, files, stem, pictures);
  };
  return forms;
}

/// One number of --moments, --pressures or --inputs: SI, or with a unit.
double read_input_number(const std::string& text, const Dimension& wanted, const std::string& where,
                         const Units& units) {
  double value = 0.0;
  const char* const end = text.data() + text.size();
  const auto [rest, code] = std::from_chars(text.data(), end, value);
  if (code == std::errc{} && rest == end && std::isfinite(value)) return value;
  try {
    return units.read(text, wanted);
  } catch (const QuantityError& error) {
    throw InputError(fmt::format("{}: {}", where, error.what()));
  }
}

/// One moment (N m) per actuator, from the text of the option that says what moves them.
std::vector<double> read_moments(const Inputs& inputs, const Session& session) {
  const std::vector<ActuatorSpec> actuators = actuators_of(session.scene());
  const std::string option = inputs.option();
  if (actuators.empty() && inputs.text.find_first_not_of(" \t") == std::string::npos) return {};
  if (inputs.kind == InputKind::none) {
    throw InputError(
        fmt::format("execute needs what moves the scene's {} actuators, expected --moments \"M, ...\" or --plan "
                    "RESULT.json, or --pressures \"P, ...\", or --inputs \"V, ...\" in the unit of each",
                    actuators.size()));
  }
  std::vector<std::string> texts;
  for (std::size_t from = 0; from <= inputs.text.size();) {
    const std::size_t comma = std::min(inputs.text.find(',', from), inputs.text.size());
    const std::size_t first = inputs.text.find_first_not_of(" \t", from);
    const std::string one = first < comma ? inputs.text.substr(first, comma - first) : "";
    texts.push_back(one.substr(0, one.find_last_not_of(" \t") + 1));
    from = comma + 1;
  }
  if (texts.size() != actuators.size()) {
    throw InputError(fmt::format("{}: found {} {}, expected one for each of the scene's {} actuators", option,
                                 texts.size(), option.substr(2), actuators.size()));
  }
  std::vector<double> moments;
  moments.reserve(texts.size());
  for (std::size_t a = 0; a < texts.size(); ++a) {
    const ActuatorSpec& actuator = actuators[a];
    const std::string where = fmt::format("{}, number {}", option, a + 1);
    if (inputs.kind == InputKind::pressures && actuator.input() != ActuatorKind::pressure) {
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
    const double value =
        read_input_number(texts[a], told ? actuator.input_dimension() : dimension::moment, where, session.units());
    if (actuator.kind == ActuatorKind::tendon && value < 0.0) {
      throw InputError(fmt::format(
          "{}: found a tension of {} N, expected one that is not negative: a tendon only pulls", where, value));
    }
    moments.push_back(told ? value * actuator.moment_per_input() : value);
  }
  return moments;
}

}  // namespace

int run_plan(const PlanArguments& arguments) {
  try_places(arguments.places);
  Session session(arguments.scene);
  note_dropped(session);
  if (session.scene().problem == ProblemKind::estimate) return run_estimate(session, arguments);
  if (session.scene().problem == ProblemKind::trajectory) return run_trajectory(session, arguments);
  Plan plan = session.plan(arguments.start);
  if (arguments.verify) session.verify(plan, arguments.start);
  const RunInfo run = session.run_info();
  give_result(arguments.places, forms_of(
                                    session, plan, [&] { return plan_json(session.scene(), plan, run); },
                                    [&] { return plan_report(session.scene(), plan, run); }));
  return plan.status == PlanStatus::solved && !(arguments.strict && plan.search_cut) ? 0 : 1;
}

int run_execute(const ExecuteArguments& arguments) {
  try_places(arguments.places);
  Session session(arguments.scene);
  note_dropped(session);
  if (arguments.plan) {
    const std::vector<TrajectoryStep> steps = read_steps(*arguments.plan, session.scene(), "plan");
    if (!steps.empty()) return give_trajectory(session, session.execute(steps, arguments.start), arguments.places);
  }
  std::optional<Plan> plan;
  if (arguments.plan) plan = read_start(*arguments.plan, session.scene(), "plan");
  const std::vector<double> moments = plan ? all_moments(*plan) : read_moments(arguments.inputs, session);
  std::optional<double> palm_distance;
  if (plan && plan->grasp) palm_distance = plan->grasp->palm_distance;
  const Execution execution = session.execute(moments, arguments.start, palm_distance);
  const RunInfo run = session.run_info();
  give_result(arguments.places,
              forms_of(
                  session, execution.result, [&] { return execution_json(session.scene(), execution, run); },
                  [&] { return execution_report(session.scene(), execution, run); }));
  return execution.result.status == PlanStatus::solved ? 0 : 1;
}

int run_describe(const SceneArguments& arguments, bool json) {
  Session session(arguments);
  note_dropped(session);
  Description description = session.describe();
  description.left_out.insert(description.left_out.end(), session.dropped().begin(), session.dropped().end());
  const RunInfo run = session.run_info();
  print(json ? description_json(session.scene(), description, run)
             : description_report(session.scene(), description, run));
  return 0;
}

int run_plugins(const std::vector<std::filesystem::path>& plugin_directories, bool json) {
  print(plugin_list(plugin_directories, json));
  return 0;
}

}  // namespace tendril::app
