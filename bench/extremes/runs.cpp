#include "extremes/runs.hpp"

#include <algorithm>
#include <optional>

#include "common/workload.hpp"
#include "tendril/execute.hpp"
#include "tendril/plugins/components.hpp"
#include "tendril/trajectory.hpp"

namespace tendril::bench {

namespace {

Verdict verdict_of(const Plan& plan) {
  const bool extended =
      std::any_of(plan.contacts.begin(), plan.contacts.end(), [](const PlannedContact& c) { return c.extended; });
  return extended && plan.status != PlanStatus::solved ? "extended" : std::string(to_string(plan.status));
}

template <class Work>
CaseRun timed(Work&& work) {
  CaseRun out;
  const double begin = now();
  try {
    work(out);
    out.verdict = verdict_of(out.plan);
  } catch (const Error& error) {
    out.verdict = "refused";
    out.plan.message = error.what();
  }
  out.seconds = now() - begin;
  return out;
}

}  // namespace

CaseRun planned(plugins::Registry& registry, const Scene& scene) {
  return timed([&](CaseRun& out) { out.plan = timed_plan(registry, scene).plan; });
}

CaseRun led(plugins::Registry& registry, const Scene& scene, const std::vector<Vec2>& targets) {
  return timed([&](CaseRun& out) {
    Problem problem(scene, plugins::make_components(registry, scene));
    std::vector<TargetSpec> all;
    all.reserve(targets.size());
    for (const Vec2 at : targets) all.push_back({scene.rod.length() * at, std::nullopt});
    Trajectory trajectory = plan_trajectory(all, {}, [&](const TargetSpec& target, const Plan* start, bool follow) {
      problem.set_target(target);
      PlanControl control;
      control.start = start;
      control.follow = follow;
      return problem.plan(control);
    });
    out.earlier.reserve(trajectory.steps.size());
    for (TrajectoryStep& step : trajectory.steps) out.earlier.push_back(std::move(step.plan));
    out.plan = std::move(out.earlier.back());
    out.earlier.pop_back();
  });
}

CaseRun carried_out(plugins::Registry& registry, const Scene& scene, const std::vector<double>& moments,
                    const std::vector<double>& before) {
  return timed([&](CaseRun& out) {
    const auto obstacles = plugins::make_obstacles(registry, scene);
    ExecuteControl control;
    control.time_limit = case_time_limit;
    if (!before.empty()) {
      out.earlier.push_back(execute(scene, obstacles, before, control).result);
      control.start = &out.earlier.front();
    }
    Execution last = execute(scene, obstacles, moments, control);
    out.pieces = last.pieces;
    out.snaps = static_cast<int>(last.snaps.size());
    out.plan = std::move(last.result);
  });
}

ExactState exact_of(plugins::Registry& registry, const Scene& scene, const Plan& plan) {
  const auto obstacles = plugins::make_obstacles(registry, scene);
  ExactState exact = exact_state(scene, obstacles, plan, plan);
  if (exact.found) return exact;
  ExecuteControl control;
  control.time_limit = case_time_limit;
  control.start = &plan;
  control.with_obstacles = needs_obstacles(scene);
  const Plan settled = execute(scene, obstacles, plan, control).result;
  if (settled.status != PlanStatus::solved) return exact;
  return exact_state(scene, obstacles, plan, settled);
}

}  // namespace tendril::bench
