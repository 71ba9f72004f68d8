#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tendril/plugins/registry.hpp"
#include "tendril/scene.hpp"

namespace tendril::bench {

/// What every solver is put to. All solvers get the same scenes, targets, limits and starts; runs are interleaved, so
/// that a drift of the machine hits all alike.
struct SolverComparisonSetup {
  Scene scene;
  std::vector<std::string> solvers;
  std::vector<Vec2> targets;   ///< m; empty: the scene's own
  std::vector<double> limits;  ///< N m, of every actuator; empty: the scene's own
  int starts = 0;              ///< random ones per target; 0: the scene's own start alone
  std::uint64_t seed = 1;
  const std::atomic<bool>* stop = nullptr;
};

/// One solver on one target from one start.
struct SolverRun {
  std::string solver;
  int limit = 0, target = 0, start = 0;
  std::string status;  ///< of the plan: the certificate's word
  std::string sides;   ///< on which side of each obstacle the rod passes
  std::string mode;    ///< the way of being in contact that won
  double objective = 0.0;
  double best = 0.0;     ///< lowest certified objective that any solver reached on this target and these sides
  bool reached = false;  ///< certified, and its objective is the best to 1e-6 of max(best, 1e-6)
  double seconds = 0.0;  ///< of the plan, over all ways of being in contact
  double mode_seconds = 0.0, mode_evaluating = 0.0;  ///< of the way that won
  int solves = 0, iterations = 0;
  std::int64_t evaluations = 0;
  int mode_iterations = 0;
  std::int64_t mode_evaluations = 0;
};

std::vector<SolverRun> compare_solvers(plugins::Registry& registry, const SolverComparisonSetup& setup);

/// One row per solver and limit: how many runs were certified, how many reached the best of their side, and what they
/// cost (medians). Markdown.
std::string solver_table(const SolverComparisonSetup& setup, const std::vector<SolverRun>& runs);
/// Every run. CSV.
std::string solver_csv(const SolverComparisonSetup& setup, const std::vector<SolverRun>& runs);

}  // namespace tendril::bench
