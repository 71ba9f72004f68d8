#include "tendril/app/commands.hpp"

#include <fmt/format.h>

#include <variant>

#include "command/calibrate_command.hpp"
#include "command/estimate_command.hpp"
#include "command/result_files.hpp"
#include "command/trajectory_command.hpp"
#include "figure/drawing.hpp"
#include "figure/movie.hpp"
#include "figure/picture.hpp"
#include "result/json_reader.hpp"
#include "session/inputs.hpp"
#include "session/sensitivities.hpp"
#include "system/output.hpp"
#include "system/tables.hpp"
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

std::optional<Plan> start_of(const std::optional<std::filesystem::path>& path, const Session& session) {
  if (!path) return std::nullopt;
  return read_start(*path, session.scene());
}

}  // namespace

int run_plan(const PlanArguments& arguments) {
  try_places(arguments.places);
  Session session(arguments.scene);
  note_dropped(session);
  if (session.scene().problem == ProblemKind::estimate) return run_estimate(session, arguments);
  if (session.scene().problem == ProblemKind::trajectory) return run_trajectory(session, arguments);
  const std::optional<Plan> start = start_of(arguments.start, session);
  Plan plan = session.plan(start);
  if (arguments.verify) session.verify(plan, start);
  const RunInfo run = session.run_info();
  give_result(arguments.places,
              {[&] { return plan_json(session.scene(), plan, run); },
               [&] { return plan_report(session.scene(), plan, run); }, "the plan came to no shape"},
              session);
  return plan.status == PlanStatus::solved && !(arguments.strict && plan.search_cut) ? 0 : 1;
}

int run_execute(const ExecuteArguments& arguments) {
  try_places(arguments.places);
  Session session(arguments.scene);
  note_dropped(session);
  const std::optional<Plan> start = start_of(arguments.start, session);
  std::variant<Execution, Trajectory> executed;
  if (arguments.plan) {
    const files::ResultText earlier{read_input(*arguments.plan, "plan"), arguments.plan->string()};
    executed = execute_result(session, earlier, start, arguments.inputs);
  } else if (are_way_points(arguments.inputs)) {
    executed = session.execute(way_points_of(arguments.inputs, session, start), start);
  } else {
    const Plan held = held_of(arguments.inputs, session, start);
    executed = session.execute(held.moments, start, std::nullopt, held.place);
  }
  if (const auto* trajectory = std::get_if<Trajectory>(&executed)) {
    return give_trajectory(session, *trajectory, arguments.places);
  }
  const auto& execution = std::get<Execution>(executed);
  const RunInfo run = session.run_info();
  give_result(arguments.places,
              {[&] { return execution_json(session.scene(), execution, run); },
               [&] { return execution_report(session.scene(), execution, run); }, "the rod came to no shape"},
              session);
  return execution.result.status == PlanStatus::solved ? 0 : 1;
}

int run_calibrate(const CalibrateArguments& arguments) {
  try_places(arguments.places);
  Session session(arguments.scene);
  note_dropped(session);
  return run_calibrate(session, arguments.places);
}

int run_sensitivity(const SensitivityArguments& arguments) {
  Session session(arguments.scene);
  note_dropped(session);
  const SceneSensitivity found = sensitivities_of(session, arguments.wishes);
  print(arguments.json ? sensitivity_json(session.scene(), found.of, found.keys)
                       : sensitivity_report(session.scene(), found.of, found.keys));
  return found.of.trouble.empty() ? 0 : 1;
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

std::vector<std::string> write_view(const files::ResultText& result, const std::filesystem::path& file,
                                    plugins::Registry& registry, const std::atomic<bool>* stop) {
  if (is_movie(file)) {
    require_movie(file);
  } else {
    picture_of(file);
  }
  const Json drawing = drawing_of(parse_result(result.text, result.name, "result"), result.name, registry);
  if (!has_shape(drawing)) throw InputError("no figure: " + result.name + " holds no shape");
  write_picture(file, drawing, stop);
  return drawing["notes"];
}

int run_view(const ViewArguments& arguments) {
  std::filesystem::path page = arguments.output.value_or(arguments.result.filename().replace_extension(".html"));
  plugins::Registry registry(plugins::Catalog(plugins::search_places(arguments.plugin_directories)));
  const files::ResultText result{read_input(arguments.result, "result", largest_result), arguments.result.string()};
  for (const std::string& text : write_view(result, page, registry)) note(text);
  print("wrote " + printable(page.string()) + '\n');
  return 0;
}

int run_plugins(const std::vector<std::filesystem::path>& plugin_directories, bool json) {
  print(plugin_list(plugin_directories, json));
  return 0;
}

}  // namespace tendril::app
