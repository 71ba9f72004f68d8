#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "common/statistics.hpp"
#include "report/solver_comparison.hpp"

namespace tendril::bench {

namespace {

using Costs = std::vector<std::vector<double>>;

/// cost[contestant][program], infinity where it failed.
template <class Value>
Costs costs(const SolverComparisonSetup& setup, const SolverComparison& comparison, Value value) {
  Costs cost(setup.contestants.size(), std::vector<double>(comparison.programs.size(), infinity));
  for (const SolverRun& run : comparison.runs) {
    if (run.certified() && run.evaluations <= setup.evaluation_limit) cost[run.contestant][run.program] = value(run);
  }
  return cost;
}

double seconds_of(const SolverRun& run) { return run.seconds; }
/// A plan that needs no solver at all still costs one look.
double evaluations_of(const SolverRun& run) { return std::max(1.0, static_cast<double>(run.evaluations)); }

/// Who is drawn together: solvers with every treatment, or with every choice of their options.
enum class Field { treatments, options };

bool takes_part(const SolverComparisonSetup& setup, std::size_t c, Field field) {
  const Contestant& one = setup.contestants[c];
  if (field == Field::treatments) return one.options.empty();
  if (!one.options.empty()) return true;
  // The solver as it is, beside its options.
  return one.treatment == Treatment::penalty &&
         std::any_of(setup.contestants.begin(), setup.contestants.end(),
                     [&](const Contestant& other) { return other.solver == one.solver && !other.options.empty(); });
}

/// Solvers have a colour each, treatments a dash; choices of options have colours of their own. The best of a program
/// is the best of all contestants, drawn or not.
std::vector<app::ChartSeries> profile(const SolverComparisonSetup& setup, const Costs& cost, Field field) {
  const std::vector<std::vector<double>> ratios = performance_ratios(cost);
  double last = 1.0;
  for (const auto& row : ratios) {
    for (const double r : row) {
      if (std::isfinite(r)) last = std::max(last, r);
    }
  }
  std::vector<app::ChartSeries> series;
  std::map<std::string, int> colors;
  for (std::size_t c = 0; c < ratios.size(); ++c) {
    if (!takes_part(setup, c, field)) continue;
    const Contestant& contestant = setup.contestants[c];
    const std::string key = contestant.options.empty() ? contestant.solver : contestant.name;
    app::ChartSeries line;
    line.name = contestant.name;
    line.color = colors.emplace(key, static_cast<int>(colors.size())).first->second;
    line.dash = static_cast<int>(contestant.treatment);
    line.steps = true;
    line.x.push_back(1.0);
    line.y.push_back(share_within(ratios[c], 1.0));
    for (const double r : ratios[c]) {
      if (!std::isfinite(r) || r <= 1.0) continue;
      line.x.push_back(r);
      line.y.push_back(share_within(ratios[c], r));
    }
    line.x.push_back(1.1 * last);
    line.y.push_back(line.y.back());
    series.push_back(std::move(line));
  }
  return series;
}

Table ranking_table(const SolverComparisonSetup& setup, const SolverComparison& comparison) {
  Table table{"solvers_ranking",
              "Ranking by the shifted geometric mean of the time of a plan (shift 1 ms, failures count as the limit); "
              "means within a factor of 1.5 are one class, in which the evaluations decide (shift 10)",
              {"rank", "contestant", "programs", "certified", "feasible", "best of its side", "best known", "time (ms)",
               "evaluations"},
              {}};
  for (const Standing& s : standings(setup, comparison)) {
    const auto share = [&](int n) { return fmt::format("{} ({:.1f} %)", n, 100.0 * n / std::max(1, s.programs)); };
    table.rows.push_back({std::int64_t{s.rank}, setup.contestants[s.contestant].name, std::int64_t{s.programs},
                          share(s.certified), share(s.feasible), share(s.best_of_side), share(s.best_known),
                          1e3 * s.seconds, s.evaluations});
  }
  return table;
}

Table profile_table(const SolverComparisonSetup& setup, const SolverComparison& comparison) {
  Table table{
      "solvers_profiles",
      "Performance profiles in numbers: percentage of the programs on which a contestant is certified and needs "
      "at most this many times what the best needs",
      {"contestant", "time: 1", "2", "5", "10", "100", "evaluations: 1", "2", "5", "10", "100"},
      {}};
  const auto time = performance_ratios(costs(setup, comparison, seconds_of));
  const auto calls = performance_ratios(costs(setup, comparison, evaluations_of));
  for (std::size_t c = 0; c < setup.contestants.size(); ++c) {
    std::vector<Cell> row{setup.contestants[c].name};
    for (const auto* ratios : {&time[c], &calls[c]}) {
      for (const double factor : {1.0, 2.0, 5.0, 10.0, 100.0}) row.emplace_back(100.0 * share_within(*ratios, factor));
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

Table outcome_table(const SolverComparisonSetup& setup, const SolverComparison& comparison) {
  Table table{
      "solvers_outcomes", "Plans that were not certified, by status", {"contestant", "scene", "status", "plans"}, {}};
  std::map<std::tuple<std::size_t, std::size_t, std::string>, int> outcomes;
  for (const SolverRun& run : comparison.runs) {
    if (!run.certified()) ++outcomes[{run.contestant, comparison.programs[run.program].scene, run.status}];
  }
  for (const auto& [key, count] : outcomes) {
    const auto& [contestant, scene, status] = key;
    table.rows.push_back({setup.contestants[contestant].name, setup.scenes[scene].name, status, std::int64_t{count}});
  }
  return table;
}

}  // namespace

Table cost_table(const SolverComparisonSetup& setup, const SolverComparison& comparison) {
  Table table{"solvers_costs",
              "What certified plans cost (medians). Mode: the way of being in contact that won, with assembly, polish "
              "and certificate",
              {"scene", "limit (N m)", "contestant", "plans", "certified", "best of its side", "other sides' best",
               "plan (ms)", "mode (ms)", "solves", "mode's iterations", "mode's evaluations", "one evaluation (us)",
               "plan / evaluation", "mode / evaluation"},
              {}};
  struct Group {
    int plans = 0, certified = 0, reached = 0, elsewhere = 0;
    std::vector<double> seconds, mode, solves, iterations, evaluations, evaluation;
  };
  std::map<std::tuple<std::size_t, int, std::size_t>, Group> groups;
  // The best of one start alone, so that a side that is worth less is told from a failure.
  for (const SolverRun& run : comparison.runs) {
    const SolverProgram& program = comparison.programs[run.program];
    Group& g = groups[{program.scene, program.limit, run.contestant}];
    ++g.plans;
    if (!run.certified()) continue;
    ++g.certified;
    g.reached += run.reached ? 1 : 0;
    g.elsewhere += run.reached && !run.best_known ? 1 : 0;
    g.seconds.push_back(run.seconds);
    g.mode.push_back(run.mode_seconds);
    g.solves.push_back(run.solves);
    g.iterations.push_back(run.mode_iterations);
    g.evaluations.push_back(static_cast<double>(run.mode_evaluations));
    if (run.mode_evaluations > 0)
      g.evaluation.push_back(run.mode_evaluating / static_cast<double>(run.mode_evaluations));
  }
  for (const auto& [key, g] : groups) {
    const auto& [scene, limit, contestant] = key;
    table.rows.push_back(
        {setup.scenes[scene].name,
         setup.limits.empty() ? Cell(std::string("scene")) : Cell(setup.limits[static_cast<std::size_t>(limit)]),
         setup.contestants[contestant].name, std::int64_t{g.plans}, std::int64_t{g.certified}, std::int64_t{g.reached},
         std::int64_t{g.elsewhere}, 1e3 * median(g.seconds), 1e3 * median(g.mode), median(g.solves),
         median(g.iterations), median(g.evaluations), 1e6 * median(g.evaluation),
         median(g.seconds) / median(g.evaluation), median(g.mode) / median(g.evaluation)});
  }
  return table;
}

Table run_table(const SolverComparisonSetup& setup, const SolverComparison& comparison) {
  Table table{"solvers",
              "Every run",
              {"scene",
               "contestant",
               "limit_Nm",
               "target_x_m",
               "target_y_m",
               "start",
               "status",
               "sides",
               "mode",
               "objective",
               "best_of_side",
               "reached",
               "best_known",
               "seconds",
               "seconds_evaluating",
               "mode_seconds",
               "mode_seconds_evaluating",
               "solves",
               "iterations",
               "evaluations",
               "mode_iterations",
               "mode_evaluations",
               "repetitions",
               "spread",
               "repeatable"},
              {},
              false};
  for (const SolverRun& run : comparison.runs) {
    const SolverProgram& program = comparison.programs[run.program];
    const BenchScene& bench = setup.scenes[program.scene];
    const double limit = setup.limits.empty() ? std::nan("") : setup.limits[static_cast<std::size_t>(program.limit)];
    const Scene asked = with_target(bench, static_cast<std::size_t>(program.target));
    const Vec2 target = asked.target.position.value_or(Vec2{std::nan(""), std::nan("")});
    table.rows.push_back({bench.name,
                          setup.contestants[run.contestant].name,
                          limit,
                          target.x,
                          target.y,
                          std::int64_t{program.start},
                          run.status,
                          run.sides,
                          run.mode,
                          run.objective,
                          run.best,
                          std::int64_t{run.reached},
                          std::int64_t{run.best_known},
                          run.seconds,
                          run.evaluating,
                          run.mode_seconds,
                          run.mode_evaluating,
                          std::int64_t{run.solves},
                          std::int64_t{run.iterations},
                          run.evaluations,
                          std::int64_t{run.mode_iterations},
                          run.mode_evaluations,
                          std::int64_t{run.repetitions},
                          run.spread,
                          std::int64_t{run.repeatable}});
  }
  return table;
}

Section solver_section(const SolverComparisonSetup& setup, const SolverComparison& comparison) {
  Section section;
  section.name = "solvers";
  section.title = "Solvers and treatments of complementarity";
  std::string scenes;
  for (const BenchScene& scene : setup.scenes) scenes += (scenes.empty() ? "" : ", ") + scene.name;
  const double limit = setup.time_limit > 0.0 ? setup.time_limit : setup.scenes.front().scene.solver.time_limit;
  section.prose.push_back(fmt::format(
      "{} contestants on {} programs: the scenes {}, each with its targets and {}, seed {}. All get the same starts, "
      "derivatives, scaling and limits: {:g} s and {} evaluations per plan. Options are tried one at a time, the "
      "others at "
      "their defaults. Success is the certificate's word, at one "
      "tolerance for all.",
      setup.contestants.size(), comparison.programs.size(), scenes,
      setup.starts > 0 ? fmt::format("{} random starts", setup.starts) : std::string("the scene's own start"),
      setup.seed, limit, setup.evaluation_limit));
  section.prose.push_back(
      "Best of its side: the plan reaches, to 1e-6, the lowest objective that anybody found with the rod on the same "
      "side "
      "of every obstacle. Best known: the lowest on any side from any start. A local search from a start on the wrong "
      "side may stay there; that is the start's doing.");
  section.prose.push_back(
      "Feasible: every row and bound holds to the certificate's tolerances, whatever is to be said of stationarity and "
      "stability. A program that a solver does not take counts as failed, even where the planner finds a plan without "
      "it.");
  if (setup.repetitions > 1) {
    std::vector<double> spreads;
    int odd = 0;
    for (const SolverRun& run : comparison.runs) {
      if (run.repetitions == 1) continue;
      spreads.push_back(run.spread);
      odd += run.repeatable ? 0 : 1;
    }
    section.prose.push_back(fmt::format(
        "Times are medians of {} interleaved repetitions; plans of more than 50 ms were timed once. Half of the runs "
        "spread by less than {:.2g} % between their quartiles, nine in ten by less than {:.2g} %. Status, iterations "
        "and "
        "evaluations were the same in all repetitions of {} of {} runs.",
        setup.repetitions, 100.0 * median(spreads), 100.0 * quantile(spreads, 0.9),
        spreads.size() - static_cast<std::size_t>(odd), spreads.size()));
  }
  const auto add = [&](const std::string& name, const std::string& what, const Costs& cost, Field field) {
    std::vector<app::ChartSeries> lines = profile(setup, cost, field);
    if (lines.empty()) return;
    const bool treatments = field == Field::treatments;
    section.figures.push_back({name + (treatments ? "" : "_options"),
                               "At the left end: how often a contestant is the best of all. At the right end: how "
                               "often it is certified at all. " +
                                   std::string(treatments ? "Colour: solver; dashes: treatment of complementarity."
                                                          : "Solvers as they are, and with what their options offer."),
                               {"Performance profile on " + what + (treatments ? ": treatments" : ": algorithms"),
                                "factor of the least " + what + " on the same program",
                                "share of the programs",
                                true,
                                false,
                                std::move(lines),
                                {}}});
  };
  for (const Field field : {Field::treatments, Field::options}) {
    add("solvers_time", "time", costs(setup, comparison, seconds_of), field);
    add("solvers_evaluations", "evaluations", costs(setup, comparison, evaluations_of), field);
  }
  section.tables = {ranking_table(setup, comparison), profile_table(setup, comparison),
                    outcome_table(setup, comparison), cost_table(setup, comparison),
                    run_table(setup, comparison),     pace_table("solvers_pace", comparison.pace)};
  return section;
}

}  // namespace tendril::bench
