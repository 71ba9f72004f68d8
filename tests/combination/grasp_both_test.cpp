// Grasps of two fingers that are both planned: against the mirrored plan where one finger can stand for both, against
// their own mirror images, turned and in other units, and against what each finger does when its plan is carried out.

#include <algorithm>
#include <cmath>

#include "grasp_support.hpp"
#include "rod/self_overlap.hpp"
#include "support/contains.hpp"
#include "support/print.hpp"
#include "tendril/error.hpp"
#include "tendril/grasp.hpp"

namespace tendril::combination {
namespace {

/// Moments in N m, lengths in m, forces in N.
constexpr double same = 1e-8;

/// Every backend; under sanitizers, which are slow and look for other defects, the one that scenes plan with.
std::vector<std::string> solvers_of_pairs() {
#ifdef __SANITIZE_ADDRESS__
  return {scene("grasp_60mm").solver.plugin};
#else
  return registry().names(ComponentKind::solver);
#endif
}

FingerPlan upper_of(const Plan& plan) {
  return {plan.coordinates, plan.moments, plan.contacts,  plan.backbone,
          plan.tip_x,       plan.tip_y,   plan.tip_angle, plan.self_overlap};
}

/// The lower finger's place in a plan; fails the test if it was not planned.
FingerPlan lower_of(const Plan& plan) {
  EXPECT_TRUE(plan.grasp && plan.grasp->lower);
  return plan.grasp && plan.grasp->lower ? *plan.grasp->lower : FingerPlan{};
}

/// `map` takes a point of `expected` to where it should be in `found`.
template <class Map>
void expect_same_finger(const FingerPlan& found, const FingerPlan& expected, double tolerance, Map map) {
  ASSERT_EQ(found.moments.size(), expected.moments.size());
  for (std::size_t a = 0; a < found.moments.size(); ++a) EXPECT_NEAR(found.moments[a], expected.moments[a], tolerance);
  ASSERT_EQ(found.contacts.size(), 1U);
  ASSERT_EQ(expected.contacts.size(), 1U);
  EXPECT_EQ(found.contacts[0].at_tip, expected.contacts[0].at_tip);
  EXPECT_NEAR(found.contacts[0].arc_length, expected.contacts[0].arc_length, tolerance);
  EXPECT_NEAR(found.contacts[0].force, expected.contacts[0].force, tolerance);
  EXPECT_LT(norm(found.contacts[0].point - map(expected.contacts[0].point)), tolerance);
  ASSERT_EQ(found.backbone.size(), expected.backbone.size());
  for (std::size_t i = 0; i < found.backbone.size(); ++i) {
    const Vec2 there = map(expected.backbone[i].position());
    EXPECT_LT(norm(there - found.backbone[i].position()), tolerance);
  }
  EXPECT_LT(norm(Vec2{found.tip_x, found.tip_y} - map({expected.tip_x, expected.tip_y})), tolerance);
}

Vec2 unmoved(Vec2 p) { return p; }
Vec2 reflected(Vec2 p) { return {p.x, -p.y}; }

/// Two heavy fingers of the same kind, with gravity straight across the axis.
Scene across() {
  Scene made = scene("grasp_60mm", {"rod.linear_density=\"80 g/m\""});
  made.gravity = Vec2{0.0, -9.81};
  return made;
}

class BothFingers : public testing::TestWithParam<std::string> {
 protected:
  Plan planned(Scene made) const {
    made.solver.plugin = GetParam();
    return plan(made);
  }
};

INSTANTIATE_TEST_SUITE_P(Found, BothFingers, testing::ValuesIn(solvers_of_pairs()),
                         [](const testing::TestParamInfo<std::string>& of) { return of.param; });

TEST_P(BothFingers, AlikeWithoutGravityAreTheMirroredPlan) {
  for (const double diameter : {0.03, 0.06}) {
    SCOPED_TRACE(diameter);
    Scene made = grasp_of_diameter(diameter, 3.33);
    const Plan mirrored_plan = planned(made);
    made.gripper->fingers = Fingers::both;
    const Plan found = planned(made);
    ASSERT_TRUE(certified(mirrored_plan));
    ASSERT_TRUE(certified(found));
    EXPECT_FALSE(mirrored_plan.grasp->lower);
    EXPECT_NEAR(found.grasp->palm_distance, mirrored_plan.grasp->palm_distance, same);
    EXPECT_NEAR(found.objective, 2.0 * mirrored_plan.objective, same);
    expect_same_finger(upper_of(found), upper_of(mirrored_plan), same, unmoved);
    expect_same_finger(lower_of(found), upper_of(mirrored_plan), same, reflected);
    // The same of the grasp as a whole.
    const GraspQuality& q = *found.grasp->quality;
    const GraspQuality& expected = *mirrored_plan.grasp->quality;
    EXPECT_NEAR(q.axial_stiffness, expected.axial_stiffness, 1e-5 * std::abs(expected.axial_stiffness));
    EXPECT_NEAR(q.lateral_stiffness, expected.lateral_stiffness, 1e-5 * std::abs(expected.lateral_stiffness));
    EXPECT_NEAR(found.grasp->lateral_force, mirrored_plan.grasp->lateral_force, same);
    ASSERT_EQ(q.force_by_moment.size(), 4U);
    for (std::size_t a = 0; a < 2; ++a) {
      EXPECT_NEAR(q.force_by_moment[a].y, expected.force_by_moment[a].y, 1e-6);
      EXPECT_NEAR(q.force_by_moment[a + 2].y, -expected.force_by_moment[a].y, 1e-6);
      EXPECT_NEAR(q.force_by_moment[a + 2].x, expected.force_by_moment[a].x, 1e-6);
    }
  }
}

TEST_P(BothFingers, GravityTurnedRoundExchangesThem) {
  Scene made = across();
  const Plan down = planned(made);
  made.gravity = Vec2{0.0, 9.81};
  const Plan up = planned(made);
  ASSERT_TRUE(certified(down));
  ASSERT_TRUE(certified(up));
  EXPECT_NEAR(up.grasp->palm_distance, down.grasp->palm_distance, same);
  expect_same_finger(upper_of(up), lower_of(down), same, reflected);
  expect_same_finger(lower_of(up), upper_of(down), same, reflected);
  // They do not do the same.
  EXPECT_GT(std::abs(down.moments[0] - lower_of(down).moments[0]), 1e-4);
}

/// What two fingers that differ do in their plan.
void expect_held_without_net_force(const Plan& found) {
  const FingerPlan lower = lower_of(found);
  EXPECT_NEAR(found.contacts[0].force, 3.0, 1e-9);
  EXPECT_NEAR(lower.contacts[0].force, 3.0, 1e-9);
  const Vec2 net =
      -found.contacts[0].force * found.contacts[0].normal - lower.contacts[0].force * lower.contacts[0].normal;
  EXPECT_LT(norm(net), 1e-9);
  EXPECT_LT(norm(found.grasp->net_force), 1e-9);
  for (const PlannedContact& c : {found.contacts[0], lower.contacts[0]})
    EXPECT_NEAR(norm(c.point - found.grasp->object_center), found.grasp->object_radius, 1e-10);
  for (const BackbonePoint& p : found.backbone) {
    for (const BackbonePoint& q : lower.backbone) EXPECT_GT(std::hypot(p.x - q.x, p.y - q.y), 1e-3);
  }
  // Lengths are their own, bases stand on one palm. Data are rounded to twelve digits.
  EXPECT_NEAR(found.backbone.back().s, 0.12, 1e-12);
  EXPECT_NEAR(lower.backbone.back().s, 0.09, 1e-12);
  EXPECT_NEAR(found.backbone.front().y, 0.02, 1e-12);
  EXPECT_NEAR(lower.backbone.front().y, -0.02, 1e-12);
}

/// The same scene with the fingers exchanged.
Scene exchanged(Scene made) {
  std::swap(made.fingers[0], made.fingers[1]);
  made.gravity = Vec2{made.gravity->x, -made.gravity->y};
  return made;
}

Scene turned(Scene made, double angle) {
  made.gripper->angle = angle;
  made.gripper->position = {0.3, -0.2};
  made.gravity = Vec2{9.81 * std::sin(angle), -9.81 * std::cos(angle)};
  return made;
}

/// "grasp_unequal" once more.
Scene in_other_units() {
  return scene("grasp_unequal",
               {"gripper.half_palm=\"0.787401574803150 inch\"", "gripper.object_diameter=\"5 cm\"",
                "rod.length=\"3.93700787401575 inch\"", "rod.bending_stiffness=\"3.48454559076413 lbf inch^2\"",
                "finger.0.length=\"0.12 m\"", "finger.0.bending_stiffness=\"6e3 N mm^2\"",
                "finger.1.length=\"3.54330708661417 inch\"", "finger.1.rest_curvature=\"-0.002 1/mm\"",
                "finger.1.max_force=\"3000 mN\"", "rod.linear_density=\"0.12 kg/m\""});
}

// One test, so that what the others are compared with is planned once.
TEST_P(BothFingers, ThatDifferAreTheSamePlanExchangedTurnedAndInOtherUnits) {
  const Scene made = scene("grasp_unequal");
  const Plan original = planned(made);
  ASSERT_TRUE(certified(original));
  expect_held_without_net_force(original);

  const Plan mirrored = planned(exchanged(made));
  ASSERT_TRUE(certified(mirrored));
  EXPECT_NEAR(mirrored.objective, original.objective, same);
  EXPECT_NEAR(mirrored.grasp->palm_distance, original.grasp->palm_distance, same);
  expect_same_finger(upper_of(mirrored), lower_of(original), same, reflected);
  expect_same_finger(lower_of(mirrored), upper_of(original), same, reflected);

  const Scene elsewhere = turned(made, -2.5);
  const auto there = [&](Vec2 p) { return palm_to_world(*elsewhere.gripper, p); };
  const Plan moved = planned(elsewhere);
  ASSERT_TRUE(certified(moved));
  EXPECT_NEAR(moved.grasp->palm_distance, original.grasp->palm_distance, same);
  expect_same_finger(upper_of(moved), upper_of(original), same, there);
  expect_same_finger(lower_of(moved), lower_of(original), same, there);

  const Plan converted = planned(in_other_units());
  ASSERT_TRUE(certified(converted));
  EXPECT_NEAR(converted.grasp->palm_distance, original.grasp->palm_distance, same);
  expect_same_finger(upper_of(converted), upper_of(original), same, unmoved);
  expect_same_finger(lower_of(converted), lower_of(original), same, unmoved);
}

// The rows that keep them apart: as long as the fingers are alike their tips meet on the axis, as a mirrored finger's
// tip does.
TEST_P(BothFingers, KeepTheirTipsFromCrossing) {
  const std::vector<std::string> crossing{"gripper.object_diameter=\"31.1 mm\"", "gripper.half_palm=\"6.4 mm\"",
                                          "gripper.finger_angle=\"0.77 rad\"",   "rod.actuator.0.to=\"30 mm\"",
                                          "rod.actuator.1.from=\"30 mm\"",       "contact.max_force=\"13.96 N\""};
  Scene made = scene("grasp_60mm", crossing);
  const Plan mirrored_plan = planned(made);
  made.gripper->fingers = Fingers::both;
  const Plan found = planned(made);
  ASSERT_TRUE(certified(mirrored_plan));
  ASSERT_TRUE(certified(found));
  EXPECT_NEAR(found.objective, 2.0 * mirrored_plan.objective, same);
  // The tips lean against each other, so the row does something.
  EXPECT_LT(std::hypot(found.tip_x - lower_of(found).tip_x, found.tip_y - lower_of(found).tip_y), same);
}

// Fingers that differ meet off the axis. What is proven of the curves holds for the chords of their samples too.
TEST_P(BothFingers, KeepUnequalOnesFromCrossing) {
  const Plan found = planned(scene(
      "grasp_unequal",
      {"finger.0.length=\"135.6 mm\"", "finger.1.length=\"93.3 mm\"", "finger.0.angle=0.747", "finger.1.angle=0.802",
       "rod.actuator.0.to=\"40.2 mm\"", "rod.actuator.1.from=\"40.2 mm\"", "gravity=[9.777, -0.806]",
       "gripper.object_diameter=\"36.57 mm\"", "gripper.half_palm=\"8.63 mm\"", "finger.1.max_force=\"7.89 N\"",
       "contact.max_force=\"8.41 N\"", "finger.0.bending_stiffness=0.01", "finger.1.bending_stiffness=0.01"}));
  ASSERT_TRUE(certified(found));
  const FingerPlan lower = lower_of(found);
  EXPECT_FALSE(meeting_of(found.backbone, lower.backbone));
  double nearest = infinity;
  for (const BackbonePoint& p : found.backbone) {
    for (const BackbonePoint& q : lower.backbone) nearest = std::min(nearest, std::hypot(p.x - q.x, p.y - q.y));
  }
  // As near as samples a millimetre apart can tell: the row that keeps them apart does something.
  EXPECT_LT(nearest, 5e-4);
}

// What each finger does when its moments are applied, the object held where the plan has it: the second computation.
TEST(BothFingersCarriedOut, ComeToRestWhereTheyWerePlanned) {
  for (const Scene& made : {scene("grasp_unequal"), across()}) {
    const Plan found = plan(made);
    ASSERT_TRUE(certified(found));
    for (const FingerName name : {FingerName::upper, FingerName::lower}) {
      SCOPED_TRACE(to_string(name));
      const Scene own = finger_of(made, name);
      Plan one = plan_of_finger(made, found, name);
      ExecuteControl control;
      control.start = &one;
      const Execution done =
          verify(finger_in_world(own), obstacles_of_finger(own, found.grasp->palm_distance), one, control);
      EXPECT_EQ(done.result.status, PlanStatus::solved) << done.result.message;
      ASSERT_TRUE(one.model_error);
      // What six functions per piece leave out of the long finger.
      EXPECT_LT(*one.model_error, 1e-6);
      double force = 0.0;
      for (const PlannedContact& c : done.result.contacts) force += c.force;
      EXPECT_NEAR(force, one.contacts[0].force, 1e-4);
    }
  }
}

// Stiffnesses and what moments do, by central differences of executed states of both fingers.
TEST(BothFingersQuality, AgreesWithWhatExecutionDoes) {
  const Scene made = scene("grasp_unequal");
  const Plan found = plan(made);
  ASSERT_TRUE(certified(found));
  ASSERT_TRUE(found.grasp->quality);
  const GraspQuality& q = *found.grasp->quality;
  std::vector<double> moments = found.moments;
  const FingerPlan lower = lower_of(found);
  moments.insert(moments.end(), lower.moments.begin(), lower.moments.end());
  // Net force on the object, moved by `moved`: the palm moves the other way.
  const auto force = [&](const std::vector<double>& applied, Vec2 moved) {
    Vec2 sum{};
    for (const FingerName name : {FingerName::upper, FingerName::lower}) {
      const bool above = name == FingerName::upper;
      const Scene own = finger_of(made, name);
      Scene there = own;
      there.gripper->position = Vec2{} - (above ? moved : reflected(moved));
      const Plan one = plan_of_finger(made, found, name);
      ExecuteControl control;
      control.start = &one;
      const std::vector<double> part(applied.begin() + (above ? 0 : 2), applied.begin() + (above ? 2 : 4));
      const Execution done =
          execute(finger_in_world(there), obstacles_of_finger(own, found.grasp->palm_distance), part, control);
      EXPECT_EQ(done.result.status, PlanStatus::solved) << done.result.message;
      for (const PlannedContact& c : done.result.contacts) {
        const Vec2 push = -c.force * c.normal;
        sum += above ? push : reflected(push);
      }
    }
    return sum;
  };
  constexpr double step = 1e-5;
  const double along = (force(moments, {step, 0.0}).x - force(moments, {-step, 0.0}).x) / (2.0 * step);
  const double across = (force(moments, {0.0, step}).y - force(moments, {0.0, -step}).y) / (2.0 * step);
  EXPECT_NEAR(q.axial_stiffness, -along, 1e-4 * (1.0 + std::abs(along)));
  EXPECT_NEAR(q.lateral_stiffness, -across, 1e-4 * (1.0 + std::abs(across)));
  ASSERT_EQ(q.force_by_moment.size(), 4U);
  for (std::size_t a = 0; a < 4; ++a) {
    std::vector<double> more = moments;
    std::vector<double> less = moments;
    more[a] *= 1.001;
    less[a] *= 0.999;
    const Vec2 change = 5.0 * (force(more, {}) - force(less, {}));
    EXPECT_NEAR(q.force_by_moment[a].x, change.x, 1e-5);
    EXPECT_NEAR(q.force_by_moment[a].y, change.y, 1e-5);
  }
}

TEST(BothFingersRefused, WithTheReason) {
  const auto refused = [](const Scene& made, const std::string& path, const std::string& reason) {
    try {
      plan(made);
      ADD_FAILURE() << "was not refused: " << reason;
    } catch (const SceneError& error) {
      EXPECT_EQ(error.path(), path);
      EXPECT_TRUE(contains_text(std::string(error.what()), reason)) << error.what();
    }
  };
  Scene mirrored_across = across();
  mirrored_across.gripper->fingers = Fingers::mirrored;
  refused(mirrored_across, "gravity", "gravity has a component across the axis");
  Scene unequal = scene("grasp_unequal");
  unequal.gripper->fingers = Fingers::mirrored;
  refused(unequal, "gripper.fingers", "planned one by one");
  unequal = scene("grasp_unequal");
  unequal.fingers.pop_back();
  refused(unequal, "finger", "expected two");
  refused(scene("grasp_unequal", {"contact.count=2"}), "contact.count", "expected 1");
  refused(scene("grasp_unequal", {"coordinates.split_at_contact=false"}), "coordinates.split_at_contact",
          "expected true");
  refused(scene("grasp_unequal", {"gripper.balance=objective"}), "gripper.balance", "expected \"exact\"");
  refused(scene("grasp_unequal", {"finger.0.min_force=\"3.2 N\""}), "contact.min_force", "equally hard");
  unequal = scene("grasp_unequal");
  ObjectiveSpec balance;
  balance.plugin = "grasp_balance";
  unequal.objectives.push_back(balance);
  refused(unequal, "objective[2].plugin", "mirror image, but both fingers are planned");
  unequal = scene("grasp_unequal");
  unequal.fingers[1].rod.actuators[0].to = 0.2;
  refused(unequal, "finger[1].actuator[0].to", "the actuator ends at 0.2 m");
}

TEST(BothFingersInfeasible, SayWhatBinds) {
  const Plan large = plan(scene("grasp_unequal", {"gripper.object_diameter=\"300 mm\""}));
  EXPECT_EQ(large.status, PlanStatus::infeasible) << large.message;
  EXPECT_TRUE(contains_text(large.message, "too large"));
}

}  // namespace
}  // namespace tendril::combination
