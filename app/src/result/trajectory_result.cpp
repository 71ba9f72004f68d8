#include "result/trajectory_result.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "result/grasp_result.hpp"
#include "result/report_parts.hpp"
#include "result/uncertainty_result.hpp"
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

Effort sum_of(const Trajectory& trajectory, Effort TrajectoryStep::*part) {
  Effort sum;
  for (const TrajectoryStep& step : trajectory.steps) sum += step.*part;
  return sum;
}

/// Of one quantity over the steps that have it.
struct Errors {
  int count = 0;
  double mean = 0.0;
  double largest = 0.0;
  std::size_t at = 0;  ///< index of the step with the largest one
};

Errors errors_of(const Trajectory& trajectory, std::optional<double> Plan::*error) {
  Errors e;
  for (std::size_t i = 0; i < trajectory.steps.size(); ++i) {
    const std::optional<double>& value = trajectory.steps[i].plan.*error;
    if (!value) continue;
    if (e.count == 0 || *value > e.largest) {
      e.largest = *value;
      e.at = i;
    }
    e.mean += (*value - e.mean) / ++e.count;
  }
  return e;
}

Json errors_json(const Errors& e) {
  if (e.count == 0) return nullptr;
  return {{"mean", number(e.mean)}, {"largest", number(e.largest)}, {"step", e.at + 1}};
}

bool cut(const TrajectoryStep& step) { return step.plan.search_cut && step.plan.status == PlanStatus::solved; }

std::string status_of(const Trajectory& trajectory) {
  if (trajectory.interrupted) return "interrupted";
  for (const TrajectoryStep& step : trajectory.steps) {
    if (step.plan.status != PlanStatus::solved) return std::string(to_string(step.plan.status));
  }
  return "solved";
}

bool executed(const TrajectoryStep& step) {
  return step.method == StepMethod::executed || !step.plan.verification.empty();
}

bool verified(const Trajectory& trajectory) {
  return std::any_of(trajectory.steps.begin(), trajectory.steps.end(),
                     [](const TrajectoryStep& step) { return !step.plan.verification.empty(); });
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
  if (std::any_of(trajectory.steps.begin(), trajectory.steps.end(), cut)) json["search_cut"] = true;
  json["target_error"] = errors_json(errors_of(trajectory, &Plan::target_error));
  if (verified(trajectory)) json["model_error"] = errors_json(errors_of(trajectory, &Plan::model_error));
  json["effort"] = effort_json(sum_of(trajectory, &TrajectoryStep::effort));
  if (scene.trajectory.cold_starts) {
    json["cold_starts"] = effort_json(sum_of(trajectory, &TrajectoryStep::cold));
  }
  Json steps = Json::array();
  for (const TrajectoryStep& step : trajectory.steps) {
    Json one = plan_object(scene, step.plan);
    one["target"] = target_json(step.target);
    if (!step.target.obstacles.empty()) one["moved_obstacles"] = moved_obstacles_json(scene, step.target.obstacles);
    one["method"] = to_string(step.method);
    if (executed(step)) one["snaps"] = snaps_json(step.snaps);
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
  for (std::size_t i = 0; i < run.uncertainties.size(); ++i) {
    json["steps"][i]["uncertainty"] = uncertainty_json(run.uncertainties[i]);
  }
  add_surroundings(json, scene);
  json["plugins"] = components_json(run.components);
  json["versions"] = versions_json();
  return written(json);
}

namespace {

std::string step_status(const TrajectoryStep& step) {
  return std::string(to_string(step.plan.status)) + (cut(step) ? ", search cut by time" : "");
}

std::vector<std::string> step_cells(const Scene& scene, const TrajectoryStep& step, std::size_t number,
                                    const DisplayUnits& units) {
  const Plan& plan = step.plan;
  std::string contact;
  double force_sum = 0.0;
  for (const PlannedContact& c : plan.contacts) {
    if (c.force <= 0.0) continue;
    contact += (contact.empty() ? "" : ", ") + printable(c.obstacle_name) + (c.at_tip ? " (tip)" : "");
    force_sum += c.force;
  }
  std::string moments;
  for (const double m : plan.moments) moments += (moments.empty() ? "" : ", ") + units.moment(m + 0.0);
  std::string pressures;
  for (const std::optional<double>& p : pressures_of(scene, plan)) {
    if (p) pressures += (pressures.empty() ? "" : ", ") + units.pressure(*p);
  }
  if (!pressures.empty()) moments += " (" + pressures + ")";
  return {std::to_string(number),
          step.target.position ? units.point(*step.target.position) : "-",
          plan.backbone.empty() ? "-" : units.point({plan.tip_x, plan.tip_y}),
          plan.target_error ? units.lengths(*plan.target_error) : "-",
          moments,
          contact.empty() ? "-" : contact,
          contact.empty() ? "-" : force(force_sum),
          fmt::format("{:.3g}", plan.certificate.stability),
          step.method == StepMethod::subdivided ? fmt::format("over {} intermediate targets", step.intermediate)
                                                : std::string(to_string(step.method)),
          step_status(step)};
}

std::string errors_text(const std::string& name, const Errors& e, const DisplayUnits& units) {
  if (e.count == 0) return "";
  return fmt::format("{}: mean {}, largest {} at step {}\n", name, units.lengths(e.mean), units.lengths(e.largest),
                     e.at + 1);
}

/// Targets that no shape of the rod can reach; empty: there is none.
std::string reach_text(const Scene& scene) {
  if (scene.coordinates.stretch_order > 0) return "";
  const double length = scene.rod.length();
  double farthest = 0.0;
  int beyond = 0;
  for (const TargetSpec& target : scene.trajectory.targets) {
    const double distance = target.position ? norm(*target.position - scene.rod.base_position) : 0.0;
    farthest = std::max(farthest, distance);
    if (distance > length * (1.0 + 1e-9)) ++beyond;
  }
  if (beyond == 0) return "";
  const bool thousandth = farthest > 10.0 * length && 1e-3 * farthest <= 1.5 * length;
  return fmt::format("{} of {} targets lie out of reach, by up to {:.3g} % of the length{}\n\n", beyond,
                     scene.trajectory.targets.size(), 100.0 * (farthest / length - 1.0),
                     thousandth ? ": are they in mm? A plain number is in m" : "");
}

}  // namespace

std::string trajectory_report(const Scene& scene, const Trajectory& trajectory) {
  const DisplayUnits units(scene);
  const auto count = [&](const auto& which) {
    return std::count_if(trajectory.steps.begin(), trajectory.steps.end(), which);
  };
  std::string text = heading(scene) + '\n';
  if (const auto cuts = count(cut); cuts > 0) {
    text += fmt::format("time ended the search of {} steps before it was done: better plans may exist\n\n", cuts);
  }
  text += reach_text(scene);
  Grid grid;
  grid.row({"step", "target", "tip", "error", "moments", "contact", "force", "stability", "reached", "status"});
  for (std::size_t i = 0; i < trajectory.steps.size(); ++i)
    grid.row(step_cells(scene, trajectory.steps[i], i + 1, units));
  text += grid.text("");
  const auto solved = count([](const TrajectoryStep& s) { return s.plan.status == PlanStatus::solved; });
  const bool executed = count([](const TrajectoryStep& s) { return s.method == StepMethod::executed; }) > 0;
  if (executed) {
    text += fmt::format("\n{} of {} steps came to rest, each led on from the one before\n", solved,
                        trajectory.steps.size());
  } else {
    text += fmt::format("\n{} of {} steps solved, {} without a call of the solver\n", solved,
                        scene.trajectory.targets.size(),
                        count([](const TrajectoryStep& s) { return s.method == StepMethod::followed; }));
  }
  text += errors_text("distance to the targets", errors_of(trajectory, &Plan::target_error), units);
  if (verified(trajectory)) {
    text += errors_text("executed, each step from the one before, tips come to rest beside the plans'",
                        errors_of(trajectory, &Plan::model_error), units);
  }
  if (!executed) text += "warm: " + effort_text(sum_of(trajectory, &TrajectoryStep::effort)) + '\n';
  if (scene.trajectory.cold_starts && !executed) {
    text += "cold: " + effort_text(sum_of(trajectory, &TrajectoryStep::cold)) + '\n';
  }
  for (std::size_t i = 0; i < trajectory.steps.size(); ++i) {
    const Plan& plan = trajectory.steps[i].plan;
    for (const Snap& snap : trajectory.steps[i].snaps) {
      text += fmt::format("step {}: the rod snaps at {:.4g} of the way ({})\n", i + 1, snap.load, to_string(snap.kind));
    }
    if (!plan.message.empty()) text += fmt::format("step {}: {}\n", i + 1, printable(plan.message));
  }
  return text;
}

}  // namespace tendril::app
