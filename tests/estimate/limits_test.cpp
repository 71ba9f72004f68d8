// Where an estimate stops being one: its limits from both sides, and what it reports in the units of the scene.

#include <gtest/gtest.h>

#include <cmath>

#include "estimate/truth.hpp"
#include "tendril/estimate.hpp"

namespace tendril {
namespace {

using test::Truth;

/// An estimate from exact points of the braced arm, told that they are this uncertain: its errors are then known.
Estimate of_arm(double noise, double disturbance = 0.0) {
  const Truth arm = test::braced_arm();
  Eigen::VectorXd points = test::exact_points(arm, arm.solve(), 20);
  // Up and down in turn: no shape of the rod follows that.
  for (Eigen::Index i = 0; i < points.size(); ++i) points[i] += (i / 2 % 2 == 0 ? 1.0 : -1.0) * disturbance;
  return estimate(test::scene_of(arm, points, noise, 1));
}

// The bound of the boundary-value problem: 0.63 % of the force for a noise of 2e-4 L, so 10 % at 3.17e-3 L.
TEST(EstimateLimits, AForceIsKnownIfItsErrorIsWithinTenPercent) {
  const Truth arm = test::braced_arm();
  const double force = test::parameters(arm, arm.solve())[0];
  const double at_limit = 0.1 * force / std::sqrt(test::cramer_rao(arm, 20, 1.0)(0, 0));
  for (const double share : {0.5, 0.9, 1.1, 2.0}) {
    SCOPED_TRACE("noise " + std::to_string(share) + " times what makes it 10 %");
    const Estimate found = of_arm(share * at_limit);
    if (found.contacts.empty()) {
      // So much noise hides the contact itself.
      EXPECT_GT(share, 1.0);
      continue;
    }
    EXPECT_EQ(found.contacts[0].identifiable, share < 1.0) << found.contacts[0].reason;
    EXPECT_EQ(found.status, share < 1.0 ? EstimateStatus::solved : EstimateStatus::not_identifiable) << found.message;
    EXPECT_NEAR(found.contacts[0].force_error / found.contacts[0].force, 0.1 * share, 1e-4);
  }
}

// With 38 degrees of freedom, residuals of the noise are exceeded half of the time, those of 1.4 times the noise once
// in 1e3, and those of twice the noise once in 1e15.
TEST(EstimateLimits, ResidualsOfTwiceTheNoiseAreAPoorFit) {
  const double disturbance = 2e-5;
  const double rms = of_arm(disturbance, disturbance).residual_rms;
  // The fit takes a part of what was added; nearly all of it stays.
  ASSERT_GT(rms, 0.8 * disturbance);
  for (const double ratio : {0.5, 1.0, 1.4}) {
    const Estimate fits = of_arm(rms / ratio, disturbance);
    EXPECT_NE(fits.status, EstimateStatus::poor_fit) << ratio << ": " << fits.message;
    EXPECT_GT(fits.fit_probability, 1e-6) << ratio;
  }
  for (const double ratio : {2.0, 4.0}) {
    const Estimate poor = of_arm(rms / ratio, disturbance);
    EXPECT_EQ(poor.status, EstimateStatus::poor_fit) << ratio << ": " << poor.message;
    EXPECT_LT(poor.fit_probability, 1e-6) << ratio;
    for (const EstimatedContact& c : poor.contacts) EXPECT_FALSE(c.identifiable);
    EXPECT_NE(poor.message.find("residuals are larger than the noise"), std::string::npos) << poor.message;
  }
}

TEST(EstimateLimits, NumbersAreInTheUnitsOfTheScene) {
  const double disturbance = 2e-5;
  const Estimate found = of_arm(0.0, disturbance);
  ASSERT_EQ(found.contacts.size(), 1U);
  EXPECT_TRUE(found.noise_estimated);
  EXPECT_EQ(found.degrees_of_freedom, 38);
  EXPECT_EQ(found.fit_probability, 1.0) << "nothing to compare residuals with";
  // 40 coordinates less two parameters of the contact.
  EXPECT_NEAR(found.noise, found.residual_rms * std::sqrt(40.0 / 38.0), 1e-9 * found.noise);
  EXPECT_NEAR(found.residual_rms, disturbance, 0.2 * disturbance);
  EXPECT_NEAR(found.chi_square, 38.0, 1e-9);
  // The backbone in m: curvature is the slope of the angle, and the steps are as long as the arc.
  ASSERT_EQ(found.backbone.size(), 101U);
  EXPECT_NEAR(found.backbone.back().s, 0.1, 1e-15);
  for (std::size_t i = 1; i + 1 < found.backbone.size(); ++i) {
    const BackbonePoint& before = found.backbone[i - 1];
    const BackbonePoint& at = found.backbone[i];
    const BackbonePoint& next = found.backbone[i + 1];
    // A chord is shorter than its arc by (curvature times arc)^2 / 24, here a part in 1e6.
    EXPECT_NEAR(std::hypot(next.x - at.x, next.y - at.y), next.s - at.s, 1e-5 * (next.s - at.s)) << i;
    // The curvature has a kink at the contact: differences of 1 mm see it to a part in a hundred.
    EXPECT_NEAR((next.angle - before.angle) / (next.s - before.s), at.curvature, 0.1) << i;
  }
}

// One arm pushed from below and one held from above: normals to either side, forces always positive.
TEST(EstimateLimits, AContactPushesTowardsTheRod) {
  for (const Truth& truth : {test::braced_arm(), test::held_from_above(), test::two_pegs()}) {
    const auto contacts = static_cast<int>(truth.circles.size());
    const Estimate found = estimate(test::scene_of(truth, test::exact_points(truth, truth.solve(), 20), 0.0, contacts));
    ASSERT_EQ(found.contacts.size(), truth.circles.size());
    for (std::size_t k = 0; k < found.contacts.size(); ++k) {
      const EstimatedContact& c = found.contacts[k];
      const support::BvpContact& circle = truth.circles[k];
      const Vec2 out = c.point - Vec2{circle.center.x, circle.center.y};
      EXPECT_NEAR(norm(out), circle.radius, 1e-7 * truth.length()) << "contact " << k;
      EXPECT_NEAR(norm(c.normal - (1.0 / norm(out)) * out), 0.0, 1e-5) << "contact " << k;
      EXPECT_GT(c.force, 0.0);
      EXPECT_FALSE(c.at_tip);
    }
  }
}

}  // namespace
}  // namespace tendril
