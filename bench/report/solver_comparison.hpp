#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "common/contestants.hpp"
#include "common/scenes.hpp"
#include "common/section.hpp"

namespace tendril::bench {

/// What every contestant is put to. All get the same scenes, targets, limits and starts; runs are interleaved, so that
/// a drift of the machine hits all alike.
struct SolverComparisonSetup {
  std::vector<BenchScene> scenes;
  std::vector<Contestant> contestants;
  std::vector<double> limits;  ///< N m, of every actuator; empty: the scene's own
  int starts = 0;              ///< random ones per target; 0: the scene's own start alone
  std::uint64_t seed = 1;
  int repetitions = 1;                    ///< of plans below 50 ms; the median time counts
  double time_limit = 0.0;                ///< s, of a plan, what a failure counts as; 0: the scene's own
  std::int64_t evaluation_limit = 20000;  ///< likewise; who needs more has failed
  bool tells_runs = false;                ///< a line on standard error for each plan as it comes
  const std::atomic<bool>* stop = nullptr;
};

/// One question: a scene, a limit, a target, a start. Indices into the setup.
struct SolverProgram {
  std::size_t scene = 0;
  int limit = 0, target = 0, start = 0;
};

/// One contestant on one program.
struct SolverRun {
  std::size_t program = 0, contestant = 0;
  std::string status;     ///< of the plan: the certificate's word; "refused: ..." where the solver does not take it
  bool feasible = false;  ///< every row and bound holds to the certificate's tolerances, whatever else
  std::string sides;      ///< on which side of each obstacle the rod passes
  std::string mode;       ///< the way of being in contact that won
  double objective = 0.0;
  double best = 0.0;        ///< lowest certified objective that any contestant reached on this target and these sides
  bool reached = false;     ///< certified, and its objective is the best of its sides to 1e-6 of max(best, 1e-6)
  bool best_known = false;  ///< the same for the best over all sides and starts
  double seconds = 0.0;     ///< of the plan, over all ways of being in contact
  double evaluating = 0.0;  ///< of it, inside programs while a solver ran
  double mode_seconds = 0.0, mode_evaluating = 0.0;  ///< of the way that won
  int solves = 0, iterations = 0;
  std::int64_t evaluations = 0;
  int mode_iterations = 0;
  std::int64_t mode_evaluations = 0;
  int repetitions = 1;     ///< what took long is timed once
  double spread = 0.0;     ///< of the times: distance of the quartiles over the median
  bool repeatable = true;  ///< iterations and evaluations were the same each time
  bool certified() const { return status == "solved"; }
};

struct SolverComparison {
  std::vector<SolverProgram> programs;
  std::vector<SolverRun> runs;  ///< all contestants of a program one after the other
  std::vector<double> pace;     ///< s, one beat beside every plan
};

SolverComparison compare_solvers(plugins::Registry& registry, const SolverComparisonSetup& setup);

/// How one contestant did over all programs.
struct Standing {
  std::size_t contestant = 0;
  int programs = 0, certified = 0, feasible = 0, best_of_side = 0, best_known = 0;
  double seconds = 0.0;      ///< shifted geometric mean, failures as the limit
  double evaluations = 0.0;  ///< likewise
  int rank = 0;
};
/// By rank.
std::vector<Standing> standings(const SolverComparisonSetup& setup, const SolverComparison& comparison);

/// One row per scene, limit and contestant: how many runs were certified, how many reached the best of their side, and
/// what they cost (medians).
Table cost_table(const SolverComparisonSetup& setup, const SolverComparison& comparison);
/// Every run.
Table run_table(const SolverComparisonSetup& setup, const SolverComparison& comparison);
Section solver_section(const SolverComparisonSetup& setup, const SolverComparison& comparison);

}  // namespace tendril::bench
