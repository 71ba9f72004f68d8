#include "report/tolerance_sweep.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "common/statistics.hpp"
#include "common/workload.hpp"

namespace tendril::bench {

namespace {

struct Sample {
  std::vector<double> error, seconds, plan_seconds, solves, iterations, evaluations;
  int plans = 0, certified = 0;
};

}  // namespace

Section tolerance_section(plugins::Registry& registry, const SolverComparisonSetup& setup, const BenchScene& bench,
                          const std::vector<double>& tolerances) {
  Section section;
  section.name = "tolerances";
  section.title = "Error against time per solver";
  std::map<std::pair<std::size_t, std::size_t>, Sample> samples;
  const auto stopped = [&] { return setup.stop != nullptr && setup.stop->load(); };
  for (int repetition = 0; repetition < setup.repetitions; ++repetition) {
    for (std::size_t target = 0; target < bench.targets.size(); ++target) {
      for (std::size_t t = 0; t < tolerances.size(); ++t) {
        for (std::size_t c = 0; c < setup.contestants.size() && !stopped(); ++c) {
          const Contestant& contestant = setup.contestants[c];
          if (!contestant.options.empty() || contestant.treatment != Treatment::penalty) continue;
          Scene scene = with_contestant(with_target(bench, target), contestant);
          scene.solver.tolerance = tolerances[t];
          if (setup.time_limit > 0.0) scene.solver.time_limit = setup.time_limit;
          const TimedPlan timed = timed_plan(registry, scene);
          Sample& sample = samples[{c, t}];
          ++sample.plans;
          if (timed.plan.status != PlanStatus::solved) continue;
          ++sample.certified;
          const OptimalityReport& solve = timed.plan.solver;
          sample.error.push_back(std::max(solve.infeasibility, solve.stationarity));
          sample.seconds.push_back(solve.seconds);
          sample.plan_seconds.push_back(timed.seconds);
          // More than one: the polish did not take the first, so that a second, started from it, went on.
          const ModeRecord* winner = winning_mode(timed.plan);
          sample.solves.push_back(winner != nullptr ? winner->solves : 0);
          sample.iterations.push_back(timed.iterations);
          sample.evaluations.push_back(static_cast<double>(timed.evaluations));
        }
      }
    }
  }
  Table table{"tolerances",
              "Medians over the targets of the scene '" + bench.name +
                  "'. Error: the larger of violation and stationarity of the winning way's last solve, judged by core",
              {"solver", "tolerance", "plans", "certified", "error of the solve", "time of the solve (ms)",
               "solves (mean)", "plan (ms)", "iterations of a plan", "evaluations of a plan"},
              {}};
  Figure figure{
      "tolerances",
      "The solver alone: one point per tolerance, joined in order of tolerance. Left and low is good.",
      {"What a solver reaches by itself", "time of one solve (ms)", "violation and stationarity", true, true, {}, {}}};
  int color = 0;
  for (std::size_t c = 0; c < setup.contestants.size(); ++c) {
    app::ChartSeries line;
    line.name = setup.contestants[c].name;
    for (std::size_t t = 0; t < tolerances.size(); ++t) {
      const auto found = samples.find({c, t});
      if (found == samples.end()) continue;
      const Sample& s = found->second;
      table.rows.push_back({line.name, tolerances[t], std::int64_t{s.plans}, std::int64_t{s.certified}, median(s.error),
                            1e3 * median(s.seconds), mean(s.solves), 1e3 * median(s.plan_seconds), median(s.iterations),
                            median(s.evaluations)});
      line.x.push_back(1e3 * median(s.seconds));
      line.y.push_back(std::max(median(s.error), 1e-17));
    }
    if (line.x.empty()) continue;
    line.color = color++;
    figure.chart.series.push_back(std::move(line));
  }
  section.prose.push_back(
      "A loose tolerance does not make a plan worse: what the solver leaves is taken away by the polish, Newton on the "
      "active set, and the certificate judges the result by the same tolerances whatever the solver was asked for. It "
      "may "
      "make a plan faster, or send the polish astray, which shows in the certified plans.");
  section.prose.push_back(
      "The error need not fall with the tolerance. Where a loose solve ends too far off for the polish, a second one "
      "goes on from it with its multipliers and ends nearer than a tighter first one; the mean number of solves tells. "
      "And solvers scale their own test, by the cost's gradient or by multipliers, while core's figure is not scaled.");
  section.tables = {table};
  section.figures = {figure};
  return section;
}

}  // namespace tendril::bench
