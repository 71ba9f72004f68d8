#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "common/section.hpp"
#include "tendril/plugins/registry.hpp"

namespace tendril::bench {

/// Random scenes in which one moment or two can be chosen. Where the search says that its plan is complete to a
/// resolution, the rod is executed from random shapes under moments spread over their box, and a fast plan starts from
/// where it comes to rest: none may cost less.
struct CompletenessSetup {
  std::uint64_t first = 1, last = 100;  ///< seeds
  std::string solver;
  int executions = 100;       ///< per scene
  double time_limit = 120.0;  ///< s, of one plan
  const std::atomic<bool>* stop = nullptr;
};

/// How one scene ended.
struct CompletenessCase {
  std::uint64_t seed = 0;
  std::string summary;      ///< of the scene
  bool complete = false;    ///< as the plan says
  int actuators = 0;        ///< whose moments can be chosen
  int equilibria = 0;       ///< that the search met
  int lost = 0;             ///< of them could not be followed on
  int unresolved = 0;       ///< of them cost less than the plan, and led to none
  int executions = 0;       ///< that came to rest where a plan may end
  double objective = 0.0;   ///< of the plan
  double best = 0.0;        ///< the least one that a plan from an execution has
  double seconds = 0.0;     ///< processor time of the plan
  bool found_more = false;  ///< the best is better
};

/// One case per solved plan that looked at all equilibria, in order of seed.
std::vector<CompletenessCase> run_completeness(plugins::Registry& registry, const CompletenessSetup& setup);

Section completeness_section(const CompletenessSetup& setup, const std::vector<CompletenessCase>& cases);

}  // namespace tendril::bench
