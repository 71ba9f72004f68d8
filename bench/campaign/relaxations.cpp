#include "campaign/relaxations.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "common/statistics.hpp"

namespace tendril::bench {
namespace {

bool widen_limits(Scene& scene) {
  bool changed = false;
  for (ActuatorSpec& actuator : scene.rod.actuators) {
    for (double* limit : {&actuator.minimum, &actuator.maximum}) {
      // A limit on this side of zero would come nearer to it.
      const bool outward = limit == &actuator.maximum ? *limit > 0.0 : *limit < 0.0;
      if (!std::isfinite(*limit) || !outward) continue;
      *limit *= 1.5;
      changed = true;
    }
  }
  return changed;
}

bool allow_more_force(Scene& scene) {
  const ContactModeName mode = scene.contact.mode;
  if (mode != ContactModeName::allow && mode != ContactModeName::require) return false;
  if (!std::isfinite(scene.contact.max_force) || scene.contact.max_force == 0.0) return false;
  scene.contact.max_force *= 2.0;
  return true;
}

bool allow_contact(Scene& scene) {
  ContactModeName& mode = scene.contact.mode;
  if (mode != ContactModeName::avoid && mode != ContactModeName::require) return false;
  mode = ContactModeName::allow;
  return true;
}

bool allow_another_contact(Scene& scene) {
  if (scene.contact.mode != ContactModeName::allow || scene.obstacles.empty()) return false;
  ++scene.contact.count;
  return true;
}

/// Where a contact may help, an obstacle may be missed.
bool take_obstacle_away(Scene& scene) {
  if (scene.contact.mode != ContactModeName::avoid || scene.obstacles.empty()) return false;
  scene.obstacles.pop_back();
  return true;
}

bool search_farther(Scene& scene) {
  scene.effort = SearchEffort::thorough;
  return true;
}

std::int64_t shown_seed(const CampaignCase& c) { return static_cast<std::int64_t>(c.seed); }

bool planned(const CampaignCase& c) { return c.met && c.verdict == "solved"; }

/// Lowest objective of each seed by whatever solver and effort.
using Best = std::map<std::uint64_t, double>;

void keep_best(const std::vector<CampaignCase>& cases, Best& best) {
  for (const CampaignCase& c : cases) {
    if (!planned(c)) continue;
    const auto [known, fresh] = best.try_emplace(c.seed, c.objective);
    if (!fresh) known->second = std::min(known->second, c.objective);
  }
}

}  // namespace

const std::vector<Relaxation>& relaxations() {
  static const std::vector<Relaxation> all{
      {"limits", "limits of moments 1.5 times as wide", widen_limits},
      {"force", "twice the largest contact force", allow_more_force},
      {"allow", "contact allowed where it was required or avoided", allow_contact},
      {"count", "one contact more", allow_another_contact},
      {"away", "the last obstacle taken away where all are avoided", take_obstacle_away},
      {"thorough", "a thorough search", search_farther},
  };
  return all;
}

Section relaxation_section(CampaignSetup setup, int& violations) {
  Section section;
  section.name = "relaxations";
  section.title = "What allows more gives no worse plan";
  section.prose.push_back(fmt::format(
      "Random scenes {} to {} are planned as they are, and with each change that leaves their plans possible. Worse: "
      "the objective rises by more than {:g} of its size, or there is no plan any more. Best known: the lowest "
      "objective of a seed over all solvers and the thorough search.",
      setup.first, setup.last, same_objective));
  Table pairs{"relaxations", "Pairs", {"solver", "change", "pairs", "worse", "better", "meaning"}, {}, true};
  Table worse{
      "relaxations_worse", "Plans that got worse", {"solver", "change", "seed", "before", "after", "reason"}, {}, true};
  Table known{"relaxations_best",
              "How often a normal search finds the best known plan",
              {"solver", "plans", "best known", "%"},
              {},
              true};
  violations = 0;
  Best best;
  std::map<std::string, std::vector<CampaignCase>> own;
  std::vector<std::string> solvers;
  solvers.swap(setup.solvers);
  const auto stopped = [&] { return setup.stop != nullptr && setup.stop->load(); };
  for (const std::string& solver : solvers) {
    setup.solvers = {solver};
    setup.relaxation.clear();
    const std::vector<CampaignCase>& before = own[solver] = run_campaign(setup);
    keep_best(before, best);
    for (const Relaxation& relaxation : relaxations()) {
      if (stopped()) break;
      setup.relaxation = relaxation.name;
      const std::vector<CampaignCase> after = run_campaign(setup);
      if (relaxation.name == "thorough") keep_best(after, best);
      std::int64_t compared = 0;
      std::int64_t rose = 0;
      std::int64_t fell = 0;
      for (std::size_t i = 0; i < std::min(before.size(), after.size()); ++i) {
        const CampaignCase& a = before[i];
        const CampaignCase& b = after[i];
        if (!planned(a) || b.verdict == nothing_to_relax) continue;
        ++compared;
        if (planned(b) && b.objective < a.objective - margin_of(a.objective, a.scale)) ++fell;
        if (planned(b) && b.objective <= a.objective + margin_of(a.objective, a.scale)) continue;
        ++rose;
        worse.rows.push_back({solver, relaxation.name, shown_seed(a), a.objective,
                              planned(b) ? b.objective : std::nan(""), planned(b) ? b.cut : b.verdict});
      }
      violations += static_cast<int>(rose);
      pairs.rows.push_back({solver, relaxation.name, compared, rose, fell, relaxation.meaning});
    }
  }
  for (const std::string& solver : solvers) {
    std::int64_t plans = 0;
    std::int64_t found = 0;
    for (const CampaignCase& c : own[solver]) {
      if (!planned(c)) continue;
      ++plans;
      if (c.objective <= best[c.seed] + margin_of(best[c.seed], c.scale)) ++found;
    }
    if (plans > 0)
      known.rows.push_back({solver, plans, found, 100.0 * static_cast<double>(found) / static_cast<double>(plans)});
  }
  section.tables = {pairs, known, worse};
  return section;
}

}  // namespace tendril::bench
