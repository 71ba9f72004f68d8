// A direction is one modulo a full turn: whichever number stands for it, and wherever the base points, the plan is the
// same; and a direction that the rod reaches by one turn or the other is reached.

#include <cmath>
#include <numbers>

#include "support.hpp"
#include "tendril/trajectory.hpp"

namespace tendril::combination {
namespace {

constexpr double degree = std::numbers::pi / 180.0;

/// An arm whose base points to the left, and a wish for the tip's direction alone.
Scene arm(const std::string& solver, double direction, const std::vector<std::string>& overrides = {}) {
  Scene made = scene_from_text(R"(
problem = "pose"
gravity = [0, -9.81]
[rod]
length = "100 mm"
bending_stiffness = "1e-3 N m^2"
linear_density = "40 g/m"
[rod.base]
angle = "180 deg"
[[rod.actuator]]
min = "-60 N mm"
max = "60 N mm"
[target]
angle = 0
[[objective]]
plugin = "tip_pose"
weight = 10
[[objective]]
plugin = "actuation_effort"
weight = 1e-6
)",
                               overrides);
  made.target.angle = direction;
  made.solver.plugin = solver;
  return made;
}

/// Of two directions, rad.
double apart(double a, double b) { return std::abs(std::remainder(a - b, 2.0 * std::numbers::pi)); }

class Directions : public testing::TestWithParam<std::string> {};

TEST_P(Directions, EveryOneIsReachedAndFullTurnsDoNotCount) {
  Problem ready = problem(arm(GetParam(), 0.0));
  for (int d = -180; d < 180; ++d) {
    SCOPED_TRACE(d);
    TargetSpec target;
    target.angle = d * degree;
    ready.set_target(target);
    const Plan plan = ready.plan();
    ASSERT_TRUE(certified(plan));
    // The effort pulls by so much.
    EXPECT_LT(apart(plan.tip_angle, *target.angle), 1e-3);
    EXPECT_LE(std::abs(plan.tip_angle - 180.0 * degree), 180.5 * degree) << "not the shorter way round";
    if (d % 3 != 0) continue;
    target.angle = (d + (d % 2 == 0 ? 360 : -720)) * degree;
    ready.set_target(target);
    const Plan turned = ready.plan();
    ASSERT_TRUE(certified(turned));
    EXPECT_EQ(plan.coordinates, turned.coordinates);
    EXPECT_EQ(plan.moments, turned.moments);
  }
}

// Moments to the left alone: directions to the right of the base are reached the long way round.
TEST_P(Directions, WhatOneWayReachesIsReached) {
  Problem ready = problem(arm(GetParam(), 0.0, {"rod.actuator.0.min=0"}));
  for (int beyond = 5; beyond <= 335; beyond += 3) {
    SCOPED_TRACE(beyond);
    TargetSpec target;
    target.angle = (180.0 + beyond) * degree;
    ready.set_target(target);
    const Plan plan = ready.plan();
    ASSERT_TRUE(certified(plan));
    EXPECT_LT(apart(plan.tip_angle, *target.angle), 0.02);
  }
}

// A rod that is curled up at rest: of the angles that a direction stands for, those that it can make are turns away
// from where the search starts.
TEST_P(Directions, OneThatLiesTurnsAwayIsReached) {
  for (const char* rest : {"\"-7.6 1/m\"", "\"9 1/m\"", "\"16 1/m\""}) {
    for (int d = -150; d <= 180; d += 30) {
      SCOPED_TRACE(std::string(rest) + " " + std::to_string(d));
      const Plan found = plan(arm(GetParam(), d * degree,
                                  {"gravity=[0,0]", "rod.length=\"1 m\"", std::string("rod.rest_curvature=") + rest,
                                   "rod.actuator.0.min=\"-3.3 N mm\"", "rod.actuator.0.max=\"3.3 N mm\""}));
      ASSERT_TRUE(certified(found));
      EXPECT_LT(apart(found.tip_angle, d * degree), 0.01);
    }
  }
}

// A peg turns a rod, whose moment is held, by more than half a turn against the direction next to its start: it is
// nearer to the one a turn away.
TEST_P(Directions, WhatAnObstacleTurnsIsMeasuredAgainstTheNearestTurn) {
  const std::string text = R"(
problem = "pose"
gravity = ["7 m/s^2", "6.9 m/s^2"]
rod = {length = "7.9 mm", bending_stiffness = "1.2e-4 N mm^2", linear_density = "4.2 mg/m", base = {position = ["-4.84 mm", "5.55 mm"], angle = 0.846}, actuator = [{min = "2.6e-5 N mm", max = "2.6e-5 N mm"}]}
coordinates = {order = 9}
contact = {mode = "require", min_force = "0.66 uN"}
target = {position = ["0.08 mm", "11.75 mm"], angle = -0.093}
obstacle = [{name = "peg", shape = "circle", center = ["-6.118 mm", "9.771 mm"], radius = "0.202 mm"}]
objective = [{plugin = "tip_pose"}]
)";
  const Plan found = plan(scene_from_text(text, {"solver.plugin=" + GetParam()}));
  ASSERT_TRUE(certified(found));
  EXPECT_GT(found.tip_angle, std::numbers::pi - 0.093) << "of another equilibrium nothing is shown";
  const Plan turned = plan(
      scene_from_text(text, {"solver.plugin=" + GetParam(), "target.angle=\"354.67 deg\"", "start.tip_angle=3.5"}));
  ASSERT_TRUE(certified(turned));
  EXPECT_NEAR(found.objective, turned.objective, 1e-3 * turned.objective);
}

TEST_P(Directions, TurnsAreAWishOfTheirOwn) {
  for (const int turns : {-1, 0, 1}) {
    Scene scene =
        arm(GetParam(), 200.0 * degree, {"rod.actuator.0.min=\"-100 N mm\"", "rod.actuator.0.max=\"100 N mm\""});
    scene.target.turns = turns;
    const Plan found = plan(scene);
    ASSERT_TRUE(certified(found));
    EXPECT_NEAR(found.tip_angle, (200.0 + 360.0 * turns) * degree, 1e-3) << turns;
  }
}

INSTANTIATE_TEST_SUITE_P(Solvers, Directions, testing::ValuesIn(solvers_to_combine()),
                         [](const auto& solver) { return solver.param; });

// The arm of the fault that was reported: -170 deg is 10 deg beyond its base, not 350 deg before it.
TEST(Direction, OfAnArmThatPointsToTheLeft) {
  std::vector<Plan> plans;
  for (const double degrees : {-170.0, 190.0, 550.0}) {
    for (const std::string& solver : solvers_to_combine()) {
      Scene scene = arm(solver, degrees * degree);
      scene.target.position = Vec2{-0.099, -0.009};
      plans.push_back(plan(scene));
      ASSERT_TRUE(certified(plans.back())) << solver;
      EXPECT_LT(*plans.back().target_error, 1.2e-3) << solver << ", " << degrees;
    }
  }
}

// Through +-180 degrees a trajectory goes on where it was going.
TEST(Direction, ATrajectoryContinuesThroughHalfATurn) {
  Problem ready = problem(arm(solvers_to_combine().front(), 0.0));
  std::vector<TargetSpec> targets;
  for (const double degrees : {150.0, 170.0, -170.0, -150.0, -90.0, 0.0, 20.0})
    targets.push_back({std::nullopt, degrees * degree});
  const Trajectory found = plan_trajectory(targets, {}, [&](const TargetSpec& target, const Plan* start, bool follow) {
    ready.set_target(target);
    PlanControl control;
    control.start = start;
    control.follow = follow;
    return ready.plan(control);
  });
  ASSERT_TRUE(found.solved());
  const double expected[] = {150.0, 170.0, 190.0, 210.0, 270.0, 360.0, 380.0};
  for (std::size_t i = 0; i < targets.size(); ++i) {
    EXPECT_NEAR(found.steps[i].plan.tip_angle, expected[i] * degree, 1e-3) << i;
  }
}

}  // namespace
}  // namespace tendril::combination
