#include "tendril/trajectory.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tendril/leading.hpp"

namespace tendril {

TargetSpec between(const TargetSpec& a, const TargetSpec& b, double share) {
  TargetSpec middle = b;
  if (a.position && b.position) middle.position = *a.position + share * (*b.position - *a.position);
  // Directions: the shorter way round.
  if (a.angle && b.angle) middle.angle = *a.angle + share * std::remainder(*b.angle - *a.angle, 2.0 * std::numbers::pi);
  for (std::size_t i = 0; i < std::min(a.obstacles.size(), b.obstacles.size()); ++i) {
    const ObstaclePlace& from = a.obstacles[i].place;
    ObstaclePlace& to = middle.obstacles[i].place;
    to = {from.turn + share * (to.turn - from.turn), from.shift + share * (to.shift - from.shift)};
  }
  return middle;
}

namespace {

class Walker {
 public:
  Walker(const TrajectoryOptions& options, const PlanStep& plan) : options_(options), plan_(plan) {}

  TrajectoryStep step(const TargetSpec& target, bool full) {
    TrajectoryStep step;
    step.target = target;
    current_ = &step;
    step.plan = attempt(target, !full);
    if (step.plan.status == PlanStatus::solved) {
      step.method = effort_of(step.plan).solver_calls == 0 ? StepMethod::followed : StepMethod::solved;
    } else if (has_last_ && step.plan.status != PlanStatus::interrupted) {
      Plan over = subdivide(target, last_target_, last_, 0);
      if (over.status == PlanStatus::solved || over.status == PlanStatus::interrupted) step.plan = std::move(over);
      if (step.plan.status == PlanStatus::solved) step.method = StepMethod::subdivided;
    }
    if (step.plan.status == PlanStatus::solved) {
      last_ = step.plan;
      last_target_ = target;
      has_last_ = true;
    }
    if (options_.cold_starts && step.plan.status != PlanStatus::interrupted) {
      step.cold = effort_of(plan_(target, nullptr, false));
    }
    return step;
  }

 private:
  Plan attempt(const TargetSpec& target, bool follow) {
    Plan plan = plan_(target, has_last_ ? &last_ : nullptr, has_last_ && follow);
    current_->effort += effort_of(plan);
    return plan;
  }

  /// From `from`, which was reached with `start`, to `target`, which was not reached at once.
  Plan subdivide(const TargetSpec& target, const TargetSpec& from, const Plan& start, int depth) {
    Plan unreached;
    unreached.message = "too many intermediate targets";
    if (depth == most_halvings) return unreached;
    const TargetSpec middle = between(from, target, 0.5);
    Plan reached = start;
    for (const auto& [goal, previous] : {std::pair(&middle, &from), std::pair(&target, &middle)}) {
      if (current_->intermediate == most_intermediate) return unreached;
      ++current_->intermediate;
      Plan next = plan_(*goal, &reached, true);
      current_->effort += effort_of(next);
      if (next.status == PlanStatus::interrupted) return next;
      if (next.status != PlanStatus::solved) next = subdivide(*goal, *previous, reached, depth + 1);
      if (next.status != PlanStatus::solved) return next;
      reached = std::move(next);
    }
    return reached;
  }

  const TrajectoryOptions& options_;
  const PlanStep& plan_;
  Plan last_;  ///< the last step that was reached
  TargetSpec last_target_;
  bool has_last_ = false;
  TrajectoryStep* current_ = nullptr;
};

}  // namespace

std::string_view to_string(StepMethod method) {
  switch (method) {
    case StepMethod::followed:
      return "followed";
    case StepMethod::solved:
      return "solved";
    case StepMethod::subdivided:
      return "subdivided";
    case StepMethod::failed:
      return "failed";
    case StepMethod::executed:
      return "executed";
  }
  return "?";
}

Effort effort_of(const Plan& plan) {
  Effort effort;
  for (const ModeRecord& mode : plan.modes) {
    effort.solver_calls += mode.solves;
    effort.polishes += mode.polishes;
  }
  effort.evaluations = plan.evaluations;
  return effort;
}

Effort& operator+=(Effort& sum, const Effort& more) {
  sum.solver_calls += more.solver_calls;
  sum.polishes += more.polishes;
  sum.evaluations += more.evaluations;
  return sum;
}

bool Trajectory::solved() const {
  return !interrupted && std::all_of(steps.begin(), steps.end(),
                                     [](const TrajectoryStep& step) { return step.plan.status == PlanStatus::solved; });
}

Scene with_obstacles(Scene scene, const TargetSpec& step) {
  for (const MovedObstacle& m : step.obstacles) scene.obstacles[static_cast<std::size_t>(m.obstacle)].place = m.place;
  return scene;
}

Trajectory plan_trajectory(const std::vector<TargetSpec>& targets, const TrajectoryOptions& options,
                           const PlanStep& plan) {
  Trajectory trajectory;
  Walker walker(options, plan);
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const bool full = options.replan_every > 0 && i % static_cast<std::size_t>(options.replan_every) == 0;
    TrajectoryStep step = walker.step(targets[i], full);
    trajectory.interrupted = step.plan.status == PlanStatus::interrupted;
    if (trajectory.interrupted) break;
    trajectory.steps.push_back(std::move(step));
    if (options.progress) options.progress(static_cast<int>(i + 1), static_cast<int>(targets.size()));
  }
  return trajectory;
}

}  // namespace tendril
