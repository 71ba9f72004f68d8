#include "common/statistics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace tendril::bench {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

TEST(Quantiles, InterpolateBetweenOrderStatistics) {
  EXPECT_DOUBLE_EQ(median({3.0, 1.0, 2.0}), 2.0);
  EXPECT_DOUBLE_EQ(median({4.0, 1.0, 2.0, 3.0}), 2.5);
  const Quartiles q = quartiles({1.0, 2.0, 3.0, 4.0, 5.0});
  EXPECT_DOUBLE_EQ(q.low, 2.0);
  EXPECT_DOUBLE_EQ(q.median, 3.0);
  EXPECT_DOUBLE_EQ(q.high, 4.0);
  EXPECT_DOUBLE_EQ(quantile({10.0, 20.0}, 0.25), 12.5);
}

TEST(Quantiles, KeepInfinityApartAndNothingIsNotANumber) {
  EXPECT_DOUBLE_EQ(median({1.0, 2.0, infinite}), 2.0);
  EXPECT_EQ(median({1.0, infinite, infinite}), infinite);
  EXPECT_TRUE(std::isnan(median({})));
}

TEST(Fits, FindTheLineThatTheyWereGiven) {
  const Line line = fit_line({0.0, 1.0, 2.0, 3.0}, {1.0, 3.0, 5.0, 7.0});
  EXPECT_DOUBLE_EQ(line.slope, 2.0);
  EXPECT_DOUBLE_EQ(line.intercept, 1.0);
  EXPECT_DOUBLE_EQ(line.determination, 1.0);
  EXPECT_EQ(line.points, 4);
}

// Anscombe's first data set: slope 0.5001, intercept 3.0001, R^2 0.6665.
TEST(Fits, AgreeWithAnscombe) {
  const Line line = fit_line({10, 8, 13, 9, 11, 14, 6, 4, 12, 7, 5},
                             {8.04, 6.95, 7.58, 8.81, 8.33, 9.96, 7.24, 4.26, 10.84, 4.82, 5.68});
  EXPECT_NEAR(line.slope, 0.5001, 5e-5);
  EXPECT_NEAR(line.intercept, 3.0001, 5e-5);
  EXPECT_NEAR(line.determination, 0.6665, 5e-5);
}

TEST(Fits, PowersAndExponentialsInTheirLogarithms) {
  std::vector<double> x, power, exponential;
  for (int n = 1; n <= 6; ++n) {
    x.push_back(n);
    power.push_back(7.0 * std::pow(n, -2.0));
    exponential.push_back(3.0 * std::pow(10.0, -1.5 * n));
  }
  EXPECT_NEAR(fit_power(x, power).slope, -2.0, 1e-12);
  EXPECT_NEAR(std::pow(10.0, fit_power(x, power).intercept), 7.0, 1e-11);
  EXPECT_NEAR(fit_exponential(x, exponential).slope, -1.5, 1e-12);
  EXPECT_LT(fit_power(x, exponential).determination, 1.0 - 1e-3);
}

TEST(Fits, LeaveOutWhatHasNoLogarithmAndSayWhatIsTooLittle) {
  const Line line = fit_power({1.0, 2.0, 4.0, 8.0}, {1.0, 0.0, 0.0625, infinite});
  EXPECT_EQ(line.points, 2);
  EXPECT_NEAR(line.slope, -2.0, 1e-12);
  EXPECT_TRUE(std::isnan(fit_line({1.0}, {1.0}).slope));
  EXPECT_TRUE(std::isnan(fit_line({1.0, 1.0}, {1.0, 2.0}).slope));
}

TEST(ShiftedGeometricMean, IsTheGeometricMeanWithoutAShift) {
  EXPECT_NEAR(shifted_geometric_mean({1.0, 4.0, 16.0}, 0.0), 4.0, 1e-12);
  // sqrt(11 * 20) - 10
  EXPECT_NEAR(shifted_geometric_mean({1.0, 10.0}, 10.0), std::sqrt(220.0) - 10.0, 1e-12);
  EXPECT_NEAR(shifted_geometric_mean({5.0, 5.0}, 3.0), 5.0, 1e-12);
}

TEST(PerformanceProfile, ComparesWithTheBestOfEachProgram) {
  const auto ratios = performance_ratios({{1.0, 6.0, infinite, infinite}, {2.0, 2.0, 4.0, infinite}});
  EXPECT_DOUBLE_EQ(share_within(ratios[0], 1.0), 0.25);
  EXPECT_DOUBLE_EQ(share_within(ratios[0], 2.9), 0.25);
  EXPECT_DOUBLE_EQ(share_within(ratios[0], 3.0), 0.5);
  EXPECT_DOUBLE_EQ(share_within(ratios[1], 1.0), 0.5);
  EXPECT_DOUBLE_EQ(share_within(ratios[1], 2.0), 0.75);
  EXPECT_DOUBLE_EQ(share_within(ratios[1], 1e9), 0.75);
}

TEST(Ranks, TimesOfOneClassAreDecidedByTheSecondCost) {
  // 1.0 and 1.1 are a class at a tie of 1.25; 1.3 is beyond it, though within 1.25 of 1.1.
  EXPECT_EQ(ranks({1.1, 1.0, 1.3, 9.0}, {5.0, 7.0, 1.0, 0.0}, 1.25), (std::vector<int>{1, 2, 3, 4}));
  EXPECT_EQ(ranks({3.0, 1.0, 2.0}, {0.0, 0.0, 0.0}, 1.0), (std::vector<int>{3, 1, 2}));
  EXPECT_EQ(ranks({1.0, 1.0}, {2.0, 2.0}, 1.0), (std::vector<int>{1, 2}));
}

}  // namespace
}  // namespace tendril::bench
