#include "problem/friction.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "grasp/frames.hpp"
#include "rod/self_overlap.hpp"
#include "scene/plan_report.hpp"
#include "search/rubbing.hpp"
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

/// States of a plan, or why there are none: its status and message then, and "" as long as nothing is wrong.
struct Followed {
  FrictionStates found{};
  PlanStatus status = PlanStatus::solved;
  std::string why{};
};

/// The states as execution of `scene` reaches them, which makes and releases contacts on the way, at each obstacle
/// alike. A state that is not reached: says which, and how far the plan holds.
Followed follow_executed(const Scene& scene, const std::vector<std::unique_ptr<Obstacle>>& obstacles,
                         const std::set<std::size_t>& rubbing, const Plan& plan, const std::atomic<bool>* stop) {
  ExecuteControl control;
  control.stop = stop;
  control.time_limit = scene.solver.time_limit;
  control.start = &plan;
  control.with_friction = false;
  const Execution without = execute(scene, obstacles, plan, control);
  if (without.result.status != PlanStatus::solved) {
    return {{}, without.result.status, "without friction the plan's shape did not settle: " + without.result.message};
  }
  control.start = &without.result;
  Eigen::VectorXd limits(static_cast<Eigen::Index>(rubbing.size()));
  std::transform(rubbing.begin(), rubbing.end(), limits.begin(), [&](std::size_t o) { return friction_of(scene, o); });
  Execution slipping;
  const StateAt state = [&](const Eigen::VectorXd& ratios) -> std::optional<SeenState> {
    if (ratios.isZero(0.0)) return SeenState{record(without.result, plan, {}), without.result.backbone};
    control.friction.assign(scene.obstacles.size(), 0.0);
    const double* ratio = ratios.data();
    for (const std::size_t o : rubbing) control.friction[o] = *ratio++;
    slipping = execute(scene, obstacles, plan, control);
    if (slipping.result.status != PlanStatus::solved) return std::nullopt;
    return SeenState{record(slipping.result, plan, control.friction), slipping.result.backbone};
  };
  Followed out{follow_states(limits, state, false)};
  if (out.found.lost.size() == 0) return out;
  std::string where;
  const double* ratio = out.found.lost.data();
  const std::vector<std::string> names = obstacle_names(scene);
  for (const std::size_t o : rubbing) where += (where.empty() ? "" : ", ") + shown(*ratio++) + " at '" + names[o] + "'";
  const bool cut =
      slipping.result.status == PlanStatus::interrupted || slipping.result.status == PlanStatus::time_limit;
  out.status = cut ? slipping.result.status : PlanStatus::unstable;
  out.why = "under friction the plan holds up to " + shown(slipping.load, 3) + " of the ratios " + where + ": " +
            slipping.result.message;
  return out;
}

Followed follow_pose(const Task& task, const std::set<std::size_t>& rubbing, const Plan& plan,
                     const std::atomic<bool>* stop) {
  if (auto own = friction_states(task, plan); own && own->lost.size() == 0) return {std::move(*own)};
  Scene scene = task.scene;
  scene.target.position.reset();
  if (task.target.has_position) scene.target.position = task.scale.length * task.target.position;
  return follow_executed(scene, task.components.obstacles, rubbing, plan, stop);
}

/// A finger whose object stays where it is; `plan`: its own, in its world.
Followed follow_finger(const Task& finger, const Plan& plan, const std::atomic<bool>* stop) {
  if (auto own = friction_states(finger, plan); own && own->lost.size() == 0) return {std::move(*own)};
  // Its scene is in the palm's frame.
  Scene scene = finger.scene;
  const GripperSpec gripper = *scene.gripper;
  scene.gripper->position = {};
  scene.gripper->angle = 0.0;
  const std::vector<std::unique_ptr<Obstacle>> obstacles = obstacles_of_finger(scene, plan.grasp->palm_distance);
  Followed out = follow_executed(finger_in_world(scene), obstacles, {0}, plan, stop);
  for (SeenState& state : out.found.states) {
    const bool behind = std::any_of(state.shape.begin(), state.shape.end(), [&](const BackbonePoint& p) {
      return p.x < -tolerance::penetration * finger.scale.length;
    });
    if (behind) return {{}, PlanStatus::unstable, "under friction a finger would lie in the palm"};
    Plan placed;
    placed.contacts = std::move(state.range.contacts);
    placed.backbone = std::move(state.shape);
    finger_to_world(gripper, 0.0, placed);
    state.range.contacts = std::move(placed.contacts);
    state.shape = std::move(placed.backbone);
    state.range.tip_x = placed.tip_x;
    state.range.tip_y = placed.tip_y;
    state.range.tip_angle = placed.tip_angle;
  }
  return out;
}

std::vector<BackbonePoint> sides(const Task& finger, const std::vector<BackbonePoint>& shape) {
  const BodyRadius body = finger.scene.rod.body();
  return body ? body_outline(shape, body) : shape;
}

/// Of two fingers all pairs of their states, the upper finger's contacts before the lower one's.
Followed follow_fingers(const Task& upper, const Plan& plan, const std::atomic<bool>* stop) {
  Followed above = follow_finger(upper, plan_of_finger(upper.scene, plan, FingerName::upper), stop);
  if (!above.why.empty()) return above;
  Followed below = follow_finger(*upper.lower, plan_of_finger(upper.lower->scene, plan, FingerName::lower), stop);
  if (!below.why.empty()) return below;
  for (SeenState& state : below.found.states) {
    Plan image;
    image.contacts = std::move(state.range.contacts);
    image.backbone = std::move(state.shape);
    FingerPlan there = lower_in_world(upper.scene, image);
    state.range.contacts = std::move(there.contacts);
    state.shape = std::move(there.backbone);
  }
  Followed pairs;
  for (const SeenState& one : above.found.states) {
    for (const SeenState& other : below.found.states) {
      if (meeting_of(sides(upper, one.shape), sides(*upper.lower, other.shape)))
        return {{}, PlanStatus::unstable, "under friction the fingers would cross each other"};
      FrictionRange range = one.range;
      range.stability = std::min(range.stability, other.range.stability);
      range.contacts.insert(range.contacts.end(), other.range.contacts.begin(), other.range.contacts.end());
      range.ratios.insert(range.ratios.end(), other.range.ratios.begin(), other.range.ratios.end());
      pairs.found.states.push_back({std::move(range), {}});
    }
  }
  return pairs;
}

/// A plan that was made without friction keeps its limits so.
void tell_limits(const Task& task, Plan& plan) {
  constexpr double share = 1.0 + tolerance::bounds;
  double force = 0.0;
  double miss = 0.0;
  for (const FrictionRange& state : plan.friction) {
    for (std::size_t k = 0; k < state.contacts.size(); ++k) {
      // Behind the contacts of the upper finger come those of the lower one, which has limits of its own.
      const Task& finger = task.lower && k >= plan.contacts.size() ? *task.lower : task;
      const double most = finger.scene.contact.max_force;
      if (state.contacts[k].force > most * share) force = std::max(force, state.contacts[k].force);
    }
    miss = std::max(miss, state.target_error.value_or(0.0));
  }
  if (force > 0.0) {
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
  const double trace = tolerance::force * task.scene_scale.force();
  std::set<std::size_t> rubbing;
  for (const PlannedContact& c : plan.contacts) {
    const auto o = static_cast<std::size_t>(c.obstacle);
    if (c.force > trace && friction_of(task.scene, o) > 0.0) rubbing.insert(o);
  }
  if (rubbing.empty()) return;
  Followed followed = !task.palm   ? follow_pose(task, rubbing, plan, stop)
                      : task.lower ? follow_fingers(task, plan, stop)
                                   : follow_finger(task, plan, stop);
  if (followed.why.empty()) {
    for (SeenState& state : followed.found.states) plan.friction.push_back(std::move(state.range));
    if (!followed.found.note.empty()) plan.notes.push_back(followed.found.note);
  } else if (task.scene.contact.friction_state == FrictionState::any) {
    // It holds if friction is as planned, and says so.
    plan.notes.push_back("not in every state of friction: " + followed.why);
  } else {
    plan.status = followed.status;
    plan.message = followed.why;
  }
  tell_limits(task, plan);
}

}  // namespace tendril
