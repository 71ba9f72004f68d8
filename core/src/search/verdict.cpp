#include <algorithm>
#include <cmath>
#include <limits>

#include "rod/self_overlap.hpp"
#include "scene/plan_report.hpp"
#include "search/follower.hpp"
#include "search/planner.hpp"
#include "search/task.hpp"

namespace tendril {
/// Where the violation was least, and which limits stood in the way.
std::string Planner::nearest_failure(const std::deque<ModeState>& states) const {
  const auto least = std::min_element(states.begin(), states.end(),
                                      [](const ModeState& a, const ModeState& b) { return a.violation < b.violation; });
  return least == states.end() ? "" : told_failure(*least);
}

std::string Planner::told_infeasibility(const std::deque<ModeState>& states) const {
  const bool some = std::any_of(states.begin(), states.end(), [](const ModeState& s) { return s.best.has_point; });
  const std::string kept = "; a margin of stability of " + shown(tolerance::held_margin) +
                           " and contact at points are among these: without them there are equilibria";
  return "infeasible: from " + std::to_string(most_starts) +
         " starts per mode every search ended where no change of the plan reduces the violation of its constraints" +
         (some ? kept : std::string()) + nearest_failure(states);
}

Plan Planner::report(std::deque<ModeState>& states, int winner) {
  Plan plan;
  plan.coordinates_name = d_.scene.coordinates.plugin;
  plan.order = d_.components.coordinates->function_count();
  plan.split_at_contact = d_.scene.coordinates.split_at_contact;
  plan.left_out = d_.left_out;
  plan.solver_name = d_.scene.solver.plugin;
  if (winner >= 0 && balanced_objective_ < best_objective() - beats) {
    plan.left_out.push_back({"the grasp with the balance as a row",
                             "it costs less (" + shown(balanced_objective_ * d_.objective_scale) +
                                 "), but is no minimum of this objective, which falls from there to where no plan is "
                                 "certified"});
  }
  if (winner >= 0) {
    const Candidate& best = states[static_cast<std::size_t>(winner)].best;
    const PoseProgram::Layout& at = best.program->layout();
    if (at.margins > 0 &&
        best.program->constraints(best.x)[at.first_margin] <= tolerance::held_margin + tolerance::bounds) {
      plan.left_out.push_back({"plans that cost less",
                               "held at the limit of stability: the objective falls along stable equilibria up to "
                               "where they end; the plan keeps a margin of " +
                                   shown(tolerance::held_margin)});
    }
    for (int i = 0; i < at.convexities; ++i) {
      const int row = at.first_convexity + i;
      if (best.program->constraints(best.x)[row] > tolerance::held_convexity + tolerance::bounds) continue;
      plan.left_out.push_back({"contact along a stretch",
                               "the objective falls up to where the rod would lie along the obstacle; the plan keeps a "
                               "point contact"});
      break;
    }
  }
  const bool followed = winner >= 0 && states[static_cast<std::size_t>(winner)].starts_used == 0;
  for (ModeState& state : states) {
    const Mode& mode = modes_[static_cast<std::size_t>(state.mode)];
    if (!mode.skip.empty()) {
      state.record.outcome = "skipped: " + mode.skip;
    } else if (state.best.has_point) {
      state.record.certified = state.best.certified();
      state.record.objective = state.best.objective * d_.objective_scale;
      state.record.outcome += (state.best.certified() ? "certified, objective " : "not certified, objective ") +
                              shown(state.best.objective * d_.objective_scale);
      if (!state.best.certified()) {
        state.record.outcome += ": " + state.best.certificate.failures.front();
        if (!state.trouble.empty()) state.record.outcome += "; " + state.trouble;
      }
    } else if (state.spread.has_point) {
      state.record.outcome += "not certified: " + state.spread.certificate.failures.back();
    } else if (std::isfinite(state.dearer)) {
      char text[80];
      std::snprintf(text, sizeof text, "costs more: objective %.6g", state.dearer * d_.objective_scale);
      state.record.outcome += text;
    } else if (state.starts_used > 0) {
      state.record.outcome +=
          "not solved: " + (state.trouble.empty() ? std::string(to_string(state.last.status)) : state.trouble);
    } else if (state.record.outcome.empty()) {
      state.record.outcome = followed ? not_tried_outcome : "not tried: stopped before";
    }
    plan.modes.push_back(state.record);
  }

  // Without a certified plan the nearest one is reported, for what it is worth.
  int reported = winner;
  if (reported < 0) {
    std::size_t fewest = std::numeric_limits<std::size_t>::max();
    for (const ModeState& state : states) {
      if (!state.best.has_point) continue;
      const std::size_t failures = state.best.certificate.failures.size();
      const bool better =
          failures < fewest || (failures == fewest && reported >= 0 &&
                                state.best.objective < states[static_cast<std::size_t>(reported)].best.objective);
      if (!better) continue;
      fewest = failures;
      reported = state.mode;
    }
  }

  Candidate* chosen = reported >= 0 ? &states[static_cast<std::size_t>(reported)].best : nullptr;
  const bool stopped = steps_.deadline().interrupted();
  const bool late = steps_.deadline().cut();
  plan.search_cut = late;
  // That the rod lies along an obstacle tells more than where the search for points ended instead.
  bool spreads = false;
  for (ModeState& state : states) {
    if (winner >= 0 || stopped || late || !state.spread.has_point) continue;
    if (!spreads || state.spread.objective < chosen->objective) chosen = &state.spread;
    spreads = true;
  }

  if (chosen != nullptr) {
    plan.solver = chosen->solver;
  } else {
    // The last one that was asked; where restoration settled everything none was.
    plan.solver.status = SolveStatus::infeasible;
    for (const ModeState& state : states) {
      if (state.record.solves > 0) plan.solver = state.last;
    }
  }
  report_tally(steps_.tally, plan);

  // The verdict.
  if (steps_.tally.solver_did_nothing() && (winner >= 0 || (!stopped && !late))) {
    plan.status = PlanStatus::failed;
    plan.message = unfit_.empty() ? told_uselessness(plan.solver_name, plan.solver) : unfit_;
  } else if (winner >= 0) {
    plan.status = PlanStatus::solved;
  } else if (stopped) {
    plan.status = PlanStatus::interrupted;
    plan.message = "interrupted before a plan was certified";
  } else if (late) {
    plan.status = PlanStatus::time_limit;
    plan.message =
        "the time limit of " + shown(d_.scene.solver.time_limit) + " s was reached before a plan was certified";
  } else if (spreads) {
    plan.status = PlanStatus::not_converged;
    plan.message = chosen->certificate.failures.back();
  } else {
    const bool by_bound = std::all_of(states.begin(), states.end(), [&](const ModeState& state) {
      return !modes_[static_cast<std::size_t>(state.mode)].skip.empty();
    });
    // A search that is no enumeration proves nothing; but a contact out of reach stays out of reach beside others.
    if (all_infeasible() && (d_.enumerated || every_assignment_tried_ || by_bound)) {
      plan.status = PlanStatus::infeasible;
      plan.message = by_bound ? "infeasible by a bound: " + (d_.palm ? modes_.back() : modes_.front()).skip
                              : told_infeasibility(states);
    } else if (chosen != nullptr) {
      const Certificate& c = chosen->certificate;
      const bool only_unstable =
          c.failures.size() == 1 && c.contact_convexity > tolerance::convexity && !(c.stability > tolerance::stability);
      plan.status = only_unstable ? PlanStatus::unstable : PlanStatus::not_converged;
      plan.message = c.failures.empty() ? "no plan" : c.failures.front();
    } else {
      const SolveStatus last = plan.solver.status;
      const bool diverged = last == SolveStatus::diverged;
      const bool refused =
          last == SolveStatus::unsupported || last == SolveStatus::failed || last == SolveStatus::not_finite;
      plan.status = diverged ? PlanStatus::diverged : refused ? PlanStatus::failed : PlanStatus::not_converged;
      plan.message = !unfit_.empty()                ? unfit_
                     : !plan.solver.message.empty() ? plan.solver.message
                                                    : "no mode led to a plan";
      if (!refused) {
        for (const ModeState& state : states) {
          if (!state.trouble.empty()) plan.message = state.record.mode + ": " + state.trouble;
        }
        if (!d_.enumerated && !every_assignment_tried_) {
          plan.message = "no plan in the " + std::to_string(states.size()) +
                         " assignments of contacts that were tried; others may have one; the last: " + plan.message;
        }
      }
    }
  }
  if (chosen == nullptr) return plan;

  PoseProgram& program = *chosen->program;
  const Eigen::VectorXd& x = chosen->x;
  program.cost(x);
  plan.certificate = chosen->certificate;
  plan.objective = chosen->objective * d_.objective_scale;
  for (std::size_t i = 0; i < d_.terms.size(); ++i) {
    plan.terms.emplace_back(d_.terms[i].name, program.term_value(static_cast<int>(i)) * d_.objective_scale);
  }
  const double length = d_.scale.length;
  plan.coordinates.assign(x.data(), x.data() + program.layout().coordinates);
  for (std::size_t a = 0; a < d_.rod.actuators.size(); ++a) {
    const int variable = program.moment_variable(static_cast<int>(a));
    plan.moments.push_back(variable < 0 ? 0.0 : x[variable] * d_.scale.moment());
  }
  const Vec2 tip = program.backbone().tip();
  plan.tip_x = tip.x * length;
  plan.tip_y = tip.y * length;
  plan.tip_angle = program.backbone().tip_angle();
  if (d_.target.has_position) plan.target_error = norm(tip - d_.target.position) * length;
  plan.contacts = planned_contacts(program, d_.obstacle_names, d_.scale);
  for (int k = 0; k < program.layout().forces; ++k) {
    plan.contacts[static_cast<std::size_t>(k)].extended = lies_along(*chosen, x, k);
  }
  plan.backbone = sampled_backbone(chosen->certifier->finer(x), length);
  plan.self_overlap = self_overlap(plan.backbone);
  if (d_.grip) d_.grip->finish(d_, program, x, plan);
  return plan;
}

}  // namespace tendril
