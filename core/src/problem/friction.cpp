#include "problem/friction.hpp"

#include <algorithm>
#include <set>

#include "search/task.hpp"
#include "tendril/execute.hpp"
#include "tendril/numbers.hpp"
#include "tendril/tolerances.hpp"

namespace tendril {
namespace {

/// Corners double with every obstacle.
constexpr std::size_t most_rubbing = 5;

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

void find_friction_range(const Task& task, Plan& plan, const std::atomic<bool>* stop) {
  if (plan.status != PlanStatus::solved) return;
  const double trace = tolerance::force * task.scale.force();
  std::set<std::size_t> rubbing;
  for (const PlannedContact& c : plan.contacts) {
    const auto o = static_cast<std::size_t>(c.obstacle);
    if (c.force > trace && friction_of(task.scene, o) > 0.0) rubbing.insert(o);
  }
  if (rubbing.empty()) return;
  const auto refuse = [&plan](PlanStatus status, const std::string& why) {
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
      plan.friction.clear();
      const bool cut =
          slipping.result.status == PlanStatus::interrupted || slipping.result.status == PlanStatus::time_limit;
      return refuse(cut ? slipping.result.status : PlanStatus::unstable,
                    "under friction the plan holds up to " + shown(slipping.load, 3) + " of the ratios " + where +
                        ": " + slipping.result.message);
    }
    plan.friction.push_back(record(slipping.result, plan, control.friction));
  }
}

}  // namespace tendril
