#include "report/solver_comparison.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <tuple>

#include "common/statistics.hpp"
#include "common/workload.hpp"
#include "search/parameters.hpp"
#include "tendril/plugins/components.hpp"
#include "tendril/tolerances.hpp"

namespace tendril::bench {

namespace {

/// Times below this are mostly overhead, and do not decide a mean.
constexpr double seconds_shift = 1e-3;
constexpr double evaluations_shift = 10.0;
/// s. Plans that take longer are timed once: their time is known well enough, and most of the bench's would go there.
constexpr double long_plan = 0.05;

/// Plans of one program that end at the same minimum differ by rounding; a second minimum differs by far more.
bool equally_good(double objective, double best) { return objective <= best + margin_of(best); }

Scene variant(const SolverComparisonSetup& setup, const SolverProgram& program, const Contestant& contestant) {
  const BenchScene& bench = setup.scenes[program.scene];
  Scene scene = with_contestant(with_target(bench, static_cast<std::size_t>(program.target)), contestant);
  if (!setup.limits.empty()) {
    for (ActuatorSpec& actuator : scene.rod.actuators) {
      actuator.maximum = setup.limits[static_cast<std::size_t>(program.limit)];
      actuator.minimum = -actuator.maximum;
    }
  }
  if (setup.time_limit > 0.0) scene.solver.time_limit = setup.time_limit;
  return scene;
}

SolverRun run_of(const TimedPlan& timed, const std::vector<Vec2>& references) {
  const Plan& plan = timed.plan;
  SolverRun run;
  // What core's restoration and polish make of a start that the solver never saw is not the solver's plan.
  const bool refused = plan.solver.status == SolveStatus::unsupported;
  run.status = refused ? "refused: " + plan.solver.message : std::string(to_string(plan.status));
  const Certificate& c = plan.certificate;
  run.feasible = !refused && c.equilibrium <= tolerance::equilibrium && c.bounds <= tolerance::bounds &&
                 c.penetration <= tolerance::penetration && c.complementarity <= tolerance::complementarity &&
                 c.closest_point <= tolerance::closest_point;
  run.sides = sides(plan, references);
  run.objective = plan.objective;
  run.seconds = timed.seconds;
  run.evaluating = timed.evaluating;
  run.solves = timed.solves;
  run.iterations = timed.iterations;
  run.evaluations = timed.evaluations;
  if (const ModeRecord* mode = winning_mode(plan)) {
    run.mode = mode->mode;
    run.mode_seconds = mode->seconds;
    run.mode_evaluating = mode->seconds_evaluating;
    run.mode_iterations = mode->iterations;
    run.mode_evaluations = mode->evaluations;
  }
  return run;
}

void judge(SolverComparison& comparison) {
  std::map<std::tuple<std::size_t, int, int, std::string>, double> best;
  const auto key = [&](const SolverRun& run, const std::string& sides) {
    const SolverProgram& program = comparison.programs[run.program];
    return std::tuple(program.scene, program.limit, program.target, sides);
  };
  const auto lower = [&](const SolverRun& run, const std::string& sides) {
    const auto [entry, added] = best.emplace(key(run, sides), run.objective);
    if (!added) entry->second = std::min(entry->second, run.objective);
  };
  for (const SolverRun& run : comparison.runs) {
    if (!run.certified()) continue;
    lower(run, run.sides);
    lower(run, "any");
  }
  for (SolverRun& run : comparison.runs) {
    const auto entry = best.find(key(run, run.sides));
    run.best = entry != best.end() ? entry->second : infinity;
    run.reached = run.certified() && equally_good(run.objective, run.best);
    run.best_known = run.certified() && equally_good(run.objective, best.at(key(run, "any")));
  }
}

/// The line of a plan that has just been made.
void tell(const SolverComparisonSetup& setup, const SolverComparison& comparison, const SolverRun& run) {
  const SolverProgram& program = comparison.programs[run.program];
  const std::string limit =
      setup.limits.empty() ? "" : fmt::format(", limit {} N m", setup.limits[static_cast<std::size_t>(program.limit)]);
  fmt::print(stderr, "{} of {}: {}, target {}{}, {}: {}, {:.3g} ms\n", comparison.runs.size() + 1,
             comparison.programs.size() * setup.contestants.size(), setup.scenes[program.scene].name,
             program.target + 1, limit, setup.contestants[run.contestant].name, run.status, 1e3 * run.seconds);
}

/// A contestant that a scene or a plugin refuses altogether has failed like any other.
SolverRun plan_once(plugins::Registry& registry, const Scene& scene, const PlanControl& control,
                    const std::vector<Vec2>& references) {
  try {
    return run_of(timed_plan(registry, scene, control), references);
  } catch (const Error& error) {
    SolverRun run;
    run.status = std::string("refused: ") + error.what();
    return run;
  }
}

/// While it lives, backends find what Newton's method would find without them.
class BackendsAlone {
 public:
  BackendsAlone() : before_(search_parameters().descend) { set_search_parameter("descend", "0"); }
  ~BackendsAlone() { set_search_parameter("descend", before_ ? "1" : "0"); }
  BackendsAlone(const BackendsAlone&) = delete;
  BackendsAlone& operator=(const BackendsAlone&) = delete;

 private:
  bool before_;
};

/// All programs, and a random shape to start each from.
std::vector<Plan> draw_programs(const SolverComparisonSetup& setup, std::vector<SolverProgram>& programs) {
  std::vector<Plan> shapes;
  const int limits = std::max<int>(1, static_cast<int>(setup.limits.size()));
  const int starts = std::max(1, setup.starts);
  Uniform random(setup.seed);
  for (std::size_t s = 0; s < setup.scenes.size(); ++s) {
    const double length = setup.scenes[s].scene.rod.length();
    const int targets = std::max<int>(1, static_cast<int>(setup.scenes[s].targets.size()));
    for (int start = 0; start < starts; ++start) {
      for (int limit = 0; limit < limits; ++limit) {
        for (int target = 0; target < targets; ++target) {
          programs.push_back({s, limit, target, start});
          shapes.push_back(random_start(random, length));
        }
      }
    }
  }
  return shapes;
}

}  // namespace

SolverComparison compare_solvers(plugins::Registry& registry, const SolverComparisonSetup& setup) {
  const BackendsAlone alone;
  SolverComparison comparison;
  const std::vector<Plan> shapes = draw_programs(setup, comparison.programs);
  std::vector<std::vector<Vec2>> references(setup.scenes.size());
  for (std::size_t s = 0; s < setup.scenes.size(); ++s) {
    const Scene& scene = setup.scenes[s].scene;
    for (const auto& obstacle : plugins::make_obstacles(registry, scene)) {
      references[s].push_back(scene.rod.length() * obstacle->reference_point());
    }
  }
  const bool terminal = ::isatty(STDERR_FILENO) != 0;
  const std::size_t contestants = setup.contestants.size();
  const auto stopped = [&] { return setup.stop != nullptr && setup.stop->load(); };
  std::vector<std::vector<double>> seconds;
  Pace pace;
  for (int repetition = 0; repetition < setup.repetitions && !stopped(); ++repetition) {
    for (std::size_t p = 0; p < comparison.programs.size() && !stopped(); ++p) {
      const SolverProgram& program = comparison.programs[p];
      for (std::size_t c = 0; c < contestants && !stopped(); ++c) {
        if (repetition > 0 && seconds[p * contestants + c].front() > long_plan) continue;
        pace.beat();
        PlanControl control;
        control.stop = setup.stop;
        if (setup.starts > 0) control.start = &shapes[p];
        SolverRun run =
            plan_once(registry, variant(setup, program, setup.contestants[c]), control, references[program.scene]);
        if (stopped()) break;
        run.program = p;
        run.contestant = c;
        if (repetition == 0) {
          if (setup.tells_runs) tell(setup, comparison, run);
          seconds.push_back({run.seconds});
          comparison.runs.push_back(std::move(run));
        } else {
          SolverRun& first = comparison.runs[p * contestants + c];
          seconds[p * contestants + c].push_back(run.seconds);
          first.repeatable = first.repeatable && run.iterations == first.iterations &&
                             run.evaluations == first.evaluations && run.status == first.status;
        }
        if (terminal && (repetition > 0 || !setup.tells_runs)) {
          fmt::print(stderr, "\r{} of {} plans, repetition {} of {}", p * contestants + c + 1,
                     comparison.programs.size() * contestants, repetition + 1, setup.repetitions);
        }
      }
    }
  }
  if (terminal) fmt::print(stderr, "\n");
  for (std::size_t i = 0; i < comparison.runs.size(); ++i) {
    SolverRun& run = comparison.runs[i];
    const Quartiles q = quartiles(seconds[i]);
    run.seconds = q.median;
    run.repetitions = static_cast<int>(seconds[i].size());
    run.spread = (q.high - q.low) / q.median;
  }
  comparison.pace = pace.seconds();
  judge(comparison);
  return comparison;
}

std::vector<Standing> standings(const SolverComparisonSetup& setup, const SolverComparison& comparison) {
  std::vector<Standing> all(setup.contestants.size());
  std::vector<std::vector<double>> seconds(all.size()), evaluations(all.size());
  for (const SolverRun& run : comparison.runs) {
    Standing& one = all[run.contestant];
    one.contestant = run.contestant;
    ++one.programs;
    one.certified += run.certified() ? 1 : 0;
    one.feasible += run.feasible ? 1 : 0;
    one.best_of_side += run.reached ? 1 : 0;
    one.best_known += run.best_known ? 1 : 0;
    const double limit = setup.time_limit > 0.0
                             ? setup.time_limit
                             : setup.scenes[comparison.programs[run.program].scene].scene.solver.time_limit;
    const bool counts = run.certified() && run.evaluations <= setup.evaluation_limit;
    seconds[run.contestant].push_back(counts ? std::min(run.seconds, limit) : limit);
    evaluations[run.contestant].push_back(static_cast<double>(counts ? run.evaluations : setup.evaluation_limit));
  }
  std::vector<double> time, calls;
  for (Standing& one : all) {
    const auto c = static_cast<std::size_t>(&one - all.data());
    one.contestant = c;
    one.seconds = shifted_geometric_mean(seconds[c], seconds_shift);
    one.evaluations = shifted_geometric_mean(evaluations[c], evaluations_shift);
    time.push_back(one.seconds);
    calls.push_back(one.evaluations);
  }
  const std::vector<int> rank = ranks(time, calls, same_class);
  for (std::size_t c = 0; c < all.size(); ++c) all[c].rank = rank[c];
  std::sort(all.begin(), all.end(), [](const Standing& a, const Standing& b) { return a.rank < b.rank; });
  return all;
}

}  // namespace tendril::bench
