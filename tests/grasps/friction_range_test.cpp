// What friction can do to a grasp at its moments while the object is held where it is: each finger, executed on its own
// with the ratio of its contact, comes to the same state.

#include <algorithm>
#include <cmath>

#include "combination/grasp_support.hpp"
#include "support/contains.hpp"
#include "tendril/error.hpp"
#include "tendril/execute.hpp"
#include "tendril/grasp.hpp"
#include "tendril/tolerances.hpp"

namespace tendril::grasps {
namespace {

using combination::certified;

/// One finger of a state, executed with the ratio of its contact.
void expect_carried_out(const Scene& scene, const Plan& finger_plan, const PlannedContact& contact) {
  const Scene world = finger_in_world(scene);
  ExecuteControl control;
  control.start = &finger_plan;
  control.friction.assign(world.obstacles.size(), 0.0);
  control.friction[0] = contact.tangential / contact.force;
  const Execution e =
      execute(world, obstacles_of_finger(scene, finger_plan.grasp->palm_distance), finger_plan.moments, control);
  ASSERT_EQ(e.result.status, PlanStatus::solved) << e.result.message;
  ASSERT_EQ(e.result.contacts.size(), 1U);
  EXPECT_NEAR(e.result.contacts[0].force / contact.force, 1.0, 1e-6);
  EXPECT_NEAR(e.result.contacts[0].arc_length, contact.arc_length, 1e-8);
  EXPECT_NEAR(norm(e.result.contacts[0].point - contact.point), 0.0, 1e-8);
}

/// Seen as that of the lower finger's image.
PlannedContact image_of(const Scene& scene, PlannedContact c) {
  c.point = mirrored(*scene.gripper, c.point);
  return c;
}

/// Contacts of the plan without friction, and of each a ratio.
void expect_ratios(const Plan& plan, const std::vector<std::vector<double>>& expected) {
  ASSERT_EQ(plan.friction.size(), expected.size());
  for (std::size_t k = 0; k < expected.size(); ++k) {
    std::vector<double> found;
    for (const PlannedContact& c : plan.friction[k].contacts) found.push_back(c.tangential / c.force);
    ASSERT_EQ(found.size(), expected[k].size());
    for (std::size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(std::abs(found[i]), std::abs(expected[k][i]), 1e-12);
    EXPECT_EQ(plan.friction[k].ratios.size(), found.size());
    EXPECT_GT(plan.friction[k].stability, tolerance::stability);
  }
}

class GraspFrictionRange : public testing::TestWithParam<const char*> {};

TEST_P(GraspFrictionRange, OfMirroredFingersIsWhatEitherComesTo) {
  Scene made = combination::scene("grasp_60mm");
  made.solver.plugin = GetParam();
  const Plan without = combination::plan(made);
  EXPECT_TRUE(without.friction.empty());
  double wide = 0.0;
  for (const double mu : {0.05, 0.2}) {
    made.contact.friction = mu;
    const Plan plan = combination::plan(made);
    ASSERT_TRUE(certified(plan));
    EXPECT_EQ(plan.moments, without.moments);
    expect_ratios(plan, {{0.0}, {mu}, {mu}});
    EXPECT_NEAR(plan.friction[0].tip_x, plan.tip_x, 1e-9);
    EXPECT_NEAR(plan.friction[0].tip_y, plan.tip_y, 1e-9);
    EXPECT_LT(plan.friction[1].contacts[0].tangential * plan.friction[2].contacts[0].tangential, 0.0);
    for (const FrictionRange& state : plan.friction) expect_carried_out(made, plan, state.contacts[0]);
    const double now = std::abs(plan.friction[1].contacts[0].force - plan.friction[2].contacts[0].force);
    EXPECT_GT(now, wide);
    wide = now;
  }
}

INSTANTIATE_TEST_SUITE_P(Solvers, GraspFrictionRange, testing::Values("nlopt", "ipopt", "ceres"),
                         [](const auto& each) { return std::string(each.param); });

// Fingers that differ, and an object that is loaded across the axis: every pair of their states.
TEST(GraspFrictionRange, OfBothFingersIsEveryPairOfTheirStates) {
  Scene loaded = combination::scene("grasp_60mm");
  loaded.gravity = Vec2{0.0, -9.81};
  loaded.gripper->object_mass = 0.05;
  for (Scene made : {loaded, combination::scene("grasp_unequal")}) {
    made.contact.friction = 0.2;
    const Plan plan = combination::plan(made);
    ASSERT_TRUE(certified(plan));
    const double mu = 0.2;
    expect_ratios(plan,
                  {{0.0, 0.0}, {0.0, mu}, {0.0, mu}, {mu, 0.0}, {mu, mu}, {mu, mu}, {mu, 0.0}, {mu, mu}, {mu, mu}});
    EXPECT_NEAR(plan.friction[0].tip_x, plan.tip_x, 1e-8);
    EXPECT_NEAR(plan.friction[0].tip_y, plan.tip_y, 1e-8);
    const Scene upper = finger_of(made, FingerName::upper);
    const Scene lower = finger_of(made, FingerName::lower);
    const Plan above = plan_of_finger(upper, plan, FingerName::upper);
    const Plan below = plan_of_finger(lower, plan, FingerName::lower);
    for (const std::size_t k : {0, 4, 8}) {
      expect_carried_out(upper, above, plan.friction[k].contacts[0]);
      expect_carried_out(lower, below, image_of(made, plan.friction[k].contacts[1]));
    }
  }
}

// From the least to the largest coefficient: a grasp that gives way says how much it stands.
TEST(GraspFrictionRange, AGraspThatGivesWaySaysSo) {
  int refused = 0;
  for (const double mu : {1e-6, 1e-3, 1.0, 10.0}) {
    Scene made = combination::scene("grasp_60mm");
    made.contact.friction = mu;
    const Plan plan = combination::plan(made);
    if (plan.status == PlanStatus::solved) {
      EXPECT_EQ(plan.friction.size(), 3U) << mu;
      continue;
    }
    ++refused;
    EXPECT_EQ(plan.status, PlanStatus::unstable) << mu;
    EXPECT_TRUE(contains_text(plan.message, "under friction the plan holds up to ")) << plan.message;
    EXPECT_TRUE(plan.friction.empty());
    // What it holds it does hold.
    const std::string after = plan.message.substr(plan.message.find("up to ") + 6);
    made.contact.friction = mu * std::stod(after) * 0.99;
    EXPECT_EQ(combination::plan(made).status, PlanStatus::solved) << plan.message;
  }
  EXPECT_LT(refused, 3);
}

// All limits are kept in every state: the largest force of any of them is the limit.
TEST_P(GraspFrictionRange, WorstKeepsTheLimitOfForcesInEveryState) {
  Scene made = combination::scene("grasp_60mm");
  made.solver.plugin = GetParam();
  made.contact.friction = 0.1;
  const auto largest = [](const Plan& plan) {
    double most = 0.0;
    for (const FrictionRange& state : plan.friction) most = std::max(most, state.contacts[0].force);
    return most;
  };
  const Plan range = combination::plan(made);
  ASSERT_TRUE(certified(range));
  EXPECT_GT(largest(range), made.contact.max_force * (1.0 + 1e-6));
  EXPECT_TRUE(std::any_of(range.notes.begin(), range.notes.end(),
                          [](const std::string& n) { return contains_text(n, "more than its limit"); }));
  made.contact.friction_state = FrictionState::worst;
  const Plan worst = combination::plan(made);
  ASSERT_TRUE(certified(worst));
  ASSERT_EQ(worst.friction.size(), 3U);
  EXPECT_NEAR(largest(worst), made.contact.max_force, 1e-6);
  for (const FrictionRange& state : worst.friction) expect_carried_out(made, worst, state.contacts[0]);
  // Without friction the object is in balance.
  EXPECT_LT(std::abs(grasp_of(made, worst.grasp->palm_distance, worst.friction[0].contacts).axial_force), 1e-8);
  EXPECT_LT(worst.friction[0].contacts[0].force, made.contact.max_force);
  EXPECT_TRUE(worst.notes.empty());
}

TEST(GraspFrictionRange, WhatWorstIsNotForIsToldInWords) {
  const auto refusal = [](auto&& change) -> std::string {
    Scene made = combination::scene("grasp_60mm");
    made.contact.friction = 0.3;
    made.contact.friction_state = FrictionState::worst;
    change(made);
    try {
      combination::plan(made);
    } catch (const SceneError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_TRUE(
      contains_text(refusal([](Scene& s) { s.gripper->fingers = Fingers::both; }), "each other's mirror image"));
  EXPECT_TRUE(
      contains_text(refusal([](Scene& s) { s.gripper->exact_balance = false; }), "in balance without friction"));
}

}  // namespace
}  // namespace tendril::grasps
