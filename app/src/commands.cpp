#include "tendril/app/commands.hpp"

#include <fmt/format.h>

#include "output.hpp"
#include "tendril/app/figure.hpp"
#include "tendril/app/files.hpp"
#include "tendril/app/input_error.hpp"
#include "tendril/app/plugin_list.hpp"
#include "tendril/app/report.hpp"
#include "tendril/app/result.hpp"
#include "trajectory_command.hpp"

namespace tendril::app {

namespace {

void note_dropped(const Session& session) {
  std::string text;
  for (const LeftOut& item : session.dropped())
    text += fmt::format("{}{} ({})", text.empty() ? "dropped " : ", ", item.what, item.why);
  if (!text.empty()) note(text);
}

/// A plan that came to no shape cannot be drawn.
bool has_shape(const Plan& plan) {
  if (plan.backbone.empty()) note("no figure: the plan came to no shape");
  return !plan.backbone.empty();
}

void write_output(Session& session, const Plan& plan, const std::string& json, const std::filesystem::path& directory) {
  {
    StagedFiles files(directory);
    files.write("result.json", json);
    files.publish();
  }
  if (!has_shape(plan)) return;
  // A result without its picture is still a result.
  try {
    StagedFiles files(directory);
    draw_figure(figure_scene(session.scene(), session.make_obstacles()), plan, files, "figure",
                {Picture::svg, Picture::png});
    files.publish();
  } catch (const InputError& error) {
    note(error.what());
  }
}

void write_figure(Session& session, const Plan& plan, const std::filesystem::path& file) {
  if (!has_shape(plan)) return;
  StagedFiles files(file.parent_path());
  draw_figure(figure_scene(session.scene(), session.make_obstacles()), plan, files, file.stem().string(),
              {picture_of(file)});
  files.publish();
}

}  // namespace

int run_plan(const PlanArguments& arguments) {
  // What cannot be written had better be known before the work begins.
  if (arguments.figure) {
    picture_of(*arguments.figure);
    const StagedFiles trial(arguments.figure->parent_path());
  }
  if (arguments.output) const StagedFiles trial(*arguments.output);
  Session session(arguments.scene);
  note_dropped(session);
  if (session.scene().problem == ProblemKind::trajectory) return run_trajectory(session, arguments);
  const Plan plan = session.plan(arguments.start);
  const RunInfo run = session.run_info();
  const std::string json = arguments.json || arguments.output ? plan_json(session.scene(), plan, run) : "";
  if (arguments.output) write_output(session, plan, json, *arguments.output);
  if (arguments.figure) write_figure(session, plan, *arguments.figure);
  print(arguments.json ? json : plan_report(session.scene(), plan, run));
  return plan.status == PlanStatus::solved ? 0 : 1;
}

int run_describe(const SceneArguments& arguments, bool json) {
  Session session(arguments);
  note_dropped(session);
  Description description = session.problem().describe();
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
