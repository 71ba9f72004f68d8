// Grasps at their limits (model.md section 6): every diameter by every solver with the force at its limit, the same
// grasp written in other ways, what keeps the fingers apart, and what cannot be held.

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "grasp_support.hpp"
#include "support/contains.hpp"
#include "support/print.hpp"
#include "tendril/app/report.hpp"
#include "tendril/app/result.hpp"
#include "tendril/error.hpp"
#include "tendril/grasp.hpp"

namespace tendril::combination {
namespace {

std::vector<std::string> solvers() { return registry().names(ComponentKind::solver); }

/// What coordinates leave out of a finger that 0.7 N m bend by two radians, m. Three functions per piece: 2e-5 m at the
/// worst; six: 6e-9 m.
struct Basis {
  const char* plugin;
  double model_error;
  double axial_force;  ///< N, that execution leaves along the axis at 10 N (docs/grasps.md)
};
constexpr Basis three_per_segment{"psc", 1e-4, 0.011};
constexpr Basis six_split{"legendre", 1e-7, 3.2e-6};

Scene with_basis(Scene made, const Basis& basis) {
  // The scene's own options are those of its own plugin.
  if (made.coordinates.plugin != basis.plugin) made.coordinates.options.clear();
  made.coordinates.plugin = basis.plugin;
  return made;
}

std::string text_of_scene() {
  const std::ifstream file(std::string(TENDRIL_SCENES) + "/grasp_60mm.toml");
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

/// Every occurrence; fails the test if there is none.
std::string replaced(std::string text, const std::string& from, const std::string& to) {
  std::size_t at = text.find(from);
  EXPECT_TRUE(contains_text(text, from));
  for (; at != std::string::npos; at = text.find(from, at + to.size())) text.replace(at, from.size(), to);
  return text;
}

void expect_same_plan(const Plan& plan, const Plan& expected, double tolerance) {
  EXPECT_NEAR(plan.grasp->palm_distance, expected.grasp->palm_distance, tolerance);
  ASSERT_EQ(plan.moments.size(), expected.moments.size());
  for (std::size_t a = 0; a < plan.moments.size(); ++a) EXPECT_NEAR(plan.moments[a], expected.moments[a], tolerance);
  ASSERT_EQ(plan.contacts.size(), expected.contacts.size());
  for (std::size_t k = 0; k < plan.contacts.size(); ++k) {
    EXPECT_EQ(plan.contacts[k].at_tip, expected.contacts[k].at_tip);
    EXPECT_NEAR(plan.contacts[k].arc_length, expected.contacts[k].arc_length, tolerance);
    EXPECT_NEAR(plan.contacts[k].force, expected.contacts[k].force, tolerance);
  }
}

using Limits = std::tuple<std::string, Basis, double>;

class GraspLimits : public testing::TestWithParam<Limits> {};

TEST_P(GraspLimits, EveryDiameterIsHeldAtTheForceLimitWithoutForceAlongTheAxis) {
  const auto& [solver, basis, limit] = GetParam();
  for (const double diameter : diameters()) {
    SCOPED_TRACE(diameter);
    Scene made = with_basis(grasp_of_diameter(diameter, limit), basis);
    made.solver.plugin = solver;
    const Plan found = confirmed(made, basis.model_error);
    ASSERT_TRUE(certified(found));
    EXPECT_NEAR(contact_force(found), limit, 1e-6);
    EXPECT_LT(std::abs(found.grasp->axial_force), 1e-6);
    EXPECT_LT(found.certificate.equilibrium, 1e-9);
    EXPECT_TRUE(contains_text(found.verification, "settled from the plan's own shape"));
    ASSERT_TRUE(found.model_error);
    EXPECT_LT(*found.model_error, basis.model_error);
    const Execution reached = carried_out(made, found, found.moments);
    ASSERT_EQ(reached.result.status, PlanStatus::solved);
    EXPECT_LE(std::abs(grasp_of(made, found.grasp->palm_distance, reached.result.contacts).axial_force),
              basis.axial_force);
    // Neither finger crosses the axis, and neither goes through the palm.
    for (const BackbonePoint& p : found.backbone) {
      EXPECT_GE(p.y, -1e-9 * made.rod.length());
      EXPECT_GE(p.x, -1e-9 * made.rod.length());
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Found, GraspLimits,
                         testing::Combine(testing::ValuesIn(solvers()), testing::Values(three_per_segment, six_split),
                                          testing::Values(3.33, 10.0)),
                         [](const testing::TestParamInfo<Limits>& of) {
                           return std::get<0>(of.param) + "_" + std::get<1>(of.param).plugin + "_" +
                                  std::to_string(std::lround(std::get<2>(of.param))) + "N";
                         });

class GraspSolver : public testing::TestWithParam<std::string> {
 protected:
  Plan planned(Scene made) const {
    made.solver.plugin = GetParam();
    return plan(made);
  }
};

INSTANTIATE_TEST_SUITE_P(Found, GraspSolver, testing::ValuesIn(solvers()),
                         [](const testing::TestParamInfo<std::string>& of) { return of.param; });

TEST_P(GraspSolver, TurnedByAnyAngleIsTheSamePlan) {
  // With weight along the axis, so that gravity has to turn as well.
  Scene upright = scene("grasp_60mm", {"rod.linear_density=\"80 g/m\""});
  upright.gravity = Vec2{9.81, 0.0};
  const Plan original = planned(upright);
  ASSERT_TRUE(certified(original));
  for (const double angle : {0.3, -0.7, 1.5707963267948966, 2.5, 3.9, -12.0}) {
    SCOPED_TRACE(angle);
    Scene turned = upright;
    turned.gripper->angle = angle;
    turned.gripper->position = {0.3, -0.2};
    turned.gravity = Vec2{9.81 * std::cos(angle), 9.81 * std::sin(angle)};
    const Plan other = planned(turned);
    ASSERT_TRUE(certified(other));
    expect_same_plan(other, original, 1e-8);
    ASSERT_EQ(other.backbone.size(), original.backbone.size());
    for (std::size_t i = 0; i < other.backbone.size(); ++i) {
      const Vec2 there = palm_to_world(*turned.gripper, original.backbone[i].position());
      EXPECT_LT(norm(there - other.backbone[i].position()), 1e-8);
    }
  }
}

TEST_P(GraspSolver, MirroredIsTheSamePlanWithTheFingersExchanged) {
  Scene made = scene("grasp_60mm", {"rod.linear_density=\"80 g/m\"", "gripper.finger_angle=\"0.2 rad\""});
  made.gripper->angle = 0.7;
  made.gripper->position = {0.1, 0.4};
  made.gravity = Vec2{9.81 * std::cos(0.7), 9.81 * std::sin(0.7)};
  Scene image = made;
  image.gripper->angle = -0.7;
  image.gripper->position = {0.1, -0.4};
  image.gravity = Vec2{9.81 * std::cos(0.7), -9.81 * std::sin(0.7)};
  const Plan original = planned(made);
  const Plan other = planned(image);
  ASSERT_TRUE(certified(original));
  ASSERT_TRUE(certified(other));
  expect_same_plan(other, original, 1e-8);
  ASSERT_EQ(other.backbone.size(), original.backbone.size());
  for (std::size_t i = 0; i < other.backbone.size(); ++i) {
    const Vec2 lower = mirrored(*made.gripper, original.backbone[i].position());
    EXPECT_NEAR(other.backbone[i].x, lower.x, 1e-8);
    EXPECT_NEAR(other.backbone[i].y, -lower.y, 1e-8);
  }
}

TEST_P(GraspSolver, InOtherUnitsIsTheSamePlan) {
  const Plan original = planned(scene("grasp_60mm"));
  ASSERT_TRUE(certified(original));
  const std::vector<std::string> millimetres{"gripper.half_palm=\"0.02 m\"",
                                             "gripper.object_diameter=\"6 cm\"",
                                             "rod.length=\"0.1 m\"",
                                             "rod.bending_stiffness=\"1e4 N mm^2\"",
                                             "rod.actuator.0.to=\"7 cm\"",
                                             "rod.actuator.0.limit=\"1000 N mm\"",
                                             "rod.actuator.1.from=\"0.07 m\"",
                                             "rod.actuator.1.limit=\"1e6 mN mm\"",
                                             "start.tip_angle=\"-28.6478897565 deg\"",
                                             "contact.max_force=\"3330 mN\""};
  const std::vector<std::string> inches{
      "gripper.half_palm=\"0.787401574803150 inch\"", "gripper.object_diameter=\"2.36220472440945 inch\"",
      "rod.length=\"3.93700787401575 inch\"",         "rod.bending_stiffness=\"3.48454559076413 lbf inch^2\"",
      "rod.actuator.0.to=\"2.75590551181102 inch\"",  "rod.actuator.1.from=\"2.75590551181102 inch\"",
      "contact.max_force=\"0.748613780522036 lbf\""};
  for (const std::vector<std::string>& units : {millimetres, inches}) {
    const Plan other = planned(scene("grasp_60mm", units));
    ASSERT_TRUE(certified(other));
    expect_same_plan(other, original, 1e-8);
  }
}

/// Objectives that say nothing of the force leave it where the scene allows the most.
TEST_P(GraspSolver, PressesAsHardAsItMayWhereNoObjectiveWeighsTheForce) {
  for (const double diameter : {0.02, 0.04, 0.06, 0.075}) {
    for (const double limit : {0.5, 3.33, 10.0}) {
      SCOPED_TRACE(std::to_string(diameter) + " m, " + std::to_string(limit) + " N");
      Scene made = grasp_of_diameter(diameter, limit);
      std::erase_if(made.objectives, [](const ObjectiveSpec& o) { return o.plugin == "contact_force"; });
      const Plan found = planned(made);
      ASSERT_TRUE(certified(found));
      EXPECT_NEAR(contact_force(found), limit, 1e-6);
      for (const LeftOut& item : found.left_out) EXPECT_FALSE(contains_text(item.what, "at its limit of"));
    }
  }
}

TEST_P(GraspSolver, SaysWhyItPressesLess) {
  const auto reason = [](const Plan& found) {
    for (const LeftOut& item : found.left_out) {
      if (contains_text(item.what, "each contact at its limit of 3.33 N")) return item.why;
    }
    return std::string();
  };
  // Moments that are worth more than the force.
  Scene dear = grasp_of_diameter(0.06, 3.33);
  dear.objectives[0].weight = 1e-4;
  dear.objectives[1].weight = 1.0;
  const Plan weighed = planned(dear);
  ASSERT_TRUE(certified(weighed));
  EXPECT_LT(contact_force(weighed), 3.0);
  EXPECT_EQ(reason(weighed), "an objective weighs the force against something else");
  // Moments that are too small for it.
  Scene weak = grasp_of_diameter(0.06, 3.33);
  std::erase_if(weak.objectives, [](const ObjectiveSpec& o) { return o.plugin == "contact_force"; });
  for (ActuatorSpec& a : weak.rod.actuators) {
    a.minimum = -0.09;
    a.maximum = 0.09;
  }
  const Plan light = planned(weak);
  ASSERT_TRUE(certified(light));
  EXPECT_LT(contact_force(light), 3.0);
  EXPECT_TRUE(contains_text(reason(light), "no such grasp was certified"));
}

/// Where no motor is strong enough for the force limit the cheapest grasp counts. It takes 64 N mm: larger limits
/// change nothing.
TEST_P(GraspSolver, WeakMotorsHoldWhatTheyCan) {
  const auto weak = [&](double limit) {
    Scene made = grasp_of_diameter(0.06, 3.33);
    made.solver.time_limit = 60.0;
    std::erase_if(made.objectives, [](const ObjectiveSpec& o) { return o.plugin == "contact_force"; });
    for (ActuatorSpec& a : made.rod.actuators) {
      a.minimum = -limit;
      a.maximum = limit;
    }
    return planned(made);
  };
  const Plan first = weak(0.08);
  ASSERT_TRUE(certified(first));
  EXPECT_NEAR(first.grasp->axial_force, 0.0, 1e-9);
  EXPECT_NEAR(std::abs(first.moments[1]), 0.0643639, 1e-6);
  for (const double limit : {0.1, 0.11}) {
    SCOPED_TRACE(limit);
    const Plan found = weak(limit);
    ASSERT_TRUE(certified(found));
    EXPECT_NEAR(contact_force(found), contact_force(first), 1e-6);
    expect_same_plan(found, first, 1e-6);
  }
}

TEST_P(GraspSolver, AWayOfTouchingThatCannotHoldCostsNoSolve) {
  // The proximal segment ends too early for this object; the distal one holds it.
  const Plan found = planned(scene("grasp_60mm"));
  ASSERT_TRUE(certified(found));
  ASSERT_EQ(found.modes.size(), 3U);
  EXPECT_FALSE(found.modes[0].certified);
  EXPECT_EQ(found.modes[0].solves, 0);
  EXPECT_TRUE(contains_text(found.modes[0].outcome, "nothing feasible is near its starts"));
  EXPECT_TRUE(found.modes[1].certified);
}

TEST_P(GraspSolver, LimitsOfPressureAreLimitsOfMoment) {
  // 60 kPa are less than the proximal chamber takes for 15 mm without a limit (65 kPa).
  const std::string free = replaced(text_of_scene(), "60 mm\"\n", "15 mm\"\n");
  const std::string with_pressure =
      replaced(free, "limit = \"1 N m\"", "min_pressure = \"-60 kPa\"\nmax_pressure = \"60 kPa\"");
  const std::string with_moment = replaced(free, "limit = \"1 N m\"", "limit = \"240 N mm\"");
  const Plan by_pressure = planned(scene_from_text(with_pressure));
  const Plan by_moment = planned(scene_from_text(with_moment));
  ASSERT_TRUE(certified(by_pressure));
  ASSERT_TRUE(certified(by_moment));
  expect_same_plan(by_pressure, by_moment, 1e-12);
  EXPECT_NEAR(by_pressure.moments[0], -0.24, 1e-9);
  // Both quantities are reported.
  const std::string json = app::plan_json(scene_from_text(with_pressure), by_pressure, {});
  const std::size_t pressures = json.find("\"pressures\"");
  ASSERT_TRUE(contains_text(json, "\"pressures\""));
  EXPECT_NEAR(std::stod(json.substr(json.find('[', pressures) + 1)), 60e3, 1e-3);
  const std::size_t moments = json.find("\"moments\"");
  ASSERT_TRUE(contains_text(json, "\"moments\""));
  EXPECT_NEAR(std::stod(json.substr(json.find('[', moments) + 1)), -0.24, 1e-9);
}

TEST_P(GraspSolver, TheOtherFingerKeepsTheTipOnItsSide) {
  const std::vector<std::string> crossing{"gripper.object_diameter=\"31.1 mm\"", "gripper.half_palm=\"6.4 mm\"",
                                          "gripper.finger_angle=\"0.77 rad\"",   "rod.actuator.0.to=\"30 mm\"",
                                          "rod.actuator.1.from=\"30 mm\"",       "contact.max_force=\"13.96 N\""};
  const Plan found = planned(scene("grasp_60mm", crossing));
  ASSERT_TRUE(certified(found));
  // It leans against the axis, so the row does something.
  EXPECT_NEAR(found.tip_y, 0.0, 1e-9);
  for (const BackbonePoint& p : found.backbone) EXPECT_GE(p.y, -1e-10);
}

TEST_P(GraspSolver, ThePalmKeepsACurledFingerAway) {
  const std::vector<std::string> curled{"gripper.object_diameter=\"20 mm\"", "gripper.half_palm=\"15 mm\"",
                                        "gripper.finger_angle=\"-0.8 rad\"", "rod.rest_curvature=\"50 1/m\"",
                                        "rod.actuator.0.to=\"30 mm\"",       "rod.actuator.1.from=\"30 mm\"",
                                        "contact.max_force=\"1 N\""};
  const Plan found = planned(scene("grasp_60mm", curled));
  ASSERT_TRUE(certified(found));
  double nearest = infinity;
  for (const BackbonePoint& p : found.backbone) {
    EXPECT_GE(p.x, -1e-10);
    if (p.s > 0.03) nearest = std::min(nearest, p.x);
  }
  // Beyond the contact the finger turns back until it grazes the palm; the samples lie up to 0.5 mm beside that point.
  EXPECT_LT(nearest, 1e-5);
}

TEST_P(GraspSolver, WhatCannotBeHeldIsInfeasibleWithTheLimitThatBinds) {
  const auto refused = [&](const Scene& made, const std::string& reason) {
    const Plan found = planned(made);
    EXPECT_EQ(found.status, PlanStatus::infeasible) << found.message;
    EXPECT_TRUE(contains_text(found.message, reason));
  };
  refused(grasp_of_diameter(0.2, 3.33), "too large");
  // Within reach, but not even the largest force bends the finger round it.
  refused(grasp_of_diameter(0.15, 3.33), "contact force 1 at its largest");
  refused(scene("grasp_60mm", {"gripper.palm_distance=\"150 mm\""}), "too far away");
  refused(scene("grasp_60mm", {"gripper.palm_distance=\"100 mm\""}), "too far away");
  // A weak finger cannot bend down to a thin object, nor round a thick one.
  const std::vector<std::string> weak{"rod.actuator.0.limit=\"10 N mm\"", "rod.actuator.1.limit=\"10 N mm\""};
  refused(grasp_of_diameter(0.005, 3.33, weak), "moment 1 at its smallest");
  // With 150 N mm, both moments closing, it is held.
  refused(grasp_of_diameter(0.075, 3.33, weak), "moment 1 at its smallest, moment 2 at its smallest");
}

TEST(GraspReport, SaysWhichMomentsOpenTheFinger) {
  for (const auto& [diameter, opens] : {std::pair(0.06, false), std::pair(0.04, true)}) {
    const Scene made = grasp_of_diameter(diameter, 3.33);
    const Plan found = plan(made);
    ASSERT_TRUE(certified(found));
    ASSERT_EQ(found.moments[1] > 0.0, opens);
    const std::string report = app::plan_report(made, found, {});
    EXPECT_TRUE(contains_text(report, "1 % of moment 1 (closing)"));
    EXPECT_TRUE(contains_text(report, opens ? "1 % of moment 2 (opening)" : "1 % of moment 2 (closing)"));
  }
}

TEST(GraspClosing, EveryDiameterIsHeldOrRefusedWithTheReason) {
  for (const double limit : {3.33, 10.0}) {
    for (const Basis& basis : {three_per_segment, six_split}) {
      int held = 0;
      for (const double diameter : diameters()) {
        SCOPED_TRACE(diameter);
        Scene made = with_basis(grasp_of_diameter(diameter, limit), basis);
        for (ActuatorSpec& a : made.rod.actuators) a.maximum = 0.0;
        const Plan found = confirmed(made, basis.model_error);
        if (found.status == PlanStatus::solved) {
          ++held;
          EXPECT_TRUE(certified(found));
          EXPECT_TRUE(found.model_error);
          EXPECT_NEAR(contact_force(found), limit, 1e-6);
          EXPECT_LT(std::abs(found.grasp->axial_force), 1e-6);
          for (const double u : found.moments) EXPECT_LE(u, 1e-12);
        } else if (found.status == PlanStatus::not_converged) {
          // The cheapest plan, carried out: the fingers come to rest on each other.
          Plan first = plan(made);
          ASSERT_TRUE(certified(first));
          ExecuteControl own;
          own.start = &first;
          verify(finger_in_world(made), obstacles_of_finger(made, first.grasp->palm_distance), first, own);
          EXPECT_TRUE(contains_text(first.message, "execution on 'object', 'other finger'")) << first.message;
        } else if (found.status == PlanStatus::unstable) {
          EXPECT_FALSE(found.certificate.stability > 0.0);
          EXPECT_TRUE(contains_text(found.message, "the stability margin is"));
        } else {
          EXPECT_EQ(found.status, PlanStatus::infeasible) << found.message;
          EXPECT_TRUE(contains_text(found.message, "at its"));
        }
      }
      // The tips hold what the segments cannot. At 10 N the two smallest objects would need the tips to be pulled
      // apart.
      EXPECT_EQ(held, limit < 5.0 ? 13 : 11);
    }
  }
}

// The paper's form of the balance has no bound of its own: it rewards pushing the object towards the palm.
TEST(GraspLinearBalance, EndsNoHigherThanTheBalancedGraspOrSaysSo) {
  for (const char* diameter : {"30 mm", "60 mm"}) {
    const std::string text = replaced(text_of_scene(), "60 mm\"\n", std::string(diameter) + "\"\n");
    const Plan balanced = plan(scene_from_text(text));
    ASSERT_TRUE(certified(balanced));
    for (const char* weight : {"1e-4", "1e-3", "1e-2", "1e-1", "1"}) {
      SCOPED_TRACE(std::string(diameter) + ", " + weight);
      const std::string term = std::string("[[objective]]\nplugin = \"grasp_balance\"\nform = \"linear\"\nweight = ") +
                               weight + "\n\n[solver]";
      const std::string linear =
          replaced(replaced(text, "[gripper]", "[gripper]\nbalance = \"objective\""), "[solver]", term);
      const Plan found = plan(scene_from_text(linear));
      ASSERT_TRUE(certified(found));
      EXPECT_GT(std::abs(found.grasp->axial_force), 1e-3);
      const bool said = std::any_of(found.left_out.begin(), found.left_out.end(), [](const LeftOut& item) {
        return item.what == "the grasp with the balance as a row";
      });
      EXPECT_EQ(said, found.objective > balanced.objective + 1e-9);
    }
  }
}

}  // namespace
}  // namespace tendril::combination
