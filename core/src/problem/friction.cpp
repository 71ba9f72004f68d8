#include "problem/friction.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "search/friction.hpp"
#include "tendril/execute.hpp"
#include "tendril/numbers.hpp"
#include "tendril/tolerances.hpp"

namespace tendril {
namespace {

FrictionRange record(const Plan& reached, const Plan& plan, const std::vector<double>& ratios) {
  FrictionRange r{{},
                  reached.tip_x,
                  reached.tip_y,
                  reached.tip_angle,
                  reached.target_error,
                  reached.certificate.stability,
                  reached.contacts};
  for (const PlannedContact& c : plan.contacts) {
    const bool held = std::any_of(reached.contacts.begin(), reached.contacts.end(),
                                  [&](const PlannedContact& met) { return met.obstacle == c.obstacle; });
    r.ratios.push_back(held && !ratios.empty() ? ratios[static_cast<std::size_t>(c.obstacle)] : 0.0);
  }
  return r;
}

/// The states as execution reaches them, which makes and releases contacts on the way, at each obstacle alike. A state
/// that is not reached: `plan` says which, and how far it holds.
void follow_states(const Task& task, const std::set<std::size_t>& rubbing, Plan& plan, const std::atomic<bool>* stop) {
  const auto refuse = [&plan](PlanStatus status, const std::string& why) {
    plan.friction.clear();
    plan.status = status;
    plan.message = why;
  };
  if (rubbing.size() > most_rubbing) {
    return refuse(PlanStatus::not_converged, "friction at " + std::to_string(rubbing.size()) +
                                                 " obstacles is not looked at, expected at most " +
                                                 std::to_string(most_rubbing));
  }
  Scene scene = task.scene;
  scene.target.position.reset();
  if (task.target.has_position) scene.target.position = task.scale.length * task.target.position;
  ExecuteControl control;
  control.stop = stop;
  control.time_limit = scene.solver.time_limit;
  control.start = &plan;
  control.with_friction = false;
  const Execution without = execute(scene, task.components.obstacles, plan, control);
  if (without.result.status != PlanStatus::solved) {
    return refuse(without.result.status, "without friction the plan's shape did not settle: " + without.result.message);
  }
  plan.friction.push_back(record(without.result, plan, {}));
  control.start = &without.result;
  for (std::size_t corner = 0; corner < (std::size_t{1} << rubbing.size()); ++corner) {
    control.friction.assign(scene.obstacles.size(), 0.0);
    std::string where;
    std::size_t bit = 0;
    for (const std::size_t o : rubbing) {
      const double ratio = friction_of(scene, o) * ((corner >> bit++ & 1U) != 0 ? 1.0 : -1.0);
      control.friction[o] = ratio;
      where += (where.empty() ? "" : ", ") + shown(ratio) + " at '" + task.obstacle_names[o] + "'";
    }
    const Execution slipping = execute(scene, task.components.obstacles, plan, control);
    if (slipping.result.status != PlanStatus::solved) {
      const bool cut =
          slipping.result.status == PlanStatus::interrupted || slipping.result.status == PlanStatus::time_limit;
      return refuse(cut ? slipping.result.status : PlanStatus::unstable,
                    "under friction the plan holds up to " + shown(slipping.load, 3) + " of the ratios " + where +
                        ": " + slipping.result.message);
    }
    plan.friction.push_back(record(slipping.result, plan, control.friction));
  }
}

/// A plan that was made without friction keeps its limits so.
void tell_limits(const Task& task, Plan& plan) {
  const ContactSpec& contact = task.scene.contact;
  double force = 0.0;
  double miss = 0.0;
  for (const FrictionRange& state : plan.friction) {
    for (const PlannedContact& c : state.contacts) force = std::max(force, c.force);
    miss = std::max(miss, state.target_error.value_or(0.0));
  }
  constexpr double share = 1.0 + tolerance::bounds;
  if (force > contact.max_force * share) {
    plan.notes.push_back("under friction a contact force may come to " + shown(force, 4) + " N, more than its limit");
  }
  if (miss > task.tolerance.position * task.scale.length * share) {
    plan.notes.push_back("under friction the tip may be " + shown(miss, 4) +
                         " m from the target, beyond its tolerance");
  }
}

}  // namespace

std::vector<double> ratios_of(const Plan& plan, std::size_t obstacles) {
  std::vector<double> ratios;
  for (const PlannedContact& c : plan.contacts) {
    const auto o = static_cast<std::size_t>(c.obstacle);
    if (c.tangential == 0.0 || !(c.force > 0.0) || o >= obstacles) continue;
    ratios.resize(obstacles, 0.0);
    ratios[o] = c.tangential / c.force;
  }
  return ratios;
}

void judge_cones(const Scene& scene, double force_unit, Plan& plan) {
  std::optional<double>& largest = plan.certificate.friction;
  largest.reset();
  const auto judge = [&](const std::vector<PlannedContact>& contacts) {
    for (const PlannedContact& c : contacts) {
      const auto o = static_cast<std::size_t>(c.obstacle);
      const double coefficient = o < scene.obstacles.size() ? friction_of(scene, o) : 0.0;
      const double force = c.force / force_unit;
      if (!(coefficient > 0.0) || !(force > tolerance::force)) continue;
      const double beyond = std::abs(c.tangential) / force_unit - coefficient * force;
      const bool slips = !c.sticks && c.tangential != 0.0;
      largest = std::max(largest.value_or(0.0), (slips ? std::abs(beyond) : std::max(0.0, beyond)) / (1.0 + force));
    }
  };
  judge(plan.contacts);
  if (plan.grasp && plan.grasp->lower) judge(plan.grasp->lower->contacts);
  if (!largest || *largest <= tolerance::friction) return;
  plan.certificate.failures.push_back("a tangential force is off its cone of friction by " +
                                      shown_with_exponent(*largest));
  if (plan.status != PlanStatus::solved) return;
  plan.status = PlanStatus::not_converged;
  plan.message = plan.certificate.failures.back();
}

void find_friction_range(const Task& task, Plan& plan, const std::atomic<bool>* stop) {
  plan.friction.clear();
  if (plan.status != PlanStatus::solved) return;
  const double trace = tolerance::force * task.scale.force();
  std::set<std::size_t> rubbing;
  for (const PlannedContact& c : plan.contacts) {
    const auto o = static_cast<std::size_t>(c.obstacle);
    if (c.force > trace && friction_of(task.scene, o) > 0.0) rubbing.insert(o);
  }
  if (rubbing.empty()) return;
  if (auto states = friction_states(task, plan)) {
    plan.friction = std::move(*states);
  } else {
    Plan followed = plan;
    follow_states(task, rubbing, followed, stop);
    const bool any = task.scene.contact.friction_state == FrictionState::any;
    if (any && followed.status != PlanStatus::solved) {
      // It holds if friction is as planned, and says so.
      plan.notes.push_back("not in every state of friction: " + followed.message);
    } else {
      plan = std::move(followed);
    }
  }
  tell_limits(task, plan);
}

}  // namespace tendril
