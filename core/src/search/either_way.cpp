#include "search/either_way.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "search/limit.hpp"
#include "search/parameters.hpp"
#include "search/planner.hpp"

namespace tendril {
namespace {

bool reads_direction(const Task& task) {
  return std::any_of(task.terms.begin(), task.terms.end(), [](const PoseProgramTerm& t) {
    const Reads reads = t.term->reads();
    return reads.target && reads.tip_angle;
  });
}

/// Whether no other turn of the tip can bring much: it is where the target is.
bool is_there(const Plan& plan, const Task& task) {
  const double near = search_parameters().there;
  return plan.status == PlanStatus::solved && std::abs(plan.tip_angle - task.target.angle) <= near &&
         plan.target_error.value_or(0.0) <= near * task.scale.length;
}

/// The better plan, with the work of both; `other` is done with. Whether that is the other.
bool keep_better(Plan& plan, Plan& other) {
  const bool better =
      other.status == PlanStatus::solved && (plan.status != PlanStatus::solved || other.objective < plan.objective);
  if (better) std::swap(plan, other);
  plan.evaluations += other.evaluations;
  plan.seconds_certify += other.seconds_certify;
  return better;
}

/// What contact bends far may have come nearer to the direction a turn away from `angle`, which it was planned for: it
/// is measured against the nearest one.
void face_nearest(Task& task, const PlanControl& control, double angle, Limit& limit, Plan& best) {
  for (int i = 0; i < search_parameters().most_turns; ++i) {
    task.face(best.tip_angle);
    if (best.status != PlanStatus::solved || task.target.angle == angle || !limit.leaves_time()) return;
    angle = task.target.angle;
    PlanControl from = control;
    from.start = &best;
    from.follow = false;
    Plan next = Planner(task, from).run();
    // Of the two turns the nearer one is what the objective means: the plan before was measured against the other.
    if (next.status != PlanStatus::solved) return;
    keep_better(best, next);
  }
}

Plan plan_either_way(Task& task, const PlanControl& control) {
  Limit limit(task);
  const double reference = control.start != nullptr ? control.start->tip_angle : task.start_tip_angle();
  std::vector<double> angles = task.angles_near(reference);
  const bool directed = reads_direction(task) || task.tolerance.angle < infinity;
  if (angles.empty() || !directed) return Planner(task, control).run();
  Plan best;
  double best_angle = angles.front();
  for (std::size_t i = 0; i < angles.size(); ++i) {
    task.target.angle = angles[i];
    if (!limit.leaves_time() && i > 0) {
      best.search_cut = true;
      break;
    }
    Plan next = Planner(task, control).run();
    const bool there = is_there(next, task);
    const bool stopped = next.status == PlanStatus::interrupted;
    if (i == 0) {
      best = std::move(next);
    } else if (keep_better(best, next)) {
      best_angle = angles[i];
    }
    if (there || stopped) break;
  }
  face_nearest(task, control, best_angle, limit, best);
  return best;
}

/// A thorough search begins with a normal one: it finds nothing worse in whatever time there is.
Plan plan_with_effort(Task& task, const PlanControl& control) {
  if (task.scene.effort != SearchEffort::thorough) return plan_either_way(task, control);
  Limit limit(task);
  Plan plan;
  {
    const Kept<SearchEffort> effort{task.scene.effort};
    effort.of = SearchEffort::normal;
    plan = plan_either_way(task, control);
  }
  if (plan.status == PlanStatus::interrupted || !limit.leaves_time()) return plan;
  Plan farther = plan_either_way(task, control);
  const bool cut = farther.search_cut;
  std::swap(plan, farther);
  keep_better(plan, farther);
  plan.search_cut = cut;
  task.face(plan.tip_angle);
  return plan;
}

}  // namespace

Plan plan_to_target(Task& task, const PlanControl& control) {
  Limit limit(task);
  Plan plan = plan_with_effort(task, control);
  if (plan.status != PlanStatus::infeasible || !task.tolerance.any() || !limit.leaves_time()) return plan;
  const Kept<TargetTolerance> asked{task.tolerance};
  asked.of = {};
  Plan nearest = plan_with_effort(task, control);
  if (nearest.status != PlanStatus::solved) return plan;
  nearest.status = PlanStatus::infeasible;
  nearest.message = "infeasible: no plan was found that keeps the target's tolerances; the best one without them comes";
  if (task.target.has_position) nearest.message += " within " + shown(*nearest.target_error, 3) + " m";
  if (task.target.has_angle) {
    nearest.message += std::string(task.target.has_position ? " and" : " within") + " " +
                       shown(std::abs(nearest.tip_angle - task.target.angle), 3) + " rad";
  }
  nearest.message += " of the target; " + plan.message;
  nearest.evaluations += plan.evaluations;
  nearest.seconds_certify += plan.seconds_certify;
  nearest.modes = std::move(plan.modes);
  return nearest;
}

}  // namespace tendril
