// Grasps of objects that carry something, and grasps with tangential forces as variables: what is on the object is in
// balance, forces lie in their cones, and friction never costs anything.

#include <cmath>

#include "combination/grasp_support.hpp"
#include "support/contains.hpp"
#include "tendril/error.hpp"
#include "tendril/execute.hpp"
#include "tendril/grasp.hpp"

namespace tendril::grasps {
namespace {

using combination::certified;

/// What contacts and load leave on the object: force, and moment about its centre, from where its surface is touched.
struct Left {
  Vec2 force{};
  double moment = 0.0;
  double ratio = 0.0;  ///< the largest of tangential to normal forces
};

Left left_on_object(const Scene& scene, const Plan& plan, Vec2 load) {
  Left left{load};
  const GraspPlan& grasp = *plan.grasp;
  const auto add = [&](const PlannedContact& c, bool image) {
    Vec2 normal = c.normal;
    Vec2 force = -c.force * c.normal - c.tangential * c.tangent;
    if (image) {
      normal = mirrored(*scene.gripper, normal) - mirrored(*scene.gripper, {});
      force = mirrored(*scene.gripper, force) - mirrored(*scene.gripper, {});
    }
    EXPECT_NEAR(norm(c.tangent), 1.0, 1e-12);
    EXPECT_NEAR(dot(c.tangent, c.normal), 0.0, 1e-12);
    left.force += force;
    left.moment += cross(grasp.object_radius * normal, force);
    left.ratio = std::max(left.ratio, std::abs(c.tangential) / c.force);
  };
  for (const PlannedContact& c : plan.contacts) {
    add(c, false);
    if (!grasp.lower) add(c, true);
  }
  if (!grasp.lower) return left;
  for (const PlannedContact& c : grasp.lower->contacts) add(c, false);
  return left;
}

void expect_balance(const Scene& scene, const Plan& plan, Vec2 load) {
  const Left left = left_on_object(scene, plan, load);
  EXPECT_LT(norm(left.force), 1e-8);
  EXPECT_LT(std::abs(left.moment), 1e-9);
  EXPECT_LE(left.ratio, scene.contact.friction + 1e-9);
  EXPECT_LT(norm(plan.grasp->net_force), 1e-8);
  EXPECT_NEAR(norm(plan.grasp->load - load), 0.0, 1e-15);
}

/// Held from above: the axis points down.
Scene hanging(double mass, const std::vector<std::string>& overrides = {}) {
  Scene made = combination::scene("grasp_60mm", overrides);
  made.gravity = Vec2{0.0, -9.81};
  made.gripper->angle = -std::acos(0.0);
  made.gripper->object_mass = mass;
  return made;
}

/// Both fingers settled from the plan's own shape, with the ratios of the plan.
void expect_carried_out(const Scene& scene, Plan plan) {
  ExecuteControl control;
  control.start = &plan;
  if (plan.grasp->lower) {
    verify_both_fingers(scene, plan, control);
  } else {
    verify(finger_in_world(scene), obstacles_of_finger(scene, plan.grasp->palm_distance), plan, control);
  }
  EXPECT_EQ(plan.status, PlanStatus::solved) << plan.message;
  ASSERT_TRUE(plan.model_error);
  EXPECT_LT(*plan.model_error, 1e-7);
}

TEST(LoadedGrasp, AlongTheAxisIsHeldByContactsThatTilt) {
  const Scene made = hanging(0.05);
  const Plan plan = combination::plan(made);
  ASSERT_TRUE(certified(plan));
  expect_balance(made, plan, {0.0, -0.05 * 9.81});
  ASSERT_EQ(plan.contacts.size(), 1U);
  // Each finger carries half of the weight with the part of its force along the axis.
  const Vec2 down{0.0, -1.0};
  EXPECT_NEAR(plan.contacts[0].force * dot(plan.contacts[0].normal, down), 0.5 * 0.05 * 9.81, 1e-8);
  EXPECT_NEAR(plan.contacts[0].force, made.contact.max_force, 1e-6);
  // The same as a dead force.
  Scene pulled = hanging(0.0);
  pulled.gripper->object_force = {0.0, -0.05 * 9.81};
  const Plan same = combination::plan(pulled);
  ASSERT_TRUE(certified(same));
  for (std::size_t a = 0; a < 2; ++a) EXPECT_NEAR(same.moments[a], plan.moments[a], 1e-9);
}

TEST(LoadedGrasp, AcrossTheAxisIsHeldByBothFingers) {
  Scene made = combination::scene("grasp_60mm");
  made.gravity = Vec2{0.0, -9.81};
  made.gripper->object_mass = 0.05;
  ASSERT_TRUE(plans_both_fingers(made));
  const Plan plan = combination::plan(made);
  ASSERT_TRUE(certified(plan));
  expect_balance(made, plan, {0.0, -0.05 * 9.81});
  // The lower one presses harder, as hard as it may.
  EXPECT_NEAR(plan.grasp->lower->contacts[0].force, made.contact.max_force, 1e-6);
  EXPECT_LT(plan.contacts[0].force, made.contact.max_force);
}

TEST(LoadedGrasp, InAnyDirectionIsHeldWithFriction) {
  for (const double angle : {-2.5, 0.3, 2.0}) {
    Scene made = combination::scene("grasp_60mm");
    made.gripper->object_force = {0.5 * std::cos(angle), 0.5 * std::sin(angle)};
    made.contact.friction = 0.4;
    made.contact.friction_state = FrictionState::any;
    const Plan plan = combination::plan(made);
    ASSERT_TRUE(certified(plan)) << angle;
    expect_balance(made, plan, made.gripper->object_force);
    expect_carried_out(made, plan);
  }
}

TEST(LoadedGrasp, WhatIsTooHeavyIsToldInWords) {
  const Plan plan = combination::plan(hanging(1.0));
  EXPECT_EQ(plan.status, PlanStatus::infeasible);
  EXPECT_TRUE(contains_text(plan.message, "too heavy")) << plan.message;
  const auto refusal = [](auto&& change) -> std::string {
    Scene made = combination::scene("grasp_60mm");
    change(made);
    try {
      combination::plan(made);
    } catch (const SceneError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_TRUE(contains_text(refusal([](Scene& s) { s.gripper->object_mass = 0.1; }), "expected 'gravity'"));
  EXPECT_TRUE(contains_text(refusal([](Scene& s) { s.gripper->object_mass = -0.1; }), "must not be negative"));
  EXPECT_TRUE(contains_text(refusal([](Scene& s) {
                              s.gripper->object_force = {0.0, 1.0};
                              s.gripper->fingers = Fingers::mirrored;
                            }),
                            "mirrored fingers cannot balance"));
  EXPECT_TRUE(contains_text(refusal([](Scene& s) {
                              s.gripper->object_force = {1.0, 0.0};
                              s.gripper->exact_balance = false;
                            }),
                            "the object is loaded"));
  EXPECT_TRUE(
      contains_text(refusal([](Scene& s) { s.contact.friction_state = FrictionState::any; }), "without friction"));
  EXPECT_TRUE(contains_text(refusal([](Scene& s) { s.contact.friction = -1.0; }), "must not be negative"));
  EXPECT_TRUE(contains_text(refusal([](Scene& s) {
                              s.contact.friction = 0.3;
                              s.contact.friction_state = FrictionState::any;
                              s.coordinates.split_at_contact = false;
                            }),
                            "has a knot at its contact"));
}

class GraspFriction : public testing::TestWithParam<const char*> {};

TEST_P(GraspFriction, NeverCostsAnything) {
  const bool quick = std::string(GetParam()) == "nlopt";
  for (const double diameter : quick ? combination::diameters() : std::vector<double>{0.03, 0.06}) {
    for (const double limit : quick ? std::vector<double>{3.33, 10.0} : std::vector<double>{3.33}) {
      SCOPED_TRACE(std::to_string(diameter) + " m, " + std::to_string(limit) + " N");
      Scene made = combination::grasp_of_diameter(diameter, limit);
      made.solver.plugin = GetParam();
      const Plan without = combination::plan(made);
      made.contact.friction = 0.3;
      made.contact.friction_state = FrictionState::any;
      const Plan plan = combination::plan(made);
      ASSERT_TRUE(certified(without));
      ASSERT_TRUE(certified(plan));
      EXPECT_LT(plan.objective, without.objective);
      EXPECT_NEAR(plan.contacts[0].force, limit, 1e-6);
      expect_balance(made, plan, {});
      expect_carried_out(made, plan);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Solvers, GraspFriction, testing::Values("nlopt", "ipopt", "ceres"),
                         [](const auto& each) { return std::string(each.param); });

}  // namespace
}  // namespace tendril::grasps
