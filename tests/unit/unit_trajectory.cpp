// The walk along targets, with a planner made up for the test: what is asked of it, and what is kept.

#include <gtest/gtest.h>

#include <cmath>

#include "support/print.hpp"
#include "tendril/trajectory.hpp"

namespace tendril {
namespace {

std::vector<TargetSpec> targets_at(const std::vector<double>& x) {
  std::vector<TargetSpec> targets;
  targets.reserve(x.size());
  for (const double at : x) targets.push_back({Vec2{at, 0.0}, at});
  return targets;
}

/// Reaches a target only from a start that is at most `stride` away; the tip is then at the target.
struct Strider {
  double stride = 1.0;
  double wall = infinity;  ///< nothing beyond is ever reached
  std::vector<double> asked{};
  std::vector<bool> followed{};

  Plan operator()(const TargetSpec& target, const Plan* start, bool follow) {
    Plan plan;
    asked.push_back(target.position->x);
    followed.push_back(follow);
    EXPECT_DOUBLE_EQ(target.position->x, *target.angle);
    const bool near = start == nullptr || std::abs(start->tip_x - target.position->x) <= stride;
    plan.status = near && target.position->x <= wall ? PlanStatus::solved : PlanStatus::not_converged;
    plan.tip_x = target.position->x;
    plan.modes.push_back({"free", "", follow && near ? 0 : 1, 1});
    plan.evaluations.values = 10;
    return plan;
  }
};

TEST(Trajectory, FollowsWhereItCan) {
  Strider strider;
  const Trajectory t = plan_trajectory(targets_at({0.0, 1.0, 2.0}), {}, std::ref(strider));
  ASSERT_EQ(t.steps.size(), 3U);
  EXPECT_TRUE(t.solved());
  EXPECT_EQ(t.steps[0].method, StepMethod::solved);
  EXPECT_EQ(t.steps[1].method, StepMethod::followed);
  EXPECT_EQ(t.steps[2].method, StepMethod::followed);
  EXPECT_EQ(strider.followed, (std::vector<bool>{false, true, true}));
}

TEST(Trajectory, PutsTargetsInBetweenWhereAStepIsTooLong) {
  Strider strider;
  const Trajectory t = plan_trajectory(targets_at({0.0, 3.0, 4.0}), {}, std::ref(strider));
  ASSERT_EQ(t.steps.size(), 3U);
  EXPECT_TRUE(t.solved());
  EXPECT_EQ(t.steps[1].method, StepMethod::subdivided);
  EXPECT_DOUBLE_EQ(t.steps[1].plan.tip_x, 3.0);
  // 3 fails, 1.5 fails, 0.75 and 1.5 follow, 3 fails again, 2.25 and 3 follow.
  EXPECT_EQ(strider.asked, (std::vector<double>{0.0, 3.0, 1.5, 0.75, 1.5, 3.0, 2.25, 3.0, 4.0}));
  EXPECT_EQ(t.steps[1].intermediate, 6);
  EXPECT_EQ(t.steps[1].effort.evaluations.values, 70);
}

TEST(Trajectory, KeepsAStepThatCannotBeReachedAndGoesOnFromTheLastOne) {
  Strider strider{1.0, 1.5};
  const Trajectory t = plan_trajectory(targets_at({0.0, 1.0, 2.0, 1.2}), {}, std::ref(strider));
  ASSERT_EQ(t.steps.size(), 4U);
  EXPECT_FALSE(t.solved());
  EXPECT_EQ(t.steps[2].method, StepMethod::failed);
  EXPECT_EQ(t.steps[2].plan.status, PlanStatus::not_converged);
  EXPECT_LE(t.steps[2].intermediate, most_intermediate);
  EXPECT_EQ(t.steps[3].method, StepMethod::followed);
}

TEST(Trajectory, EndsTryingAtAStatedNumberOfIntermediateTargets) {
  Strider strider{1e-3};
  const Trajectory t = plan_trajectory(targets_at({0.0, 1.0}), {}, std::ref(strider));
  ASSERT_EQ(t.steps.size(), 2U);
  EXPECT_EQ(t.steps[1].method, StepMethod::failed);
  EXPECT_EQ(t.steps[1].intermediate, most_halvings);
  Strider almost{1.0 / 40.0};
  EXPECT_EQ(plan_trajectory(targets_at({0.0, 1.0}), {}, std::ref(almost)).steps[1].intermediate, most_intermediate);
}

TEST(Trajectory, PlansInFullEverySoManyStepsIfAsked) {
  Strider strider;
  plan_trajectory(targets_at({0.0, 1.0, 2.0, 3.0, 4.0}), {2, false}, std::ref(strider));
  EXPECT_EQ(strider.followed, (std::vector<bool>{false, true, false, true, false}));
}

TEST(Trajectory, IsCutOffByAnInterruption) {
  int calls = 0;
  const Trajectory t = plan_trajectory(targets_at({0.0, 1.0, 2.0}), {}, [&](const TargetSpec&, const Plan*, bool) {
    Plan plan;
    plan.status = ++calls < 2 ? PlanStatus::solved : PlanStatus::interrupted;
    return plan;
  });
  EXPECT_EQ(calls, 2);
  EXPECT_EQ(t.steps.size(), 1U);
  EXPECT_TRUE(t.interrupted);
  EXPECT_FALSE(t.solved());
}

// An interruption between two targets ends the walk as one at a target does.
TEST(Trajectory, IsCutOffByAnInterruptionOnTheWayToATarget) {
  Strider strider;
  int between = 0;
  const auto plan = [&](const TargetSpec& target, const Plan* start, bool follow) {
    Plan next = strider(target, start, follow);
    const double x = target.position->x;
    if (x != std::round(x) && ++between == 2) next.status = PlanStatus::interrupted;
    return next;
  };
  const Trajectory t = plan_trajectory(targets_at({0.0, 3.0, 4.0}), {}, plan);
  EXPECT_EQ(between, 2);
  EXPECT_TRUE(t.interrupted);
  EXPECT_FALSE(t.solved());
  ASSERT_EQ(t.steps.size(), 1U);
  EXPECT_EQ(t.steps[0].plan.tip_x, 0.0);
}

// The status of a step that was not reached is that of the attempt from the step before, whatever was met between.
TEST(Trajectory, AStepThatFailsKeepsItsOwnPlan) {
  for (const PlanStatus status : {PlanStatus::infeasible, PlanStatus::unstable, PlanStatus::time_limit,
                                  PlanStatus::diverged, PlanStatus::failed}) {
    SCOPED_TRACE(to_string(status));
    const Trajectory t =
        plan_trajectory(targets_at({0.0, 1.0, 0.5}), {}, [&](const TargetSpec& target, const Plan*, bool) {
          Plan plan;
          const double x = target.position->x;
          plan.status = x <= 0.5 ? PlanStatus::solved : x == 1.0 ? status : PlanStatus::not_converged;
          plan.tip_x = x;
          return plan;
        });
    ASSERT_EQ(t.steps.size(), 3U);
    EXPECT_FALSE(t.solved());
    EXPECT_FALSE(t.interrupted);
    EXPECT_EQ(t.steps[1].method, StepMethod::failed);
    EXPECT_EQ(to_string(t.steps[1].plan.status), to_string(status));
    EXPECT_EQ(t.steps[1].plan.tip_x, 1.0);
    EXPECT_EQ(to_string(t.steps[2].plan.status), "solved");
  }
}

TEST(Trajectory, ColdStartsAreCountedBesideTheStepAndStartFromNothing) {
  int cold = 0;
  const Trajectory t =
      plan_trajectory(targets_at({0.0, 1.0}), {0, true}, [&](const TargetSpec&, const Plan* start, bool follow) {
        Plan plan;
        plan.status = PlanStatus::solved;
        if (start == nullptr) ++cold;
        EXPECT_TRUE(start != nullptr || !follow);
        plan.modes.push_back({"free", "", start == nullptr ? 5 : 0, 1});
        plan.evaluations.values = start == nullptr ? 100 : 7;
        return plan;
      });
  ASSERT_EQ(t.steps.size(), 2U);
  EXPECT_EQ(cold, 3);  // the first step itself, and one for each
  EXPECT_EQ(t.steps[1].method, StepMethod::followed);
  EXPECT_EQ(t.steps[1].effort.solver_calls, 0);
  EXPECT_EQ(t.steps[1].effort.polishes, 1);
  EXPECT_EQ(t.steps[1].effort.evaluations.values, 7);
  EXPECT_EQ(t.steps[1].cold.solver_calls, 5);
  EXPECT_EQ(t.steps[1].cold.evaluations.values, 100);
}

}  // namespace
}  // namespace tendril
