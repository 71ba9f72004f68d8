#include "grasp/force_limit.hpp"

#include <algorithm>
#include <cmath>

#include "base/clock.hpp"
#include "grasp/frames.hpp"
#include "search/friction.hpp"
#include "search/planner.hpp"
#include "tendril/tolerances.hpp"

namespace tendril {
namespace {

Plan search(Task& task, const PlanControl& control) {
  return task.lower ? plan_both_fingers(task, control) : Planner(task, control).run();
}

/// The finger of a grasp whose limit bounds the force of both: from below an object is pressed harder by what it
/// carries across the axis downwards.
Task& weaker_finger(Task& task) {
  if (!task.lower) return task;
  const double from_lower = task.lower->term_units.force / task.term_units.force;
  const double beside = -load_along(task.scene, task.scale).y;
  return task.lower->max_force * from_lower < task.max_force + beside ? *task.lower : task;
}

Plan plan_at_limit(Task& task, const PlanControl& control) {
  Task& weaker = weaker_finger(task);
  if (!std::isfinite(weaker.max_force)) return search(task, control);
  const std::string limit =
      "each contact at its limit of " + shown(weaker.scale.to_si(weaker.max_force, dimension::force)) + " N";
  const bool asked_for = std::any_of(task.terms.begin(), task.terms.end(),
                                     [](const PoseProgramTerm& t) { return t.term->reads().contact_force; });
  std::string why = "an objective weighs the force against something else";
  Plan plan;
  if (asked_for) {
    plan = search(task, control);
  } else {
    struct Kept {
      Task& task;
      Task& weaker;
      double least = weaker.min_force;
      double time_limit = task.scene.solver.time_limit;
      ~Kept() {
        weaker.min_force = least;
        task.scene.solver.time_limit = time_limit;
      }
    } kept{task, weaker};
    const double begin = now();
    weaker.min_force = weaker.max_force;
    plan = search(task, control);
    const double left = kept.time_limit - (now() - begin);
    const bool ended = plan.status == PlanStatus::solved || plan.status == PlanStatus::interrupted ||
                       plan.status == PlanStatus::failed || !(left > 0.0);
    if (ended) return plan;
    why = "no such grasp was certified (" + plan.message + ")";
    weaker.min_force = kept.least;
    task.scene.solver.time_limit = left;
    plan = search(task, control);
  }
  const bool of_lower = &weaker != &task && plan.grasp && plan.grasp->lower;
  const std::vector<PlannedContact>& pressing = of_lower ? plan.grasp->lower->contacts : plan.contacts;
  const bool below = std::any_of(pressing.begin(), pressing.end(), [&](const PlannedContact& c) {
    return c.force < (1.0 - tolerance::branch_decided) * weaker.scale.to_si(weaker.max_force, dimension::force);
  });
  if (below && plan.status == PlanStatus::solved) plan.left_out.push_back({limit, why});
  return plan;
}

}  // namespace

Plan plan_grasp(Task& task, const PlanControl& control) {
  const auto search = [&task](const PlanControl& own) { return plan_at_limit(task, own); };
  if (task.friction.empty()) return search(control);
  const bool worst = task.scene.contact.friction_state == FrictionState::worst;
  return worst ? plan_worst(task, control, search) : plan_any(task, control, search);
}

}  // namespace tendril
