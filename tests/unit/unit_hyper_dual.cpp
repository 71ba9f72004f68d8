// Numbers that carry derivatives, function by function.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <ostream>
#include <string>
#include <vector>

#include "tendril/hyper_dual.hpp"

namespace tendril {

namespace {

/// A function of two numbers along two directions: x = v + s a + t b + s t ab, and y likewise.
struct Case {
  std::string name;
  std::function<double(double, double)> plain;
  std::function<HyperDual(HyperDual, HyperDual)> dual;
  double x, y;
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

#define BOTH(name, x, y, formula)                                 \
  Case {                                                          \
    name,                                                         \
        [](const double& p, const double& q) -> double {          \
          (void)q;                                                \
          return formula;                                         \
        },                                                        \
        [](const HyperDual& p, const HyperDual& q) -> HyperDual { \
          (void)q;                                                \
          return formula;                                         \
        },                                                        \
        x, y                                                      \
  }

std::vector<Case> cases() {
  return {BOTH("sum", 0.7, 1.3, p + q),
          BOTH("difference", 0.7, 1.3, p - q),
          BOTH("product", 0.7, -1.3, p * q),
          BOTH("quotient", 0.7, -1.3, p / q),
          BOTH("negative", 0.7, 1.3, -p),
          BOTH("itself", 0.7, 1.3, +p),
          BOTH("with_constants", 0.7, 1.3, 2.0 * p - q / 3.0 + 1.5 / p - (0.5 - q)),
          BOTH("sqrt", 0.7, 1.3, sqrt(p)),
          BOTH("exp", 0.7, 1.3, exp(p)),
          BOTH("log", 0.7, 1.3, log(p)),
          BOTH("sin", 0.7, 1.3, sin(p)),
          BOTH("cos", 0.7, 1.3, cos(p)),
          BOTH("tan", 0.7, 1.3, tan(p)),
          BOTH("atan", 0.7, 1.3, atan(p)),
          BOTH("tanh", 0.7, 1.3, tanh(p)),
          BOTH("abs_of_positive", 0.7, 1.3, abs(p)),
          BOTH("abs_of_negative", -0.7, 1.3, abs(p)),
          BOTH("cube", -0.7, 1.3, pow(p, 3.0)),
          BOTH("broken_power", 0.7, 1.3, pow(p, -1.7)),
          BOTH("atan2_first", 0.7, 1.3, atan2(p, q)),
          BOTH("atan2_second", 0.7, -1.3, atan2(p, q)),
          BOTH("atan2_third", -0.7, -1.3, atan2(p, q)),
          BOTH("atan2_fourth", -0.7, 1.3, atan2(p, q)),
          BOTH("hypot", 0.7, -1.3, hypot(p, q)),
          BOTH("composed", 0.7, 1.3, sin(p * q) / sqrt(p + q * q) + exp(-p) * atan2(q, p))};
}

class HyperDuals : public testing::TestWithParam<Case> {};

TEST_P(HyperDuals, CarryTheDerivativesOfTheFunction) {
  const Case& c = GetParam();
  const HyperDual x(c.x, 0.9, -0.4, 0.6);
  const HyperDual y(c.y, -0.5, 0.8, 0.3);
  const auto at = [&](double s, double t) {
    return c.plain(x.v + s * x.a + t * x.b + s * t * x.ab, y.v + s * y.a + t * y.b + s * t * y.ab);
  };
  // Central differences of fourth order: h^4 = 1e-10 times fifth derivatives of order 100, rounding 1e-16 / h^2.
  constexpr double h = 3e-3;
  const auto slope = [](const std::function<double(double)>& f) {
    return (8.0 * (f(h) - f(-h)) - (f(2.0 * h) - f(-2.0 * h))) / (12.0 * h);
  };
  const HyperDual found = c.dual(x, y);
  EXPECT_DOUBLE_EQ(found.v, at(0.0, 0.0));
  constexpr double accuracy = 1e-7;
  EXPECT_NEAR(found.a, slope([&](double s) { return at(s, 0.0); }), accuracy);
  EXPECT_NEAR(found.b, slope([&](double t) { return at(0.0, t); }), accuracy);
  EXPECT_NEAR(found.ab, slope([&](double s) { return slope([&](double t) { return at(s, t); }); }), accuracy);
}

INSTANTIATE_TEST_SUITE_P(All, HyperDuals, testing::ValuesIn(cases()), [](const auto& each) { return each.param.name; });

TEST(HyperDual, IsComparedByItsValueAlone) {
  const HyperDual one(1.0, 5.0, -5.0, 2.0);
  const HyperDual same(1.0, -7.0, 3.0, 0.0);
  const HyperDual two(2.0, -9.0, -9.0, -9.0);
  EXPECT_TRUE(one < two && two > one && one <= two && two >= one);
  EXPECT_FALSE(two < one || one > two || two <= one || one >= two);
  EXPECT_TRUE(one <= same && one >= same);
  EXPECT_FALSE(one < same || one > same);
}

TEST(HyperDual, AConstantHasNoDerivatives) {
  const HyperDual c = 3.0;
  EXPECT_EQ(c.v, 3.0);
  EXPECT_EQ(c.a, 0.0);
  EXPECT_EQ(c.b, 0.0);
  EXPECT_EQ(c.ab, 0.0);
}

TEST(HyperDual, ItsAbsoluteValueAtZeroIsThatOfTheRightSide) { EXPECT_EQ(abs(HyperDual(0.0, 2.0, -1.0, 0.5)).a, 2.0); }

}  // namespace

}  // namespace tendril
