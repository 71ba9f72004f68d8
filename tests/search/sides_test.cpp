// On which side of an obstacle the rod passes is no matter of the start or of the solver, and a plan that is held at
// the limit of stability competes with all others.

#include <cmath>

#include "combination/support.hpp"
#include "tendril/tolerances.hpp"

namespace tendril::search {
namespace {

using combination::certified;
using combination::scene;
using combination::scene_from_text;

constexpr double same = 1e-6;  ///< relative, of objectives

const char* const gap = R"(
title = "Through a gap"
[rod]
length = "200 mm"
bending_stiffness = "5e-4 N m^2"
[[rod.actuator]]
to = "100 mm"
limit = "20 N mm"
[[rod.actuator]]
from = "100 mm"
limit = "20 N mm"
[[obstacle]]
name = "upper"
shape = "polygon"
vertices = [["90 mm", "36 mm"], ["110 mm", "36 mm"], ["110 mm", "120 mm"], ["90 mm", "120 mm"]]
rounding = "1 mm"
[[obstacle]]
name = "lower"
shape = "polygon"
vertices = [["90 mm", "-120 mm"], ["110 mm", "-120 mm"], ["110 mm", "28 mm"], ["90 mm", "28 mm"]]
rounding = "1 mm"
[contact]
max_force = "2 N"
[target]
position = ["175 mm", "20 mm"]
[[objective]]
plugin = "tip_pose"
weight = 100
[[objective]]
plugin = "actuation_effort"
weight = 1e-4
)";

const char* const pin_beside_the_base = R"(
title = "Under a pin beside the base"
problem = "pose"
[[rod.segment]]
length = "55 mm"
bending_stiffness = "1e-3 N m^2"
[[rod.segment]]
length = "45 mm"
bending_stiffness = "2.76e-3 N m^2"
[[rod.actuator]]
limit = "29.5 N mm"
[tip_load]
force = ["0.93 N", "0.62 N"]
[[obstacle]]
name = "pin"
shape = "circle"
center = ["14.6 mm", "-5.97 mm"]
radius = "0.5 mm"
[contact]
mode = "allow"
[target]
position = ["99.65 mm", "-7.18 mm"]
[[objective]]
plugin = "tip_pose"
weight = 100
[[objective]]
plugin = "actuation_effort"
weight = 1e-4
[coordinates]
plugin = "pcc"
pieces = 6
split_at_contact = false
[start]
tip_angle = 0
)";

const char* const pin = R"(
title = "Tip first into a pin"
gravity = [0, -9.81]
[rod]
length = "100 mm"
bending_stiffness = "4.9e-4 N m^2"
linear_density = "40 g/m"
rest_curvature = "4 1/m"
[[rod.actuator]]
limit = "5 N mm"
[[obstacle]]
shape = "circle"
center = ["103 mm", "9 mm"]
radius = "5 mm"
[contact]
count = 2
[target]
position = ["97 mm", "9 mm"]
[[objective]]
plugin = "tip_pose"
weight = 100
[[objective]]
plugin = "actuation_effort"
weight = 1e-4
)";

const char* const finger = R"(
title = "A finger that presses up to the limit of stability"
problem = "grasp"
[[rod.segment]]
length = "30 mm"
bending_stiffness = "7e-4 N m^2"
[[rod.segment]]
length = "45 mm"
bending_stiffness = "3e-4 N m^2"
[[rod.actuator]]
limit = "60 N mm"
[[rod.actuator]]
from = "30 mm"
limit = "60 N mm"
[gripper]
half_palm = "30 mm"
object_diameter = "40 mm"
[contact]
max_force = "2 N"
[[objective]]
plugin = "contact_force"
weight = 1
[[objective]]
plugin = "actuation_effort"
weight = 1e-3
)";

// The straight start runs through the peg; from bent ones the arm is planned above it.
TEST(SearchSides, AStartThroughAnObstacleLeadsToTheBestSideWithEverySolver) {
  for (const std::string& solver : combination::solvers_to_combine()) {
    SCOPED_TRACE(solver);
    const Plan bent = combination::plan_with(scene("brace", {"start.tip_angle=1"}), solver);
    ASSERT_TRUE(certified(bent));
    for (const char* angle : {"0", "-1", "2"}) {
      SCOPED_TRACE(angle);
      const Plan found = combination::plan_with(scene("brace", {std::string("start.tip_angle=") + angle}), solver);
      ASSERT_TRUE(certified(found));
      EXPECT_NEAR(found.objective, bent.objective, same * std::abs(bent.objective));
    }
  }
}

// From the straight start a local search curls up below the lower wall, at 41.7; through the gap it costs 0.536.
TEST(SearchSides, AGapIsFoundWithEverySolver) {
  for (const std::string& solver : combination::solvers_to_combine()) {
    SCOPED_TRACE(solver);
    Scene made = scene_from_text(gap);
    made.solver.time_limit = 120.0;
    const Plan found = combination::plan_with(made, solver);
    ASSERT_TRUE(certified(found));
    EXPECT_LT(found.objective, 0.55);
  }
}

// With contact at the tip the objective falls up to where equilibria end.
TEST(SearchSides, WhatAllowsMoreCostsNoMore) {
  for (const std::string& solver : combination::solvers_to_combine()) {
    SCOPED_TRACE(solver);
    for (const char* least : {"\"1 mN\"", "\"100 mN\""}) {
      SCOPED_TRACE(least);
      const std::vector<std::string> require{"contact.mode=require", std::string("contact.min_force=") + least};
      const Plan required = combination::plan_with(scene_from_text(pin, require), solver);
      const Plan allowed = combination::plan_with(scene_from_text(pin), solver);
      const Plan avoided = combination::plan_with(scene_from_text(pin, {"contact.mode=avoid"}), solver);
      ASSERT_TRUE(certified(required));
      ASSERT_TRUE(certified(allowed));
      ASSERT_TRUE(certified(avoided));
      EXPECT_LE(allowed.objective, required.objective * (1.0 + same));
      EXPECT_LE(allowed.objective, avoided.objective * (1.0 + same));
    }
  }
}

// With 0.6 N the finger would press with all of it and give way: it presses as hard as it can be held.
TEST(SearchSides, AFingerPressesUpToTheLimitOfStabilityWithEverySolver) {
  for (const std::string& solver : combination::solvers_to_combine()) {
    SCOPED_TRACE(solver);
    const Plan weaker = combination::plan_with(scene_from_text(finger, {"contact.max_force=0.4 N"}), solver);
    const Plan held = combination::plan_with(scene_from_text(finger, {"contact.max_force=0.6 N"}), solver);
    ASSERT_TRUE(certified(weaker));
    ASSERT_TRUE(certified(held));
    EXPECT_GT(weaker.certificate.stability, 0.1);
    EXPECT_NEAR(held.certificate.stability, tolerance::held_margin, 0.1 * tolerance::held_margin);
    EXPECT_LT(held.objective, weaker.objective);
  }
}

// Pushed down by the pin the rod bends back towards the target, as no single arc does.
TEST(SearchSides, ARodOfOneMomentIsBentInTwoByAContact) {
  const Plan plan = combination::plan(scene_from_text(pin_beside_the_base));
  ASSERT_TRUE(certified(plan));
  EXPECT_LT(plan.target_error.value(), 3e-3) << "23 mm without the contact";
  EXPECT_EQ(plan.contacts.size(), 1U);
}

// What a problem keeps from one plan for the next is the same for every target.
TEST(SearchSides, AnEarlierTargetChangesNothingOfAPlan) {
  for (const std::string& solver : combination::solvers_to_combine()) {
    SCOPED_TRACE(solver);
    Scene made = scene("brace");
    made.solver.plugin = solver;
    Problem kept = combination::problem(made);
    for (const Vec2 at : {Vec2{0.097, 0.02}, Vec2{0.093, 0.008}, Vec2{0.098, 0.015}, Vec2{0.097, 0.02}}) {
      made.target.position = at;
      Problem fresh = combination::problem(made);
      kept.set_target(made.target);
      const Plan once = fresh.plan();
      const Plan again = kept.plan();
      ASSERT_TRUE(certified(once));
      ASSERT_TRUE(certified(again));
      EXPECT_EQ(again.coordinates, once.coordinates);
      EXPECT_EQ(again.moments, once.moments);
      EXPECT_EQ(again.objective, once.objective);
    }
  }
}

// The mirror image of a scene has the mirror image of its plan.
TEST(SearchSides, AMirroredSceneHasTheMirroredPlan) {
  const Plan upright = combination::plan(scene("brace", {"start.tip_angle=0"}));
  const Plan mirrored = combination::plan(
      scene("brace", {"start.tip_angle=0", "gravity=[0, 9.81]", "target.position=[\"97 mm\", \"-20 mm\"]"}));
  ASSERT_TRUE(certified(upright));
  ASSERT_TRUE(certified(mirrored));
  EXPECT_NEAR(mirrored.objective, upright.objective, same * upright.objective);
  EXPECT_NEAR(mirrored.tip_y, -upright.tip_y, 1e-9);
}

}  // namespace
}  // namespace tendril::search
