#include "solver_comparison.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <map>
#include <tuple>

#include "tendril/planner.hpp"
#include "tendril/plugins/components.hpp"
#include "workload.hpp"

namespace tendril::bench {

namespace {

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// Plans of one program that end at the same minimum differ by rounding; a second minimum differs by far more.
bool equally_good(double objective, double best) { return objective <= best + 1e-6 * std::max(best, 1e-6); }

Scene variant(const SolverComparisonSetup& setup, int limit, int target, const std::string& solver) {
  Scene scene = setup.scene;
  if (!setup.targets.empty()) scene.target.position = setup.targets[static_cast<std::size_t>(target)];
  if (!setup.limits.empty()) {
    for (ActuatorSpec& actuator : scene.rod.actuators) {
      actuator.maximum = setup.limits[static_cast<std::size_t>(limit)];
      actuator.minimum = -actuator.maximum;
    }
  }
  // Options belong to the solver that the scene names.
  if (scene.solver.plugin != solver) scene.solver.options.clear();
  scene.solver.plugin = solver;
  return scene;
}

SolverRun run_of(const Plan& plan, double seconds, const std::vector<Vec2>& references) {
  SolverRun run;
  run.status = to_string(plan.status);
  run.sides = sides(plan, references);
  run.objective = plan.objective;
  run.seconds = seconds;
  double best = infinity;
  for (const ModeRecord& mode : plan.modes) {
    run.solves += mode.solves;
    run.iterations += mode.iterations;
    run.evaluations += mode.evaluations;
    if (!mode.certified || mode.objective >= best) continue;
    best = mode.objective;
    run.mode = mode.mode;
    run.mode_seconds = mode.seconds;
    run.mode_evaluating = mode.seconds_evaluating;
    run.mode_iterations = mode.iterations;
    run.mode_evaluations = mode.evaluations;
  }
  return run;
}

void judge(std::vector<SolverRun>& runs) {
  std::map<std::tuple<int, int, std::string>, double> best;
  const auto key = [](const SolverRun& run) { return std::tuple(run.limit, run.target, run.sides); };
  for (const SolverRun& run : runs) {
    if (run.status != "solved") continue;
    const auto [entry, added] = best.emplace(key(run), run.objective);
    if (!added) entry->second = std::min(entry->second, run.objective);
  }
  for (SolverRun& run : runs) {
    const auto entry = best.find(key(run));
    run.best = entry != best.end() ? entry->second : infinity;
    run.reached = run.status == "solved" && equally_good(run.objective, run.best);
  }
}

}  // namespace

std::vector<SolverRun> compare_solvers(plugins::Registry& registry, const SolverComparisonSetup& setup) {
  const int limits = std::max<int>(1, static_cast<int>(setup.limits.size()));
  const int targets = std::max<int>(1, static_cast<int>(setup.targets.size()));
  const int starts = std::max(1, setup.starts);
  const double length = setup.scene.rod.length();
  std::vector<Vec2> references;
  for (const auto& obstacle : plugins::make_obstacles(registry, setup.scene)) {
    references.push_back(length * obstacle->reference_point());
  }
  std::vector<SolverRun> runs;
  const bool terminal = ::isatty(STDERR_FILENO) != 0;
  const std::size_t total = static_cast<std::size_t>(limits * targets * starts) * setup.solvers.size();
  const auto stopped = [&] { return setup.stop != nullptr && setup.stop->load(); };
  Uniform random(setup.seed);
  for (int start = 0; start < starts; ++start) {
    for (int limit = 0; limit < limits; ++limit) {
      for (int target = 0; target < targets && !stopped(); ++target) {
        const Plan shape = random_start(random, length);
        for (const std::string& solver : setup.solvers) {
          const Scene scene = variant(setup, limit, target, solver);
          Problem problem(scene, plugins::make_components(registry, scene));
          PlanControl control;
          control.stop = setup.stop;
          if (setup.starts > 0) control.start = &shape;
          const double begin = now();
          const Plan plan = problem.plan(control);
          if (stopped()) break;
          SolverRun run = run_of(plan, now() - begin, references);
          run.solver = solver;
          run.limit = limit;
          run.target = target;
          run.start = start;
          runs.push_back(std::move(run));
          if (terminal) fmt::print(stderr, "\r{} of {} plans", runs.size(), total);
        }
      }
    }
  }
  if (terminal) fmt::print(stderr, "\n");
  judge(runs);
  return runs;
}

std::string solver_table(const SolverComparisonSetup& setup, const std::vector<SolverRun>& runs) {
  std::string text =
      "| limit (N m) | solver | plans | certified | best of its side | other sides' best | other outcomes | plan (ms) "
      "| "
      "winning mode (ms) | solves | iterations | evaluations | one evaluation (us) | mode / evaluation |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  const int limits = std::max<int>(1, static_cast<int>(setup.limits.size()));
  for (int limit = 0; limit < limits; ++limit) {
    // Best over all sides, to tell a side that is worth less from a failure.
    std::map<int, double> best;
    for (const SolverRun& run : runs) {
      if (run.limit != limit || run.status != "solved") continue;
      const auto [entry, added] = best.emplace(run.target, run.objective);
      if (!added) entry->second = std::min(entry->second, run.objective);
    }
    for (const std::string& solver : setup.solvers) {
      int count = 0;
      int certified = 0;
      int reached = 0;
      int elsewhere = 0;
      std::map<std::string, int> others;
      std::vector<double> seconds, mode, solves, iterations, evaluations, evaluation;
      for (const SolverRun& run : runs) {
        if (run.limit != limit || run.solver != solver) continue;
        ++count;
        if (run.status != "solved") {
          ++others[run.status];
          continue;
        }
        ++certified;
        reached += run.reached ? 1 : 0;
        elsewhere += run.reached && !equally_good(run.objective, best[run.target]) ? 1 : 0;
        seconds.push_back(run.seconds);
        mode.push_back(run.mode_seconds);
        solves.push_back(run.solves);
        iterations.push_back(run.mode_iterations);
        evaluations.push_back(static_cast<double>(run.mode_evaluations));
        if (run.mode_evaluations > 0) {
          evaluation.push_back(run.mode_evaluating / static_cast<double>(run.mode_evaluations));
        }
      }
      std::string outcomes;
      for (const auto& [status, number] : others)
        outcomes += fmt::format("{}{} {}", outcomes.empty() ? "" : ", ", number, status);
      text += fmt::format(
          "| {} | {} | {} | {} | {} ({:.1f} %) | {} | {} | {:.3g} | {:.3g} | {:.3g} | {:.3g} | {:.3g} | {:.3g} | "
          "{:.3g} |\n",
          setup.limits.empty() ? "scene" : fmt::format("{:g}", setup.limits[static_cast<std::size_t>(limit)]), solver,
          count, certified, reached, certified > 0 ? 100.0 * reached / certified : 0.0, elsewhere,
          outcomes.empty() ? "none" : outcomes, 1e3 * median(seconds), 1e3 * median(mode), median(solves),
          median(iterations), median(evaluations), 1e6 * median(evaluation), median(mode) / median(evaluation));
    }
  }
  return text;
}

std::string solver_csv(const SolverComparisonSetup& setup, const std::vector<SolverRun>& runs) {
  std::string text =
      "solver,limit_Nm,target_x_m,target_y_m,start,status,sides,mode,objective,best_of_side,reached,seconds,mode_"
      "seconds,"
      "mode_seconds_evaluating,solves,iterations,evaluations,mode_iterations,mode_evaluations\n";
  for (const SolverRun& run : runs) {
    const double limit = setup.limits.empty() ? std::nan("") : setup.limits[static_cast<std::size_t>(run.limit)];
    const Vec2 target = setup.targets.empty() ? setup.scene.target.position.value_or(Vec2{std::nan(""), std::nan("")})
                                              : setup.targets[static_cast<std::size_t>(run.target)];
    // Names of obstacles are the user's: quoted, quotes doubled.
    std::string mode;
    for (const char c : run.mode) mode += c == '"' ? std::string("\"\"") : std::string(1, c);
    text += fmt::format("{},{},{},{},{},{},{},\"{}\",{},{},{},{:.3e},{:.3e},{:.3e},{},{},{},{},{}\n", run.solver, limit,
                        target.x, target.y, run.start, run.status, run.sides, mode, run.objective, run.best,
                        run.reached ? 1 : 0, run.seconds, run.mode_seconds, run.mode_evaluating, run.solves,
                        run.iterations, run.evaluations, run.mode_iterations, run.mode_evaluations);
  }
  return text;
}

}  // namespace tendril::bench
