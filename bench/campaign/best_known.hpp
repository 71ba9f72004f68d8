#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "common/section.hpp"
#include "tendril/plugins/registry.hpp"

namespace tendril::bench {

/// Random scenes, each planned by the normal search of every solver, and then from random shapes, a fast plan from
/// each, the solvers in turn: the best plan of all is the best known.
struct BestKnownSetup {
  std::uint64_t first = 1, last = 100;  ///< seeds
  std::vector<std::string> solvers;
  int starts = 200;           ///< random shapes per scene
  double time_limit = 120.0;  ///< s, of one plan
  const std::atomic<bool>* stop = nullptr;
};

/// How one scene ended.
struct BestKnownCase {
  std::uint64_t seed = 0;
  std::string summary;  ///< of the scene
  int actuators = 0;    ///< whose moments can be chosen
  int obstacles = 0;
  double scale = 1.0;                        ///< of the objective: its largest weight
  std::map<std::string, double> objectives;  ///< of the normal search of each solver; absent: it has no plan
  int solved = 0;                            ///< starts that led to a plan
  double best = 0.0;                         ///< of all plans; infinite: there is none
  bool best_overlaps = false;                ///< that plan's rod crosses or covers itself
  double best_apart = 0.0;                   ///< of the plans that do not

  /// Whether the normal search found the best plan, or one as good.
  bool found(const std::string& solver) const;
};

/// One case per seed.
std::vector<BestKnownCase> run_best_known(plugins::Registry& registry, const BestKnownSetup& setup);

/// Whether the normal search of each solver found at least this share of the best known plans.
bool finds_best(const BestKnownSetup& setup, const std::vector<BestKnownCase>& cases, double share);

Section best_known_section(const BestKnownSetup& setup, const std::vector<BestKnownCase>& cases);

}  // namespace tendril::bench
