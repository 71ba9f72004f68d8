#include <gtest/gtest.h>

#include <cmath>

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

TEST(Actuator, ATendonHasTheMomentOfItsLargestOffset) {
  ActuatorSpec a;
  a.kind = ActuatorKind::tendon;
  a.offset = {{0.0, 2e-3}, {0.05, -8e-3}, {0.1, 4e-3}};
  EXPECT_EQ(a.largest_offset(), -8e-3);
  EXPECT_NEAR(a.moment_of(2.0), -16e-3, 1e-17);
  EXPECT_NEAR(a.input_of(-16e-3), 2.0, 1e-15);
  EXPECT_EQ(a.input_dimension().unit, "N");
}

}  // namespace
}  // namespace tendril
