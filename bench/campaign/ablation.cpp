#include "campaign/ablation.hpp"

#include <fmt/format.h>

#include <cmath>

#include "common/statistics.hpp"
#include "search/parameters.hpp"

namespace tendril::bench {
namespace {

/// A campaign against another one on the same cases.
struct Difference {
  std::int64_t lost = 0, won = 0;  ///< cases that are met by one of them alone
  std::int64_t dearer = 0, cheaper = 0;
  double seconds = 0.0, seconds_before = 0.0;  ///< CPU
};

Difference compared(const std::vector<CampaignCase>& before, const std::vector<CampaignCase>& after) {
  Difference d;
  for (std::size_t i = 0; i < std::min(before.size(), after.size()); ++i) {
    const CampaignCase& a = before[i];
    const CampaignCase& b = after[i];
    d.seconds_before += a.cpu_seconds;
    d.seconds += b.cpu_seconds;
    const bool plan_before = a.met && a.verdict == "solved";
    const bool plan_after = b.met && b.verdict == "solved";
    if (a.met && (!b.met || (plan_before && !plan_after))) ++d.lost;
    if (b.met && (!a.met || (plan_after && !plan_before))) ++d.won;
    if (!plan_before || !plan_after) continue;
    const double margin = margin_of(a.objective);
    if (b.objective > a.objective + margin) ++d.dearer;
    if (b.objective < a.objective - margin) ++d.cheaper;
  }
  return d;
}

}  // namespace

Section ablation_section(CampaignSetup setup, std::vector<std::string> settings) {
  std::vector<SearchParameter> parameters = list_search_parameters();
  if (settings.empty()) {
    for (const SearchParameter& p : parameters) {
      if (p.strategy) settings.push_back(p.name + "=0");
    }
  }
  Section section;
  section.name = "ablation";
  section.title = "What each part of the search is worth";
  section.prose.push_back(fmt::format(
      "Random scenes {} to {} are planned with the whole search, then with one of its parameters changed. Lost and "
      "won: "
      "cases that are met, or have a plan, with only one of the two. Dearer and cheaper: plans whose objective differs "
      "by more than {:g} of its size. Time is that of the processor, against the whole search.",
      setup.first, setup.last, same_objective));
  Table table{"ablation",
              "One change at a time",
              {"solver", "change", "lost", "won", "dearer", "cheaper", "time", "meaning"},
              {},
              true};
  std::vector<std::string> solvers;
  solvers.swap(setup.solvers);
  for (const std::string& solver : solvers) {
    setup.solvers = {solver};
    setup.search.clear();
    const std::vector<CampaignCase> whole = run_campaign(setup);
    for (const std::string& setting : settings) {
      setup.search = {setting};
      const Difference d = compared(whole, run_campaign(setup));
      if (setup.stop != nullptr && setup.stop->load()) break;
      std::string meaning;
      for (const SearchParameter& p : parameters) {
        if (setting.rfind(p.name + "=", 0) == 0) meaning = p.meaning;
      }
      table.rows.push_back(
          {solver, setting, d.lost, d.won, d.dearer, d.cheaper, d.seconds / d.seconds_before, meaning});
    }
  }
  section.tables = {table};
  return section;
}

}  // namespace tendril::bench
