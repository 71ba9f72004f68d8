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

/// One moment per actuator from the text of --moments.
std::vector<double> read_moments(const std::string& text, const Session& session) {
  std::vector<double> moments;
  const std::size_t actuators = actuator_count(session.scene());
  if (actuators == 0 && text.find_first_not_of(" \t") == std::string::npos) return moments;
  for (std::size_t from = 0; from <= text.size();) {
    const std::size_t comma = std::min(text.find(',', from), text.size());
    const std::size_t first = text.find_first_not_of(" \t", from);
    const std::string one = first < comma ? text.substr(first, comma - first) : "";
    const std::string trimmed = one.substr(0, one.find_last_not_of(" \t") + 1);
    double value = 0.0;
    const char* const end = trimmed.data() + trimmed.size();
    const auto [rest, code] = std::from_chars(trimmed.data(), end, value);
    from = comma + 1;
    if (code == std::errc{} && rest == end && std::isfinite(value)) {
      moments.push_back(value);
      continue;
    }
    try {
      moments.push_back(session.units().read(trimmed, dimension::moment));
    } catch (const QuantityError& error) {
      throw InputError(fmt::format("--moments, number {}: {}", moments.size() + 1, error.what()));
    }
  }
  if (moments.size() != actuators) {
    throw InputError(fmt::format("--moments: found {} moments, expected one for each of the scene's {} actuators",
                                 moments.size(), actuators));
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
  std::optional<Plan> plan;
  if (arguments.plan) plan = read_start(*arguments.plan, session.scene(), "plan");
  const std::vector<double> moments = plan ? all_moments(*plan) : read_moments(arguments.moments, session);
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
