#pragma once

#include <vector>

#include "check/exact_state.hpp"
#include "extremes/cases.hpp"
#include "tendril/plan.hpp"
#include "tendril/plugins/registry.hpp"
#include "tendril/scene.hpp"

namespace tendril::bench {

/// (s) Long enough for every case by far, also on a busy machine: who reaches it hangs.
inline constexpr double case_time_limit = 20.0;
/// (s) Hundreds of coordinates take longer.
inline constexpr double refined_time_limit = 60.0;

/// A plan or an execution, or why there is none.
struct CaseRun {
  Verdict verdict;
  Plan plan;
  double seconds = 0.0;
  int pieces = 0, snaps = 0;
  std::vector<Plan> earlier{};  ///< what an execution started from, or the steps of a trajectory but the last
};

/// The scene's plan.
CaseRun planned(plugins::Registry& registry, const Scene& scene);
/// The tip led along `targets` (L), each plan from the one before.
CaseRun led(plugins::Registry& registry, const Scene& scene, const std::vector<Vec2>& targets);
/// What `moments` (N m) do, from what the moments `before` do; those empty: from the scene's own start.
CaseRun carried_out(plugins::Registry& registry, const Scene& scene, const std::vector<double>& moments,
                    const std::vector<double>& before);

/// The exact state from the plan's own shape, or else from what the fine basis makes of it.
ExactState exact_of(plugins::Registry& registry, const Scene& scene, const Plan& plan);

}  // namespace tendril::bench
