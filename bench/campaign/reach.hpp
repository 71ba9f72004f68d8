#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "common/section.hpp"
#include "tendril/plugins/registry.hpp"
#include "tendril/scene.hpp"

namespace tendril::bench {

/// Targets that a rod is known to reach: its inputs (moments, lengths of tendons, insertion, the pose of its base) are
/// led through random way points, and where the tip comes to is what a plan is then asked for, without a word about how
/// it was reached.
struct ReachSetup {
  Scene scene;              ///< of a pose; its own target is not used
  int targets = 525;        ///< how many
  std::uint64_t seed = 1;   ///< of the first target; each has a seed of its own
  double tolerance = 0.01;  ///< of the rod's length: a tip within it is there
  int way_points = 2;       ///< of the inputs, each uniform within its limits
  const std::atomic<bool>* stop = nullptr;
};

/// How one target ended.
struct ReachCase {
  std::uint64_t seed = 0;
  int draws = 0;             ///< of inputs, until an execution ended where a plan may be
  Vec2 target{};             ///< m
  std::size_t contacts = 0;  ///< of the execution
  std::string status;        ///< of the plan
  std::string message;
  double error = 0.0;    ///< m, from the target; NaN: there is no plan
  double seconds = 0.0;  ///< processor time of the plan
  bool reached = false;
};

/// One case per target, in order; those not begun before `stop` are missing. Throws Error for a scene that has nothing
/// to draw, or an input without limits.
std::vector<ReachCase> run_reach(plugins::Registry& registry, const ReachSetup& setup);

Section reach_section(const ReachSetup& setup, const std::vector<ReachCase>& cases);

}  // namespace tendril::bench
