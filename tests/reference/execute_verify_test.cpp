// Plans judged by what comes of them. The plans are made here, so that what is wrong with each is known.

#include <gtest/gtest.h>

#include <string>

#include "execute_support.hpp"
#include "support/contains.hpp"
#include "support/print.hpp"
#include "tendril/tolerances.hpp"

namespace tendril::support {
namespace {

void expect_refused(const Plan& plan, const std::string& reason) {
  EXPECT_EQ(plan.status, PlanStatus::not_converged);
  EXPECT_TRUE(contains_text(plan.message, "execution does not confirm the plan"));
  EXPECT_TRUE(contains_text(plan.message, reason));
}

TEST(Verify, AnExactPlanHasNoModelError) {
  const ForwardScene s = unit_braced_arm();
  Plan plan = s.run({0.5}).result;
  verify(s.scene, s.obstacles, plan);
  EXPECT_EQ(plan.status, PlanStatus::solved);
  EXPECT_LE(plan.model_error.value(), 1e-9);
  EXPECT_LE(plan.local_model_error.value(), 1e-9);
}

TEST(Verify, FromThePlansOwnShapeIsOneExecutionAndSaysSo) {
  const ForwardScene s = unit_braced_arm();
  Plan plan = s.run({0.5}).result;
  plan.tip_y += 0.01;
  ExecuteControl control;
  control.start = &plan;
  verify(s.scene, s.obstacles, plan, control);
  EXPECT_NEAR(plan.model_error.value(), 0.01, 1e-8);
  EXPECT_EQ(plan.local_model_error, plan.model_error);
  EXPECT_EQ(plan.verification.find("settled from the plan's own shape"), 0U) << plan.verification;
  EXPECT_FALSE(contains_text(plan.verification, "loaded from the start"));
}

TEST(Verify, ReportsWhatACoarseBasisLeavesOut) {
  const ForwardScene s = unit_braced_arm();
  Plan plan = s.run({0.5}).result;
  plan.tip_y += 0.01;
  verify(s.scene, s.obstacles, plan);
  EXPECT_EQ(plan.status, PlanStatus::solved);
  EXPECT_NEAR(plan.model_error.value(), 0.01, 1e-8);
}

TEST(Verify, ATipBeyondTheToleranceTurnsTheVerdict) {
  const ForwardScene s = unit_braced_arm();
  Plan plan = s.run({0.5}).result;
  plan.tip_x -= 1.1 * tolerance::model_error;
  verify(s.scene, s.obstacles, plan);
  expect_refused(plan, "the tip ends elsewhere");
}

TEST(Verify, APlanOnTheOtherSideOfAPegTurnsTheVerdict) {
  ForwardScene s = unit_braced_arm();
  Plan plan = s.run({0.5}).result;
  s.scene.start_tip_angle = -1.0;  // below the peg
  verify(s.scene, s.obstacles, plan);
  expect_refused(plan, "the plan rests on the other side of 'circle 1' than execution does");
  EXPECT_LE(plan.local_model_error.value(), 1e-9);
}

TEST(Verify, APlanWithoutTheContactThatComesTurnsTheVerdict) {
  const ForwardScene s = unit_braced_arm();
  ForwardScene free;
  free.weight(1.682);
  Plan plan = free.run({0.5}).result;  // through the peg
  verify(s.scene, s.obstacles, plan);
  expect_refused(plan, "the plan rests on no obstacle, execution on 'circle 1'");
}

// At moment -0.1 an upright rod of weight 10 can lean either way.
TEST(Verify, AnotherBranchTurnsTheVerdict) {
  ForwardScene s = upright(10.0);
  s.scene.start_tip_angle = 1.0;
  const Execution leaning = s.run({2.0});
  Plan plan = s.run({-0.1}, &leaning.result).result;
  ASSERT_EQ(plan.status, PlanStatus::solved);
  s.scene.start_tip_angle = -1.0;
  verify(s.scene, s.obstacles, plan);
  expect_refused(plan, "the tip ends elsewhere");
  // Its own shape is an equilibrium all the same, and is said to be.
  EXPECT_LE(plan.local_model_error.value(), 1e-8);
}

TEST(Verify, AnExecutionThatDoesNotArriveTurnsTheVerdict) {
  ForwardScene s;
  s.circle(0.5, -0.6, 0.55);
  Plan plan = s.run({-1.0}).result;
  ASSERT_EQ(plan.status, PlanStatus::solved);
  plan.moments = {-6.0};
  verify(s.scene, s.obstacles, plan);
  expect_refused(plan, "contact spreads");
  EXPECT_FALSE(plan.model_error.has_value());
}

TEST(Verify, APlanThatWasNotSolvedKeepsItsVerdict) {
  const ForwardScene s = unit_braced_arm();
  Plan plan = s.run({0.5}).result;
  plan.status = PlanStatus::infeasible;
  plan.message = "out of reach";
  plan.tip_x -= 0.5;
  verify(s.scene, s.obstacles, plan);
  EXPECT_EQ(plan.status, PlanStatus::infeasible);
  EXPECT_EQ(plan.message, "out of reach");
  EXPECT_NEAR(plan.model_error.value(), 0.5, 1e-8);
}

}  // namespace
}  // namespace tendril::support
