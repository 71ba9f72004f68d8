// Plans of rods that may leave their plane.

#include <algorithm>
#include <cmath>

#include "support.hpp"
#include "tendril/execute.hpp"

namespace tendril::combination {
namespace {

Scene round_arm(double poisson, const std::string& solver) {
  Scene arm = scene("brace", {"solver.plugin=" + solver, "coordinates.order=10"});
  SegmentSpec& s = arm.rod.segments[0];
  s.torsional_stiffness = s.bending_stiffness / (1.0 + poisson);
  return arm;
}

TEST(OutOfPlane, PlansHaveTheMarginOfTheirExecution) {
  for (const std::string& solver : solvers_to_combine()) {
    SCOPED_TRACE(solver);
    const Scene arm = round_arm(0.45, solver);
    const Plan found = plan(arm);
    ASSERT_TRUE(certified(found));
    const Components parts = plugins::make_components(registry(), arm);
    const Execution reached = execute(arm, parts.obstacles, found.moments);
    ASSERT_TRUE(found.certificate.out_of_plane && reached.result.certificate.out_of_plane);
    EXPECT_NEAR(*found.certificate.out_of_plane, *reached.result.certificate.out_of_plane, 1e-7);
    EXPECT_GT(*found.certificate.out_of_plane, 0.0);
    EXPECT_LT(*found.certificate.out_of_plane, 1.0);
  }
}

TEST(OutOfPlane, AContactInsideOfAPieceIsWhereItIs) {
  Scene arm = round_arm(0.45, "nlopt");
  const Plan split = plan(arm);
  arm.coordinates.split_at_contact = false;
  const Plan whole = plan(arm);
  ASSERT_TRUE(certified(split));
  ASSERT_TRUE(certified(whole));
  // As far apart as the shapes are.
  EXPECT_NEAR(*split.certificate.out_of_plane, *whole.certificate.out_of_plane, 1e-3);
}

TEST(OutOfPlane, TorsionThatIsNotKnownChangesNothing) {
  const Plan known = plan(round_arm(0.45, "nlopt"));
  const Plan unknown = plan(scene("brace", {"solver.plugin=nlopt", "coordinates.order=10"}));
  EXPECT_FALSE(unknown.certificate.out_of_plane);
  EXPECT_EQ(known.coordinates, unknown.coordinates);
  EXPECT_EQ(known.evaluations.values, unknown.evaluations.values);
}

TEST(OutOfPlane, APlanThatBucklesSidewaysIsRefusedForThatReason) {
  Scene arm = round_arm(0.45, "nlopt");
  arm.rod.segments[0].torsional_stiffness *= 1e-3;
  const Plan refused = plan(arm);
  EXPECT_EQ(refused.status, PlanStatus::unstable) << refused.message;
  EXPECT_NE(refused.message.find("unstable out of its plane"), std::string::npos) << refused.message;
  EXPECT_LT(refused.certificate.out_of_plane.value_or(infinity), 0.0);
  arm.guided_in_plane = true;
  const Plan guided = plan(arm);
  EXPECT_TRUE(certified(guided));
  EXPECT_LT(guided.certificate.out_of_plane.value_or(infinity), 0.0);
}

TEST(OutOfPlane, OfTwoFingersTheWorseOneCounts) {
  const auto margin = [](double upper, double lower) {
    Scene grasp = scene("grasp_unequal");
    for (SegmentSpec& s : grasp.fingers.at(0).rod.segments) s.torsional_stiffness = upper * s.bending_stiffness;
    for (SegmentSpec& s : grasp.fingers.at(1).rod.segments) s.torsional_stiffness = lower * s.bending_stiffness;
    const Plan found = plan(grasp);
    EXPECT_TRUE(certified(found));
    return found.certificate.out_of_plane.value_or(-infinity);
  };
  const double of_upper = margin(0.7, 0.0);
  const double of_lower = margin(0.0, 0.7);
  EXPECT_GT(std::abs(of_upper - of_lower), 1e-3);
  EXPECT_NEAR(margin(0.7, 0.7), std::min(of_upper, of_lower), 1e-9);
}

}  // namespace
}  // namespace tendril::combination
