#include <algorithm>
#include <cmath>
#include <limits>

#include "rod/outline.hpp"
#include "rod/self_overlap.hpp"
#include "scene/plan_report.hpp"
#include "search/follower.hpp"
#include "search/parameters.hpp"
#include "search/planner.hpp"
#include "search/task.hpp"

namespace tendril {
namespace {

std::string side_in_words(int side) {
  return side == 0 ? "" : std::abs(side) > 1 ? "ahead" : side > 0 ? "left" : "right";
}

std::string as_share(double distance) { return shown(100.0 * distance, 3) + " % of the length"; }

}  // namespace

void Planner::keep_minimum(const ModeState& state, const Candidate& c) {
  PlanMinimum found;
  found.mode = state.record.mode;
  if (!d_.obstacles.empty() && !d_.palm) {
    for (const int side : sides_of(d_, c.program->shape_of(c.x))) found.sides.push_back(side_in_words(side));
  }
  found.objective = c.objective * d_.objective_scale;
  const auto same = [&](const PlanMinimum& known) {
    return known.mode == found.mode && known.sides == found.sides &&
           std::abs(known.objective - found.objective) <=
               search_parameters().same_minimum * std::max(1.0, std::abs(found.objective));
  };
  if (std::any_of(minima_.begin(), minima_.end(), same)) return;
  found.moments = moments_of(&c);
  for (double& m : found.moments) m *= d_.scale.moment();
  const auto place = std::find_if(minima_.begin(), minima_.end(),
                                  [&](const PlanMinimum& known) { return known.objective > found.objective; });
  minima_.insert(place, std::move(found));
}

void Planner::add_notes(Plan& plan) const {
  if (!d_.palm && control_.start == nullptr) {
    std::vector<OutlinePoint> line;
    outline(d_.rod, d_.scene_start().curvature, search_parameters().outline_steps, line);
    for (std::size_t o = 0; o < d_.obstacles.size(); ++o) {
      double depth = 0.0;
      for (const OutlinePoint& p : line) depth = std::max(depth, -d_.obstacles[o]->at(p.position).distance);
      if (depth <= 0.0) continue;
      plan.notes.push_back("the start runs through '" + d_.obstacle_names[o] + "', " + as_share(depth) + " deep: " +
                           (fast() ? "the search began there all the same" : "starts beside it were tried as well"));
    }
  }
  if (!d_.target.has_position) return;
  const bool read = std::any_of(d_.terms.begin(), d_.terms.end(), [](const PoseProgramTerm& term) {
    return term.term->reads().target && term.term->reads().tip_position;
  });
  if (!read) plan.notes.emplace_back("no objective reads the target and the tip");
  const double distance = norm(d_.target.position - d_.rod.base);
  if (distance > 1.0) plan.notes.push_back("the target lies out of reach, by " + as_share(distance - 1.0));
  if (!plan.target_error || !read) return;
  const double miss = *plan.target_error / d_.scale.length;
  if (miss > search_parameters().missed) plan.notes.push_back("the tip misses the target by " + as_share(miss));
}

Plan Planner::report() {
  Plan plan;
  plan.coordinates_name = d_.scene.coordinates.plugin;
  plan.order = d_.components.coordinates->function_count();
  plan.split_at_contact = d_.scene.coordinates.split_at_contact;
  plan.left_out = d_.left_out;
  plan.solver_name = d_.scene.solver.plugin;
  if (winner_ >= 0 && balanced_objective_ < best_objective() - search_parameters().beats) {
    plan.left_out.push_back({"the grasp with the balance as a row",
                             "it costs less (" + shown(balanced_objective_ * d_.objective_scale) +
                                 "), but is no minimum of this objective, which falls from there to where no plan is "
                                 "certified"});
  }
  if (winner_ >= 0) {
    const Candidate& best = states_[static_cast<std::size_t>(winner_)].best;
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
  Ways ways;
  for (ModeState& state : states_) ways.push_back(&state);
  const bool followed = winner_ >= 0 && states_[static_cast<std::size_t>(winner_)].starts_used == 0;
  for (ModeState& state : states_) {
    if (!state.best.has_point && state.spread.has_point) {
      state.record.outcome += "not certified: " + state.spread.certificate.failures.back();
    }
  }
  tell_outcomes(ways, d_.objective_scale, followed ? not_tried_outcome : "not tried: stopped before", plan);

  // Without a certified plan the nearest one is reported, for what it is worth.
  Grounds grounds;
  auto* nearest = static_cast<ModeState*>(nearest_way(ways));
  Candidate* chosen = nearest != nullptr ? &nearest->best : nullptr;
  if (winner_ >= 0) chosen = &states_[static_cast<std::size_t>(winner_)].best;
  // That the rod lies along an obstacle tells more than where the search for points ended instead.
  Candidate* lying = nullptr;
  for (ModeState& state : states_) {
    if (winner_ >= 0 || must_stop() || !state.spread.has_point) continue;
    if (lying == nullptr || state.spread.objective < lying->objective) lying = &state.spread;
  }
  grounds.rod_lies = lying != nullptr;
  if (lying != nullptr) chosen = lying;
  grounds.search = &steps_;
  grounds.time_limit = d_.scene.solver.time_limit;
  grounds.solved = winner_ >= 0;
  grounds.everything = d_.enumerated || every_assignment_tried_;
  grounds.grasp = d_.palm.has_value();
  grounds.chosen = chosen;
  grounds.unfit = unfit_;
  grounds.unit = "mode";
  judge(ways, grounds, plan);
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
  plan.minima = minima_;
  add_notes(plan);
  return plan;
}

}  // namespace tendril
