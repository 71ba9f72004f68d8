#include "result/trajectory_result.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "result/report_parts.hpp"
#include "system/tables.hpp"

namespace tendril::app {

namespace {

Json effort_json(const Effort& effort) {
  return {{"solver_calls", effort.solver_calls},
          {"polishes", effort.polishes},
          {"evaluations",
           {{"values", effort.evaluations.values},
            {"first_derivatives", effort.evaluations.first_derivatives},
            {"hessians", effort.evaluations.hessians}}}};
}

Json target_json(const TargetSpec& target) {
  Json json = Json::object();
  if (target.position) json["position"] = numbers({target.position->x, target.position->y});
  if (target.angle) json["angle"] = number(*target.angle);
  return json;
}

Effort sum_of(const Trajectory& trajectory, Effort TrajectoryStep::*part) {
  Effort sum;
  for (const TrajectoryStep& step : trajectory.steps) sum += step.*part;
  return sum;
}

std::string status_of(const Trajectory& trajectory) {
  if (trajectory.interrupted) return "interrupted";
  for (const TrajectoryStep& step : trajectory.steps) {
    if (step.plan.status != PlanStatus::solved) return std::string(to_string(step.plan.status));
  }
  return "solved";
}

std::string effort_text(const Effort& effort) {
  return fmt::format("{} solver calls, {} polishes; {} values, {} derivatives, {} Hessians", effort.solver_calls,
                     effort.polishes, effort.evaluations.values, effort.evaluations.first_derivatives,
                     effort.evaluations.hessians);
}

}  // namespace

Json trajectory_object(const Scene& scene, const Trajectory& trajectory) {
  Json json;
  json["status"] = status_of(trajectory);
  json["effort"] = effort_json(sum_of(trajectory, &TrajectoryStep::effort));
  if (scene.trajectory.cold_starts) {
    json["cold_starts"] = effort_json(sum_of(trajectory, &TrajectoryStep::cold));
  }
  Json steps = Json::array();
  for (const TrajectoryStep& step : trajectory.steps) {
    Json one = plan_object(scene, step.plan);
    one["target"] = target_json(step.target);
    one["method"] = to_string(step.method);
    one["intermediate_targets"] = step.intermediate;
    one["effort"] = effort_json(step.effort);
    if (scene.trajectory.cold_starts) one["cold_start"] = effort_json(step.cold);
    steps.push_back(std::move(one));
  }
  json["steps"] = std::move(steps);
  return json;
}

std::string trajectory_json(const Scene& scene, const Trajectory& trajectory, const RunInfo& run) {
  Json json;
  json["schema"] = 1;
  json["scene"] = scene.file;
  json["title"] = scene.title;
  json["problem"] = to_string(scene.problem);
  json.update(trajectory_object(scene, trajectory));
  json["plugins"] = components_json(run.components);
  json["versions"] = versions_json();
  return written(json);
}

std::string trajectory_report(const Scene& scene, const Trajectory& trajectory) {
  const DisplayUnits units(scene.rod.length());
  std::string text = heading(scene) + '\n';
  Grid grid;
  grid.row({"step", "target", "tip", "error", "moments", "contact", "force", "stability", "reached", "status"});
  for (std::size_t i = 0; i < trajectory.steps.size(); ++i) {
    const TrajectoryStep& step = trajectory.steps[i];
    const Plan& plan = step.plan;
    std::string contact;
    double force_sum = 0.0;
    for (const PlannedContact& c : plan.contacts) {
      if (c.force <= 0.0) continue;
      contact += (contact.empty() ? "" : ", ") + printable(c.obstacle_name) + (c.at_tip ? " (tip)" : "");
      force_sum += c.force;
    }
    std::string moments;
    for (const double m : plan.moments) moments += (moments.empty() ? "" : ", ") + units.moment(m);
    grid.row({std::to_string(i + 1), step.target.position ? units.point(*step.target.position) : "-",
              plan.backbone.empty() ? "-" : units.point({plan.tip_x, plan.tip_y}),
              plan.target_error ? units.lengths(*plan.target_error) : "-", moments, contact.empty() ? "-" : contact,
              contact.empty() ? "-" : force(force_sum), fmt::format("{:.3g}", plan.certificate.stability),
              step.method == StepMethod::subdivided ? fmt::format("over {} intermediate targets", step.intermediate)
                                                    : std::string(to_string(step.method)),
              std::string(to_string(plan.status))});
  }
  text += grid.text("");
  text += fmt::format("\n{} of {} steps solved, {} without a call of the solver\n",
                      std::count_if(trajectory.steps.begin(), trajectory.steps.end(),
                                    [](const TrajectoryStep& s) { return s.plan.status == PlanStatus::solved; }),
                      scene.trajectory.targets.size(),
                      std::count_if(trajectory.steps.begin(), trajectory.steps.end(),
                                    [](const TrajectoryStep& s) { return s.method == StepMethod::followed; }));
  text += "warm: " + effort_text(sum_of(trajectory, &TrajectoryStep::effort)) + '\n';
  if (scene.trajectory.cold_starts) {
    text += "cold: " + effort_text(sum_of(trajectory, &TrajectoryStep::cold)) + '\n';
  }
  for (std::size_t i = 0; i < trajectory.steps.size(); ++i) {
    const Plan& plan = trajectory.steps[i].plan;
    if (!plan.message.empty()) text += fmt::format("step {}: {}\n", i + 1, printable(plan.message));
  }
  return text;
}

}  // namespace tendril::app
