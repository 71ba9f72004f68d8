#include "search/verdict.hpp"

#include <algorithm>

#include "certificate/certifier.hpp"
#include "search/parameters.hpp"
#include "tendril/tolerances.hpp"

namespace tendril {
namespace {

/// What the nearest of all attempts failed by: its violation and the limits that bind there.
std::string failure_message(const Ways& ways) {
  const auto least = std::min_element(ways.begin(), ways.end(),
                                      [](const Way* a, const Way* b) { return a->violation < b->violation; });
  if (least == ways.end() || !std::isfinite((*least)->violation)) return "";
  const Way& nearest = **least;
  return "; the nearest (" + nearest.record.mode + ") violates them by " + shown_with_exponent(nearest.violation) +
         (nearest.limits.empty() ? ", with no variable at a limit" : ", with " + nearest.limits);
}

std::string infeasibility_message(const Ways& ways, const std::string& unit) {
  const bool some = std::any_of(ways.begin(), ways.end(), [](const Way* w) { return w->judged().has_point; });
  const std::string kept = "; a margin of stability of " + shown(tolerance::held_margin) +
                           " and contact at points are among these: without them there are equilibria";
  return "infeasible: from " + std::to_string(search_parameters().most_starts) + " starts per " + unit +
         " every search ended where no change of the plan reduces the violation of its constraints" +
         (some ? kept : std::string()) + failure_message(ways);
}

/// Nothing was certified, nothing ended the search, and there is no proof.
void judge_failure(const Ways& ways, const Grounds& grounds, Plan& plan) {
  if (grounds.chosen != nullptr) {
    const Certificate& c = grounds.chosen->certificate;
    plan.status = only_unstable(c) ? PlanStatus::unstable : PlanStatus::not_converged;
    plan.message = c.failures.empty() ? "no plan" : c.failures.front();
    return;
  }
  const SolveStatus last = plan.solver.status;
  const bool refused =
      last == SolveStatus::unsupported || last == SolveStatus::failed || last == SolveStatus::not_finite;
  plan.status = last == SolveStatus::diverged ? PlanStatus::diverged
                : refused                     ? PlanStatus::failed
                                              : PlanStatus::not_converged;
  plan.message = !grounds.unfit.empty()         ? grounds.unfit
                 : !plan.solver.message.empty() ? plan.solver.message
                                                : "no " + grounds.unit + " led to a plan";
  if (refused) return;
  for (const Way* way : ways) {
    if (!way->trouble.empty()) plan.message = way->record.mode + ": " + way->trouble;
  }
  if (!grounds.everything) {
    plan.message = "no plan in the " + std::to_string(ways.size()) +
                   " assignments of contacts that were tried; others may have one; the last: " + plan.message;
  }
}

}  // namespace

bool Way::infeasible() const {
  if (!skip.empty()) return true;
  if (judged().certified()) return false;
  // Rows that have no common point have none with stability either.
  const int without = judged().has_point ? 0 : stationary_violations;
  return without + stationary_with_margins >= search_parameters().most_starts;
}

void tell_outcomes(const Ways& ways, double objective_scale, const std::string& untried, Plan& plan) {
  for (Way* way : ways) {
    std::string& outcome = way->record.outcome;
    const Judged& best = way->judged();
    if (!way->skip.empty()) {
      outcome = "skipped: " + way->skip;
    } else if (best.has_point) {
      way->record.certified = best.certified();
      way->record.objective = best.objective * objective_scale;
      outcome += (best.certified() ? "certified, objective " : "not certified, objective ") +
                 shown(best.objective * objective_scale);
      if (!best.certified()) outcome += ": " + best.certificate.failures.front();
      if (!best.certified() && !way->trouble.empty()) outcome += "; " + way->trouble;
    } else if (std::isfinite(way->dearer)) {
      outcome += "costs more: " + shown(way->dearer * objective_scale);
    } else if (way->starts_used > 0 || !way->trouble.empty()) {
      const std::string ended =
          way->record.solves > 0 ? std::string(to_string(way->last.status)) : "no solve was begun";
      outcome += "not solved: " + (way->trouble.empty() ? ended : way->trouble);
    } else if (outcome.empty()) {
      outcome = untried;
    }
    plan.modes.push_back(way->record);
  }
}

Way* nearest_way(const Ways& ways) {
  Way* nearest = nullptr;
  const auto rank = [](const Way& w) {
    return std::pair(w.judged().certificate.failures.size(), w.judged().objective);
  };
  for (Way* way : ways) {
    if (way->judged().has_point && (nearest == nullptr || rank(*way) < rank(*nearest))) nearest = way;
  }
  return nearest;
}

void judge(const Ways& ways, const Grounds& grounds, Plan& plan) {
  const Tally& tally = grounds.search->tally;
  const bool stopped = grounds.search->deadline().interrupted();
  const bool late = grounds.search->deadline().cut();
  plan.search_cut = late;
  if (grounds.chosen != nullptr) {
    plan.solver = grounds.chosen->solver;
  } else {
    // The last one that was asked; where restoration settled everything none was.
    plan.solver.status = SolveStatus::infeasible;
    for (const Way* way : ways) {
      if (way->record.solves > 0) plan.solver = way->last;
    }
  }
  report_tally(tally, plan);
  const bool by_bound = std::all_of(ways.begin(), ways.end(), [](const Way* w) { return !w->skip.empty(); });
  const bool infeasible = std::all_of(ways.begin(), ways.end(), [](const Way* w) { return w->infeasible(); });
  if (tally.solver_did_nothing() && (grounds.solved || (!stopped && !late))) {
    plan.status = PlanStatus::failed;
    plan.message = grounds.unfit.empty() ? refusal_message(plan.solver_name, plan.solver) : grounds.unfit;
  } else if (grounds.solved) {
    plan.status = PlanStatus::solved;
  } else if (stopped) {
    plan.status = PlanStatus::interrupted;
    plan.message = "interrupted before a plan was certified";
  } else if (late) {
    plan.status = PlanStatus::time_limit;
    plan.message = "the time limit of " + shown(grounds.time_limit) + " s was reached before a plan was certified";
  } else if (grounds.rod_lies) {
    plan.status = PlanStatus::not_converged;
    plan.message = grounds.chosen->certificate.failures.back();
  } else if (infeasible && (grounds.everything || by_bound)) {
    // A search that is no enumeration proves nothing; but a contact out of reach stays out of reach beside others.
    plan.status = PlanStatus::infeasible;
    plan.message = by_bound ? "infeasible by a bound: " + (grounds.grasp ? ways.back() : ways.front())->skip
                            : infeasibility_message(ways, grounds.unit);
  } else {
    judge_failure(ways, grounds, plan);
  }
}

}  // namespace tendril
