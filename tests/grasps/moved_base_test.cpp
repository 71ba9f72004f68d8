// Fingers whose bases a plan may turn and move on the palm: what is chosen is what a gripper does that stands so.

#include <cmath>
#include <numbers>

#include "combination/support.hpp"
#include "tendril/execute.hpp"
#include "tendril/grasp.hpp"
#include "tendril/scale.hpp"

namespace tendril::grasps {
namespace {

using combination::certified;

constexpr double degree = std::numbers::pi / 180.0;

const std::vector<std::string> movable{"gripper.finger_angle_range=[\"-20 deg\", \"20 deg\"]",
                                       "gripper.half_palm_range=[\"15 mm\", \"30 mm\"]"};

Scene wrist(std::vector<std::string> more = {}) {
  more.insert(more.begin(), movable.begin(), movable.end());
  return combination::scene("grasp_60mm", more);
}

/// The scene with its fingers held where the plan has the upper one.
Scene held_at(Scene scene, const BasePose& upper) {
  GripperSpec& gripper = *scene.gripper;
  const Vec2 from_palm = upper.position - gripper.position;
  gripper.half_palm = std::cos(gripper.angle) * from_palm.y - std::sin(gripper.angle) * from_palm.x;
  gripper.finger_angle = upper.angle - gripper.angle;
  gripper.half_palm_range.reset();
  gripper.finger_angle_range.reset();
  return scene;
}

TEST(MovedFingers, AreChosenBetterThanFixedOnesByEverySolver) {
  const Plan fixed = combination::plan(combination::scene("grasp_60mm"));
  for (const std::string& solver : combination::solvers_to_combine()) {
    SCOPED_TRACE(solver);
    const Scene scene = wrist({"solver.plugin=" + solver});
    const Plan chosen = combination::plan(scene);
    ASSERT_TRUE(certified(chosen));
    ASSERT_TRUE(chosen.place.base);
    EXPECT_LT(chosen.objective, fixed.objective - 1e-6);
    const BasePose& base = *chosen.place.base;
    EXPECT_NEAR(base.position.x, 0.0, 1e-12);
    EXPECT_GE(base.position.y, 0.015 - 1e-10);
    EXPECT_LE(base.position.y, 0.03 + 1e-10);
    EXPECT_LE(std::abs(base.angle), 20.0 * degree + 1e-9);
    EXPECT_NEAR(chosen.contacts.front().force, 3.33, 1e-8);
    EXPECT_NEAR(chosen.grasp->axial_force, 0.0, 1e-8);
    // Held there it is a plan of the gripper that stands so, which is no better.
    const Plan held = combination::plan(held_at(scene, base));
    ASSERT_TRUE(certified(held));
    EXPECT_NEAR(held.objective, chosen.objective, 1e-8);
    EXPECT_NEAR(held.grasp->palm_distance, chosen.grasp->palm_distance, 1e-5);
  }
}

TEST(MovedFingers, AreCarriedOutWhereTheyWereMovedTo) {
  const Scene scene = wrist({"gripper.position=[\"40 mm\", \"-10 mm\"]", "gripper.angle=\"0.7 rad\""});
  Plan chosen = combination::plan(scene);
  ASSERT_TRUE(certified(chosen));
  const Vec2 from_palm = chosen.place.base->position - Vec2{0.04, -0.01};
  EXPECT_NEAR(std::cos(0.7) * from_palm.x + std::sin(0.7) * from_palm.y, 0.0, 1e-12);
  EXPECT_NEAR(norm(chosen.place.base->position - chosen.backbone.front().position()), 0.0, 1e-12);
  EXPECT_NEAR(chosen.place.base->angle, chosen.backbone.front().angle, 1e-12);
  // Turned as a whole it is the same grasp.
  EXPECT_NEAR(chosen.objective, combination::plan(wrist()).objective, 1e-9);
  const ExecuteControl from_itself{.start = &chosen};
  const Execution settled =
      verify(finger_in_world(scene), obstacles_of_finger(scene, chosen.grasp->palm_distance), chosen, from_itself);
  EXPECT_TRUE(certified(chosen));
  EXPECT_TRUE(certified(settled.result));
  EXPECT_LT(*chosen.model_error, 1e-5 * scene.rod.length());
  // Where the base stood before, these moments do not hold it so.
  ExecuteControl elsewhere = from_itself;
  elsewhere.place.base = {palm_to_world(*scene.gripper, {0.0, scene.gripper->half_palm}), scene.gripper->angle};
  const Execution back =
      execute(finger_in_world(scene), obstacles_of_finger(scene, chosen.grasp->palm_distance), chosen, elsewhere);
  EXPECT_GT(std::hypot(back.result.tip_x - chosen.tip_x, back.result.tip_y - chosen.tip_y), 1e-3);
}

TEST(MovedFingers, BothPlannedAreTheMirroredOne) {
  const Scene one = wrist();
  const Plan mirrored_plan = combination::plan(one);
  ASSERT_TRUE(certified(mirrored_plan));
  Scene both = one;
  both.gripper->fingers = Fingers::both;
  Plan pair = combination::plan(both);
  ASSERT_TRUE(certified(pair));
  ASSERT_TRUE(pair.place.base && pair.grasp->lower->place.base);
  EXPECT_NEAR(pair.objective, 2.0 * mirrored_plan.objective, 1e-6);
  const BasePose& below = *pair.grasp->lower->place.base;
  EXPECT_LE(below.position.y, -0.015 + 1e-10);
  EXPECT_NEAR(norm(below.position - pair.grasp->lower->backbone.front().position()), 0.0, 1e-12);
  EXPECT_NEAR(below.angle, pair.grasp->lower->backbone.front().angle, 1e-12);
  verify_both_fingers(both, pair, {.start = &pair});
  EXPECT_TRUE(certified(pair));
  EXPECT_LT(*pair.model_error, 1e-5 * both.rod.length());
  // An earlier plan is a start, with its bases.
  PlanControl again;
  again.start = &pair;
  const Plan warm = combination::plan(both, again);
  ASSERT_TRUE(certified(warm));
  EXPECT_NEAR(warm.objective, pair.objective, 1e-8);
}

TEST(MovedFingers, ThatDifferTurnEachByItself) {
  Scene scene = combination::scene("grasp_unequal");
  const Plan fixed = combination::plan(scene);
  ASSERT_TRUE(certified(fixed));
  for (FingerSpec& finger : scene.fingers) {
    finger.finger_angle_range = {finger.finger_angle - 10.0 * degree, finger.finger_angle + 10.0 * degree};
  }
  const Plan chosen = combination::plan(scene);
  ASSERT_TRUE(certified(chosen));
  EXPECT_LT(chosen.objective, fixed.objective - 1e-9);
  EXPECT_LE(chosen.certificate.balance, 1e-9);
  const double upper = chosen.place.base->angle - scene.gripper->angle;
  const double lower = scene.gripper->angle - chosen.grasp->lower->place.base->angle;
  EXPECT_LE(std::abs(upper - scene.fingers[0].finger_angle), 10.0 * degree + 1e-9);
  EXPECT_LE(std::abs(lower - scene.fingers[1].finger_angle), 10.0 * degree + 1e-9);
  EXPECT_GT(std::abs(upper - lower), 1e-3);
}

TEST(MovedFingers, AreCountedByDescribe) {
  for (const Fingers fingers : {Fingers::mirrored, Fingers::both}) {
    Scene scene = wrist();
    scene.gripper->fingers = fingers;
    int moved = 0;
    for (const Description::Count& variable : combination::problem(scene).describe().variables) {
      if (variable.name == "base") moved = variable.count;
    }
    EXPECT_EQ(moved, fingers == Fingers::both ? 4 : 2);
  }
}

}  // namespace
}  // namespace tendril::grasps
