#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tendril/scene.hpp"

namespace tendril {
namespace {

ActuatorSpec chamber(double sign) {
  ActuatorSpec a;
  a.moment_per_pressure = sign * 2e-6;
  a.more_moment_per_pressure = {sign * 3e-11, sign * -1e-16};
  a.least_pressure = -1e4;
  a.most_pressure = 8e4;
  return a;
}

TEST(Actuator, APressureGivesTheMomentOfItsPolynomialAndTheOtherWayRound) {
  for (const double sign : {1.0, -1.0}) {
    const ActuatorSpec a = chamber(sign);
    EXPECT_EQ(a.input(), ActuatorKind::pressure);
    EXPECT_NEAR(a.moment_of(5e4), sign * (0.1 + 0.075 - 0.0125), 1e-15);
    for (const double p : {-1e4, -3e3, 0.0, 10.0, 5e4, 8e4}) EXPECT_NEAR(a.input_of(a.moment_of(p)), p, 1e-9) << p;
  }
}

TEST(Actuator, BeyondItsPressuresALawGoesOnAlongItsTangents) {
  const ActuatorSpec a = chamber(1.0);
  const auto slope = [&](double p) { return 2e-6 + 6e-11 * p - 3e-16 * p * p; };
  EXPECT_NEAR(a.moment_of(9e4) - a.moment_of(8e4), 1e4 * slope(8e4), 1e-15);
  EXPECT_NEAR(a.moment_of(-1e4) - a.moment_of(-3e4), 2e4 * slope(-1e4), 1e-15);
  for (const double p : {-1e6, -1.1e4, 8.1e4, 1e6}) EXPECT_NEAR(a.input_of(a.moment_of(p)), p, 1e-6) << p;
}

// By the moment, between the two pressures, at random ones.
TEST(Actuator, ThePullOfAPressureHasItsDerivativesByTheMoment) {
  std::mt19937 random(3);
  for (const double sign : {1.0, -1.0}) {
    ActuatorSpec a = chamber(sign);
    a.force_per_pressure = {4e-4, -2e-9, 1e-14};
    EXPECT_FALSE(a.pulls_in_proportion());
    for (int trial = 0; trial < 20; ++trial) {
      const double moment = a.moment_of(std::uniform_real_distribution<double>(0.0, 7e4)(random));
      const double h = 1e-5;
      const ActuatorSpec::Pull here = a.pull_of(moment);
      const ActuatorSpec::Pull low = a.pull_of(moment - h);
      const ActuatorSpec::Pull high = a.pull_of(moment + h);
      EXPECT_NEAR(here.slope, (high.force - low.force) / (2.0 * h), 1e-5 * std::abs(here.slope));
      EXPECT_NEAR(here.bend, (high.slope - low.slope) / (2.0 * h), 1e-5 * std::abs(here.bend) + 1e-4);
    }
  }
  ActuatorSpec a = chamber(1.0);
  a.force_per_pressure = {4e-4, 6e-9, -2e-14};
  EXPECT_TRUE(a.pulls_in_proportion());
}

TEST(Actuator, ATendonHasTheMomentOfItsLargestOffset) {
  ActuatorSpec a;
  a.kind = ActuatorKind::tendon;
  a.offset = {{0.0, 2e-3}, {0.05, -8e-3}, {0.1, 4e-3}};
  EXPECT_EQ(a.largest_offset(), -8e-3);
  EXPECT_NEAR(a.moment_of(2.0), -16e-3, 1e-17);
  EXPECT_NEAR(a.input_of(-16e-3), 2.0, 1e-15);
  EXPECT_EQ(a.input_dimension().unit, "N");
  // Told its length it holds that: what it is shorter by.
  EXPECT_EQ(a.held(-16e-3, 0.5), -16e-3);
  a.by_length = true;
  EXPECT_NEAR(a.held(-16e-3, 0.5), -4e-3, 1e-18);
  EXPECT_EQ(a.input_dimension().unit, "m");
  EXPECT_EQ(a.effort_dimension().unit, "N");
}

}  // namespace
}  // namespace tendril
