#include "search/report.hpp"

#include <algorithm>
#include <cmath>

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

/// Nobody plans with what is so many lengths of the rod away: a unit was mistaken.
constexpr double far = 10.0;

std::string as_share(double distance) { return shown(100.0 * distance, 3) + " % of the length"; }

/// A plan at a limit where better ones end says so.
void tell_held(PoseProgram& program, ConstVectorRef x, Plan& plan) {
  const PoseProgram::Layout& at = program.layout();
  const VectorView rows = program.constraints(x);
  if (at.margins > 0 && rows[at.first_margin] <= tolerance::held_margin + tolerance::bounds) {
    plan.left_out.push_back({"plans that cost less",
                             "held at the limit of stability: the objective falls along stable equilibria up to "
                             "where they end; the plan keeps a margin of " +
                                 shown(tolerance::held_margin)});
  }
  if (at.convexities > 0 &&
      rows.segment(at.first_convexity, at.convexities).minCoeff() <= tolerance::held_convexity + tolerance::bounds) {
    plan.left_out.push_back({"contact along a stretch",
                             "the objective falls up to where the rod would lie along the obstacle; the plan keeps a "
                             "point contact"});
  }
}

}  // namespace

void Planner::keep_minimum(ModeState& state, const Candidate& c) {
  PlanMinimum found;
  found.mode = state.record.mode;
  if (!d_.obstacles.empty() && !d_.palm) {
    state.sides = sides_of(d_, c.program->shape_of(c.x));
    for (const int side : state.sides) found.sides.push_back(side_in_words(side));
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
  for (std::size_t o = 0; o < d_.obstacles.size() && !d_.palm; ++o) {
    const double away = d_.obstacles[o]->at(d_.rod.base).distance;
    if (away <= far) continue;
    plan.notes.push_back("'" + d_.obstacle_names[o] + "' lies " + shown(away, 3) +
                         " lengths of the rod away from its base: is its unit right?");
  }
  if (!d_.palm && control_.start == nullptr) {
    std::vector<OutlinePoint> line;
    outline(d_.rod, d_.scene_start().curvature, search_parameters().outline_steps, line);
    for (std::size_t o = 0; o < d_.obstacles.size(); ++o) {
      double depth = 0.0;
      for (const OutlinePoint& p : line) depth = std::max(depth, p.radius - d_.obstacles[o]->at(p.position).distance);
      if (depth <= 0.0) continue;
      const bool beside = !fast() && has_sides(d_, o) &&
                          std::any_of(states_.begin(), states_.end(), [](const ModeState& m) { return m.sided; });
      plan.notes.push_back("the start runs through '" + d_.obstacle_names[o] + "', " + as_share(depth) + " deep" +
                           (beside ? ": starts beside it were tried as well" : ""));
    }
  }
  tell_target(d_, plan);
}

void tell_target(const Task& task, Plan& plan) {
  if (!task.target.has_position) return;
  const bool read = std::any_of(task.terms.begin(), task.terms.end(), [](const PoseProgramTerm& term) {
    return term.term->reads().target && term.term->reads().tip_position;
  });
  if (!read) plan.notes.emplace_back("no objective reads the target and the tip");
  const double distance = norm(task.target.position - task.rod.base);
  if (distance > 1.0 && !task.rod.stretches() && task.rod.moves.empty())
    plan.notes.push_back("the target lies out of reach, by " + as_share(distance - 1.0) +
                         (distance > far ? ": is its unit right?" : ""));
  if (!plan.target_error || !read) return;
  const double miss = *plan.target_error / task.scale.length;
  if (miss > search_parameters().missed) plan.notes.push_back("the tip misses the target by " + as_share(miss));
}

void tell_point(const Task& task, PoseProgram& program, ConstVectorRef x, Plan& plan) {
  plan.objective = program.cost(x) * task.objective_scale;
  plan.terms.resize(task.terms.size());
  for (std::size_t i = 0; i < task.terms.size(); ++i) {
    plan.terms[i].first = task.terms[i].name;
    plan.terms[i].second = program.term_value(static_cast<int>(i)) * task.objective_scale;
  }
  plan.coordinates.assign(x.data(), x.data() + program.layout().coordinates);
  plan.moments.resize(task.rod.actuators.size());
  plan.turns.resize(task.rod.actuators.size());
  for (std::size_t a = 0; a < plan.moments.size(); ++a) {
    const int variable = program.moment_variable(static_cast<int>(a));
    plan.moments[a] = variable < 0 ? 0.0 : x[variable] * task.scale.moment();
    plan.turns[a] = program.turn_along(static_cast<int>(a));
  }
  plan.place = place_of(program, x, task.scale);
  const Vec2 tip = program.backbone().tip();
  plan.tip_x = tip.x * task.scale.length;
  plan.tip_y = tip.y * task.scale.length;
  plan.tip_angle = program.backbone().tip_angle();
  plan.target_error.reset();
  if (task.target.has_position) plan.target_error = norm(tip - task.target.position) * task.scale.length;
  planned_contacts(program, task.obstacle_names, task.scale, plan.contacts);
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
  if (winner_ >= 0)
    tell_held(*states_[static_cast<std::size_t>(winner_)].best.program,
              states_[static_cast<std::size_t>(winner_)].best.x, plan);
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
  tell_point(d_, program, x, plan);
  plan.certificate = chosen->certificate;
  for (int k = 0; k < program.layout().forces; ++k) {
    plan.contacts[static_cast<std::size_t>(k)].extended = lies_along(*chosen, x, k);
  }
  plan.backbone = sampled_backbone(chosen->certifier->finer(x), d_.scale.length);
  plan.self_overlap = self_overlap(plan.backbone, d_.scene.rod.body());
  if (d_.grip) d_.grip->finish(d_, program, x, plan);
  plan.minima = minima_;
  plan.scan = scan_;
  add_notes(plan);
  return plan;
}

}  // namespace tendril
