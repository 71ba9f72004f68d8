// Grasps of one mirrored finger (model.md section 6): what a plan says of the grasp beside its shape, and the options.

#include "tendril/grasp.hpp"

#include <cmath>

#include "grasp_support.hpp"
#include "support/print.hpp"

namespace tendril::combination {
namespace {

TEST(Grasp, AlongGravityIsTheSameHoweverTheGripperIsTurned) {
  const std::vector<std::string> heavy{"rod.linear_density=\"80 g/m\""};
  Scene down = scene("grasp_60mm", heavy);
  down.gravity = Vec2{9.81, 0.0};
  const Plan first = plan(down);
  ASSERT_TRUE(certified(first));
  Scene turned = down;
  turned.gripper->angle = -1.2;
  turned.gravity = Vec2{9.81 * std::cos(1.2), -9.81 * std::sin(1.2)};
  const Plan second = plan(turned);
  ASSERT_TRUE(certified(second));
  for (std::size_t a = 0; a < 2; ++a) EXPECT_NEAR(second.moments[a], first.moments[a], 1e-8);
  // Across the axis one mirrored finger cannot stand for both.
  turned.gravity = Vec2{0.0, -9.81};
  turned.gripper->fingers = Fingers::mirrored;
  EXPECT_THROW(plan(turned), SceneError);
}

TEST(Grasp, QualityAgreesWithWhatExecutionDoes) {
  for (const double diameter : {0.02, 0.06}) {
    const Scene made = grasp_of_diameter(diameter, 3.33);
    const Plan found = plan(made);
    ASSERT_TRUE(certified(found));
    ASSERT_TRUE(found.grasp->quality);
    const GraspQuality& q = *found.grasp->quality;
    // One finger's force (axial, lateral) on the object by central differences of executed states.
    const auto force = [&](const std::vector<double>& moments, Vec2 moved) {
      const Execution done = carried_out(made, found, moments, moved);
      EXPECT_EQ(done.result.status, PlanStatus::solved) << done.result.message;
      Vec2 sum{};
      for (const PlannedContact& c : done.result.contacts) {
        if (c.obstacle == 0) sum += -c.force * c.normal;
      }
      return sum;
    };
    constexpr double step = 1e-5;
    const double along = (force(found.moments, {step, 0.0}).x - force(found.moments, {-step, 0.0}).x) / (2.0 * step);
    const double across = (force(found.moments, {0.0, step}).y - force(found.moments, {0.0, -step}).y) / (2.0 * step);
    EXPECT_NEAR(q.axial_stiffness, -2.0 * along, 1e-4 * (1.0 + std::abs(along)));
    EXPECT_NEAR(q.lateral_stiffness, -2.0 * across, 1e-4 * (1.0 + std::abs(across)));
    for (std::size_t a = 0; a < 2; ++a) {
      std::vector<double> more = found.moments;
      std::vector<double> less = found.moments;
      more[a] *= 1.001;
      less[a] *= 0.999;
      const Vec2 change = 5.0 * (force(more, {}) - force(less, {}));
      EXPECT_NEAR(q.force_by_moment[a].x, change.x, 1e-4);
      EXPECT_NEAR(q.force_by_moment[a].y, change.y, 1e-4);
    }
  }
}

// What the certificate says of a plan is found again without it: the sum of the forces of both fingers.
TEST(Grasp, NetForceIsTheSumOverBothFingers) {
  Scene made = scene("grasp_60mm");
  made.gripper->angle = 0.4;
  const Plan found = plan(made);
  ASSERT_TRUE(certified(found));
  Vec2 sum{};
  for (const PlannedContact& c : found.contacts) {
    const Vec2 end = mirrored(*made.gripper, c.point + c.normal) - mirrored(*made.gripper, c.point);
    sum += -c.force * (c.normal + end);
    EXPECT_NEAR(norm(c.point - found.grasp->object_center), found.grasp->object_radius, 1e-10);
  }
  EXPECT_NEAR(sum.x, found.grasp->net_force.x, 1e-12);
  EXPECT_NEAR(sum.y, found.grasp->net_force.y, 1e-12);
  EXPECT_LT(norm(sum), 1e-6);
}

// The paper's Fig. 5: less closing of the distal moment pushes the object away from the palm, more pulls it in.
TEST(Grasp, TheForceAlongTheAxisFollowsTheDistalMoment) {
  const Scene made = scene("grasp_60mm");
  const Plan found = plan(made);
  ASSERT_TRUE(certified(found));
  ASSERT_LT(found.moments[1], 0.0);
  const auto axial = [&](double change) {
    const Execution done = carried_out(made, found, {found.moments[0], found.moments[1] + change});
    EXPECT_EQ(done.result.status, PlanStatus::solved) << done.result.message;
    return grasp_of(made, found.grasp->palm_distance, done.result.contacts).axial_force;
  };
  EXPECT_NEAR(axial(0.0), 0.0, 1e-6);
  // About 0.012 N for each of the two fingers and 0.01 N m.
  EXPECT_NEAR(axial(0.01), 0.024, 0.005);
  EXPECT_NEAR(axial(-0.01), -0.024, 0.005);
}

TEST(Grasp, WithoutAnObjectiveForTheMomentsIsRefused) {
  Scene made = scene("grasp_60mm");
  made.objectives.pop_back();
  EXPECT_THROW(plan(made), SceneError);
}

TEST(Grasp, AnObjectiveCanSeeToTheBalanceInstead) {
  Scene made = scene("grasp_60mm", {"gripper.balance=objective"});
  ObjectiveSpec balance;
  balance.plugin = "grasp_balance";
  balance.weight = 1e3;
  made.objectives.push_back(balance);
  const Plan found = plan(made);
  ASSERT_TRUE(certified(found));
  EXPECT_LT(std::abs(found.grasp->axial_force), 0.1);
  EXPECT_GT(std::abs(found.grasp->axial_force), 0.0);
}

TEST(Grasp, AFixedPalmDistanceIsNoVariable) {
  const Plan free = plan(scene("grasp_60mm"));
  ASSERT_TRUE(certified(free));
  Scene fixed = scene("grasp_60mm");
  fixed.gripper->palm_distance = free.grasp->palm_distance;
  const Description described = problem(fixed).describe();
  for (const Description::Count& c : described.variables) EXPECT_NE(c.name, "palm_distance");
  const Plan found = plan(fixed);
  ASSERT_TRUE(certified(found));
  for (std::size_t a = 0; a < 2; ++a) EXPECT_NEAR(found.moments[a], free.moments[a], 1e-7);
}

}  // namespace
}  // namespace tendril::combination
