// Probabilities that decide how many contacts the points show. Tabulated values: Abramowitz and Stegun,
// tables 26.7, 26.8 and 26.10.

#include "estimate/significance.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "estimate/truth.hpp"

namespace tendril {
namespace {

TEST(ChiSquare, HasItsTabulatedProbabilities) {
  EXPECT_NEAR(chi_square_probability(5.99146, 2), 0.05, 1e-6);
  EXPECT_NEAR(chi_square_probability(18.3070, 10), 0.05, 1e-5);
  EXPECT_NEAR(chi_square_probability(63.6907, 40), 0.01, 1e-5);
  EXPECT_EQ(chi_square_probability(0.0, 4), 1.0);
  EXPECT_EQ(chi_square_probability(3.0, 0), 1.0);
  // Far beyond the range of exp().
  EXPECT_EQ(chi_square_probability(1e6, 40), 0.0);
  EXPECT_NEAR(chi_square_probability(20000.0, 20000), 0.5, 0.01);
}

TEST(StudentsT, HasItsTabulatedProbabilities) {
  EXPECT_NEAR(t_square_probability(12.706 * 12.706, 1), 0.05, 1e-5);
  EXPECT_NEAR(t_square_probability(2.228 * 2.228, 10), 0.05, 1e-4);
  EXPECT_NEAR(t_square_probability(2.704 * 2.704, 40), 0.01, 1e-4);
  EXPECT_NEAR(t_square_probability(1.96 * 1.96, 100000), 0.05, 1e-4);
}

TEST(CurveLength, OfAQuarterCircleAndOfWhatIsKnown) {
  constexpr int count = 2001;
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(3, count);
  for (int i = 0; i < count; ++i) {
    const double angle = 0.5 * std::numbers::pi * i / (count - 1);
    columns.col(i) << 5.0 * std::cos(angle), 5.0 * std::sin(angle), 1.0;
  }
  Eigen::MatrixXd known = Eigen::MatrixXd::Zero(3, 1);
  known(2, 0) = 3.0;
  EXPECT_NEAR(curve_length(columns, known, 1e-6), 0.5 * std::numbers::pi, 1e-6);
}

// The tube's bound, checked by chance itself: noise projected on a curve of directions. It must not be exceeded, and it
// is known to be sharp for small probabilities.
TEST(Improvement, HappensByChanceAsOftenAsSaid) {
  constexpr int dimension = 12;
  constexpr int count = 200;
  Eigen::MatrixXd curve(dimension, count);
  for (int i = 0; i < count; ++i) {
    const double s = 2.0 * i / (count - 1.0) - 1.0;
    for (int d = 0; d < dimension; ++d)
      curve(d, i) = std::exp(-8.0 * std::pow(s - 2.0 * d / (dimension - 1.0) + 1.0, 2));
  }
  const double length = curve_length(curve, Eigen::MatrixXd(dimension, 0), 1e-9);
  const Eigen::MatrixXd unit = curve.colwise().normalized();
  test::NormalNumbers normal(3);
  constexpr int runs = 20000;
  int often = 0;
  for (int run = 0; run < runs; ++run) {
    Eigen::VectorXd noise(dimension);
    for (double& v : noise) v = normal();
    const double best = (unit.transpose() * noise).cwiseAbs2().maxCoeff();
    if (improvement_probability(best, length, 0) < 0.01) ++often;
  }
  // 200 expected at most; three standard deviations are 42.
  EXPECT_LE(often, 242);
  EXPECT_GE(often, 120);
}

// Independent residuals look smooth as often as the probability says, and a curve with the same size always does.
TEST(Significance, SmoothResidualsAreToldFromNoise) {
  test::NormalNumbers normal(4);
  constexpr int points = 30;
  constexpr int runs = 20000;
  int often = 0;
  for (int run = 0; run < runs; ++run) {
    Eigen::VectorXd noise(2 * points);
    for (double& v : noise) v = normal();
    if (smooth_probability(noise) < 0.01) ++often;
  }
  // 200 expected; the normal approximation and chance allow for half as many more.
  EXPECT_LE(often, 300);
  EXPECT_GE(often, 100);
  Eigen::VectorXd curve(2 * points);
  for (int i = 0; i < points; ++i) {
    curve[2 * i] = std::sin(3.0 * i / points);
    curve[2 * i + 1] = std::cos(5.0 * i / points);
  }
  EXPECT_LT(smooth_probability(curve), 1e-6);
  EXPECT_EQ(smooth_probability(Eigen::VectorXd::Zero(20)), 1.0);
}

}  // namespace
}  // namespace tendril
