#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "common/section.hpp"
#include "tendril/plugins/registry.hpp"
#include "tendril/scene.hpp"

namespace tendril::bench {

/// Random scenes, each planned in a process of its own, so that a crash or a hang is seen as such, and every plan
/// checked by formulas of its own (plan_check.hpp).
struct CampaignSetup {
  std::uint64_t first = 1, last = 1000;  ///< seeds
  std::vector<std::string> solvers;
  int jobs = 1;  ///< processes at a time
  /// s, of one plan. What is asked is what the planner answers; how fast it does stands in the table.
  double time_limit = 30.0;
  double share = 0.995;  ///< of the cases that have to be met
  std::vector<std::string> plugin_directories;
  std::vector<std::string> search;  ///< parameters of the search, NAME=VALUE
  bool outlines = false;            ///< obstacles that are not convex alone
  bool friction = false;            ///< contacts rub
  std::string relaxation;           ///< by which every scene is changed first (relaxations.hpp); empty: none
  const std::atomic<bool>* stop = nullptr;
};

/// How one scene ended.
struct CampaignCase {
  std::uint64_t seed = 0;
  std::string solver;
  std::string summary;  ///< of the scene
  std::string verdict;  ///< "solved", "infeasible" or what is counted as a failure
  bool met = false;     ///< solved and confirmed, or infeasible, within the time limit
  bool grave = false;   ///< a crash, a hang, a false plan or a missed time limit
  std::string reason;
  std::string cut;  ///< "cut" where time ended the search
  double seconds = 0.0, cpu_seconds = 0.0;
  double objective = 0.0;
  double scale = 1.0;                                         ///< of the objective
  double equilibrium = 0.0, penetration = 0.0, margin = 0.0;  ///< of the check
};

/// The largest weight of a scene's objectives, or 1 if all are smaller: what differs by rounding of that is the same.
double scale_of_objective(const Scene& scene);

/// Coordinate models and objectives that random_scene() may draw.
std::set<std::string> names_at_hand(const plugins::Registry& registry);

/// Verdict on a scene to which a relaxation does not apply.
inline constexpr const char* nothing_to_relax = "nothing to relax";

/// Plans the scene of one seed with the first solver of `setup`, relaxed if that is asked for, checks the plan, and
/// returns one line of JSON. Throws where the scene cannot be used.
std::string campaign_line(plugins::Registry& registry, std::uint64_t seed, const CampaignSetup& setup);

/// Every case, in order of solver and seed; those not reached before `stop` are missing.
std::vector<CampaignCase> run_campaign(const CampaignSetup& setup);

/// Enough cases are met and none is grave, for every solver.
bool acceptable(const CampaignSetup& setup, const std::vector<CampaignCase>& cases);

Section campaign_section(const CampaignSetup& setup, const std::vector<CampaignCase>& cases);

}  // namespace tendril::bench
