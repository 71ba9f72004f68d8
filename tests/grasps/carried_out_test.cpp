// Grasps of two fingers that are carried out: each finger on its own, and what is said of both.

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "combination/support.hpp"
#include "tendril/error.hpp"
#include "tendril/execute.hpp"
#include "tendril/grasp.hpp"

namespace tendril::grasps {
namespace {

using combination::certified;

/// The scene and its plan, with the moments of both fingers.
struct Planned {
  /// `soft`: which finger is the long soft one.
  explicit Planned(FingerName soft = FingerName::upper) : scene(combination::scene("grasp_unequal")) {
    if (soft == FingerName::lower) {
      std::swap(scene.fingers[0], scene.fingers[1]);
      scene.gravity = Vec2{scene.gravity->x, -scene.gravity->y};
    }
    Problem problem = combination::problem(scene);
    PlanControl control;
    // The pair of ways of touching that wins.
    for (const Description::Mode& mode : problem.describe().modes) {
      if (mode.name.find("segment 1") != std::string::npos || mode.name.find("tip") != std::string::npos)
        control.without.push_back(mode.name);
    }
    plan = problem.plan(control);
    EXPECT_TRUE(certified(plan));
    moments = plan.moments;
    moments.insert(moments.end(), plan.grasp->lower->moments.begin(), plan.grasp->lower->moments.end());
  }
  Execution executed(const std::vector<double>& applied, ExecuteControl control = {}) const {
    if (control.start == nullptr) control.start = &plan;
    return execute_both_fingers(scene, plan.grasp->palm_distance, applied, control);
  }
  Execution alone(FingerName name, const std::vector<double>& part) const {
    const Scene own = finger_of(scene, name);
    const Plan one = plan_of_finger(scene, plan, name);
    ExecuteControl control;
    control.start = &one;
    return execute(finger_in_world(own), obstacles_of_finger(own, plan.grasp->palm_distance), part, control);
  }

  Scene scene;
  Plan plan;
  std::vector<double> moments;
};

TEST(BothFingersExecution, IsThatOfEachFingerAlone) {
  const Planned planned;
  const Execution both = planned.executed(planned.moments);
  const Execution upper = planned.alone(FingerName::upper, {planned.moments[0], planned.moments[1]});
  const Execution lower = planned.alone(FingerName::lower, {planned.moments[2], planned.moments[3]});
  EXPECT_TRUE(certified(both.result));
  EXPECT_EQ(both.load, std::min(upper.load, lower.load));
  EXPECT_EQ(both.steps, upper.steps + lower.steps);
  EXPECT_EQ(both.pieces, upper.pieces + lower.pieces);
  EXPECT_EQ(both.contact_changes, upper.contact_changes + lower.contact_changes);
  const Certificate& c = both.result.certificate;
  EXPECT_EQ(c.equilibrium, std::max(upper.result.certificate.equilibrium, lower.result.certificate.equilibrium));
  EXPECT_EQ(c.stability, std::min(upper.result.certificate.stability, lower.result.certificate.stability));
  EXPECT_EQ(c.moment_balance,
            std::max(upper.result.certificate.moment_balance, lower.result.certificate.moment_balance));
  EXPECT_EQ(both.result.tip_y, upper.result.tip_y);
  // The lower finger is computed in its mirror image.
  EXPECT_EQ(both.result.grasp->lower->tip_x, lower.result.tip_x);
  EXPECT_EQ(both.result.grasp->lower->tip_y, -lower.result.tip_y);
  // No force is left on the object, but for what six functions per piece leave out.
  EXPECT_LT(norm(both.result.grasp->net_force), 1e-4);
  EXPECT_NEAR(both.result.grasp->lateral_force, planned.plan.grasp->lateral_force, 1e-4);
}

TEST(BothFingersExecution, NetForceIsTheSumOfWhatTheContactsPush) {
  const Planned planned;
  std::vector<double> more = planned.moments;
  more[1] *= 1.02;
  const Execution done = planned.executed(more);
  ASSERT_TRUE(certified(done.result));
  Vec2 sum{};
  for (const PlannedContact& c : done.result.contacts) sum += -c.force * c.normal;
  for (const PlannedContact& c : done.result.grasp->lower->contacts) sum += -c.force * c.normal;
  EXPECT_GT(norm(sum), 1e-3);
  EXPECT_NEAR(done.result.grasp->net_force.x, sum.x, 1e-12);
  EXPECT_NEAR(done.result.grasp->net_force.y, sum.y, 1e-12);
  EXPECT_NEAR(done.result.grasp->axial_force, sum.x, 1e-12);
}

TEST(BothFingersExecution, WithoutOneMomentForEachActuatorIsRefused) {
  const Planned planned;
  for (const std::size_t count : {0, 2, 3, 5}) {
    try {
      planned.executed(std::vector<double>(count, 0.0));
      ADD_FAILURE() << count << " moments were taken";
    } catch (const Error& error) {
      EXPECT_EQ(std::string(error.what()),
                "found " + std::to_string(count) + " moments, expected one for each of the fingers' 4 actuators");
    }
  }
}

TEST(BothFingersExecution, FingersThatCrossAreNotConverged) {
  // Without an object between them both close past the axis.
  Planned planned;
  Scene made = planned.scene;
  made.gripper->object_diameter = 1e-3;
  const std::vector<double> closing{-0.15, -0.15, -0.35, -0.35};
  const Execution done = execute_both_fingers(made, 0.3, closing);
  EXPECT_EQ(to_string(done.result.status), "not_converged") << done.result.message;
  EXPECT_EQ(done.result.message, "the fingers cross each other: contact between them is not computed");
}

TEST(BothFingersExecution, AStopInterruptsAndNamesTheFinger) {
  const Planned planned;
  const std::atomic<bool> stop{true};
  ExecuteControl control;
  control.stop = &stop;
  const Execution done = planned.executed(planned.moments, control);
  EXPECT_EQ(to_string(done.result.status), "interrupted") << done.result.message;
  EXPECT_EQ(done.result.message.find("upper finger: "), 0U) << done.result.message;
}

// A finger whose chamber is pumped up curls until it lies along the object, where no point contact holds it.
TEST(BothFingersExecution, AFingerThatIsNotSolvedIsNamedWhicheverItIs) {
  for (const std::size_t which : {0, 1}) {
    const Planned planned(which == 0 ? FingerName::upper : FingerName::lower);
    std::vector<double> pumped = planned.moments;
    pumped[2 * which + 1] = -1.0;
    const Execution done = planned.executed(pumped);
    const Execution one =
        planned.alone(which == 0 ? FingerName::upper : FingerName::lower, {pumped[2 * which], pumped[2 * which + 1]});
    ASSERT_FALSE(one.result.status == PlanStatus::solved) << which;
    const std::string name = which == 0 ? "upper finger: " : "lower finger: ";
    EXPECT_EQ(to_string(done.result.status), to_string(one.result.status));
    EXPECT_EQ(done.result.message, name + one.result.message);
    EXPECT_EQ(done.load, std::min(1.0, one.load));
  }
}

TEST(BothFingersVerification, IsTheWorseOfBothAndOnlyOfPlansOfBoth) {
  const Planned planned;
  Plan plan = planned.plan;
  verify_both_fingers(planned.scene, plan);
  EXPECT_TRUE(certified(plan));
  std::array<double, 2> errors{};
  for (const FingerName name : {FingerName::upper, FingerName::lower}) {
    const Scene own = finger_of(planned.scene, name);
    Plan one = plan_of_finger(planned.scene, planned.plan, name);
    ExecuteControl control;
    control.start = &one;
    verify(finger_in_world(own), obstacles_of_finger(own, planned.plan.grasp->palm_distance), one, control);
    ASSERT_TRUE(one.model_error);
    errors[name == FingerName::upper ? 0 : 1] = *one.model_error;
  }
  ASSERT_TRUE(plan.model_error);
  EXPECT_NE(errors[0], errors[1]);
  EXPECT_EQ(*plan.model_error, std::max(errors[0], errors[1]));
  EXPECT_EQ(plan.verification.find("upper finger: "), 0U) << plan.verification;
  EXPECT_NE(plan.verification.find("; lower finger: "), std::string::npos) << plan.verification;
  Plan alone = planned.plan;
  alone.grasp->lower.reset();
  EXPECT_THROW(verify_both_fingers(planned.scene, alone), Error);
}

// A plan whose moments are not those of its shape is not confirmed, whichever finger they are of.
TEST(BothFingersVerification, AMomentThatIsNotThatOfTheShapeIsRefused) {
  const Planned planned;
  for (const std::size_t which : {0, 1}) {
    SCOPED_TRACE(which == 0 ? "upper" : "lower");
    Plan plan = planned.plan;
    std::vector<double>& moments = which == 0 ? plan.moments : plan.grasp->lower->moments;
    for (double& u : moments) u *= -2.0;
    verify_both_fingers(planned.scene, plan);
    EXPECT_EQ(to_string(plan.status), "not_converged");
    EXPECT_EQ(plan.message.find(which == 0 ? "upper finger: " : "lower finger: "), 0U) << plan.message;
  }
}

// How far each contact is from the limit of its own finger: here the lower one's is the smaller, so it is reached.
TEST(GraspQuality, ForceMarginsAreThoseOfEachFingersOwnLimit) {
  const Planned planned;
  const std::vector<double>& margins = planned.plan.grasp->quality->force_margins;
  ASSERT_EQ(margins.size(), 2U);
  EXPECT_NEAR(margins[0], planned.scene.contact.max_force - planned.plan.contacts[0].force, 1e-12);
  EXPECT_NEAR(margins[0], 0.33, 1e-8);
  EXPECT_NEAR(margins[1], 0.0, 1e-8);
  const Plan mirrored = combination::plan(combination::scene("grasp_60mm", {"contact.max_force=\"2 N\""}));
  ASSERT_TRUE(certified(mirrored));
  ASSERT_EQ(mirrored.grasp->quality->force_margins.size(), 1U);
  EXPECT_NEAR(mirrored.grasp->quality->force_margins[0], 2.0 - mirrored.contacts[0].force, 1e-12);
}

// A moment that is 0 by its limit changes nothing by a hundredth of it.
TEST(GraspQuality, AMomentThatIsNoVariableChangesNoForce) {
  Scene made = combination::scene("grasp_60mm", {"gripper.object_diameter=\"45 mm\"", "rod.actuator.1.limit=0"});
  const Plan found = combination::plan(made);
  ASSERT_TRUE(certified(found));
  const GraspQuality& quality = *found.grasp->quality;
  ASSERT_EQ(quality.force_by_moment.size(), 2U);
  EXPECT_EQ(norm(quality.force_by_moment[1]), 0.0);
  EXPECT_GT(norm(quality.force_by_moment[0]), 1e-3);
}

}  // namespace
}  // namespace tendril::grasps
