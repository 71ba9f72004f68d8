#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "tendril/scale.hpp"

namespace tendril {
namespace {

TEST(Scale, UnitsAreProductsOfLengthAndForce) {
  const Scale scale{0.1, 4.9e-4};
  // Relative error of two or three roundings.
  EXPECT_DOUBLE_EQ(scale.unit(dimension::none), 1.0);
  EXPECT_DOUBLE_EQ(scale.unit(dimension::angle), 1.0);
  EXPECT_DOUBLE_EQ(scale.unit(dimension::length), 0.1);
  EXPECT_DOUBLE_EQ(scale.unit(dimension::curvature), 10.0);
  EXPECT_DOUBLE_EQ(scale.unit(dimension::force), 0.049);
  EXPECT_DOUBLE_EQ(scale.unit(dimension::moment), 4.9e-3);
  EXPECT_DOUBLE_EQ(scale.unit(dimension::stiffness), 4.9e-4);
}

TEST(Scale, BackToSiUndoesToDimensionlessToTwelveDigits) {
  const Scale scale{0.123456789, 0.0314159};
  constexpr Dimension force_per_length{-1, 1, "N/m"};
  for (const Dimension& d : {dimension::none, dimension::angle, dimension::length, dimension::curvature,
                             dimension::force, dimension::moment, dimension::stiffness, force_per_length}) {
    SCOPED_TRACE("in " + std::string(d.unit));
    for (const double si : {2.5e-3, -87.654321}) {
      // A quantity as large as its unit is 1.
      EXPECT_NEAR(scale.to_dimensionless(si * scale.unit(d), d), si, 1e-11 * std::abs(si));
      // Half a unit in the twelfth digit.
      EXPECT_NEAR(scale.to_si(scale.to_dimensionless(si, d), d), si, 5e-12 * std::abs(si));
    }
  }
}

TEST(Scale, EqualScenesInMillimetresAndMetresGiveEqualNumbers) {
  // 58.7 mm read in mm and in m differ in the last bits; after rounding they do not.
  const Scale metres{0.1, 4.9e-4};
  const Scale from_millimetres{100.0 * 1e-3, 490.0 * 1e-6};
  EXPECT_EQ(metres.to_dimensionless(0.0587, dimension::length),
            from_millimetres.to_dimensionless(58.7 * 1e-3, dimension::length));
  EXPECT_EQ(metres.to_dimensionless(2.5e-3, dimension::moment),
            from_millimetres.to_dimensionless(2.5 * 1e-3, dimension::moment));
}

TEST(RoundTo12Digits, KeepsTwelveDigits) {
  EXPECT_EQ(round_to_12_digits(1.23456789012345), 1.23456789012);
  EXPECT_EQ(round_to_12_digits(-9.99999999999951e-7), -1e-6);
  EXPECT_EQ(round_to_12_digits(0.1 + 0.2), 0.3);
}

TEST(RoundTo12Digits, PassesZeroInfinitiesAndTheEndsOfTheRange) {
  constexpr double infinite = std::numeric_limits<double>::infinity();
  EXPECT_EQ(round_to_12_digits(0.0), 0.0);
  EXPECT_EQ(round_to_12_digits(infinite), infinite);
  EXPECT_EQ(round_to_12_digits(-infinite), -infinite);
  // The largest number rounds down, so nothing leaves the range.
  EXPECT_EQ(round_to_12_digits(std::numeric_limits<double>::max()), 1.79769313486e308);
  EXPECT_EQ(round_to_12_digits(std::numeric_limits<double>::denorm_min()), std::numeric_limits<double>::denorm_min());
}

}  // namespace
}  // namespace tendril
