// The search for a point that violates nothing, and what it says where there is none.

#include <gtest/gtest.h>

#include <cmath>

#include "conformance/formula.hpp"
#include "nlp/feasibility.hpp"

namespace tendril {

namespace {

using conformance::Bounds;
using conformance::FormulaProgram;
using conformance::Values;

constexpr double tolerance = 1e-10;

/// An equation, a row with an upper and one with a lower side, bounds of the variables.
struct Between {
  int variables = 3;
  int rows = 3;
  int residuals = 0;
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = x[0];
    out.rows[0] = x[0] * x[0] + x[1] * x[1];
    out.rows[1] = x[0] + x[2];
    out.rows[2] = x[1] * x[2];
  }
  void bounds(Bounds b) const {
    b.row_lower << 4.0, -infinity, 0.5;
    b.row_upper << 4.0, -1.0, infinity;
    b.lower << -1.5, -infinity, -1.0;
    b.upper << infinity, infinity, 2.0;
  }
};

TEST(RestoreFeasibility, FindsAPointThatKeepsEverySide) {
  FormulaProgram<Between> program;
  for (const Eigen::Vector3d& start :
       {Eigen::Vector3d(1.0, 0.5, 0.0), Eigen::Vector3d(-3.0, 2.0, 5.0), Eigen::Vector3d(0.2, -3.0, -0.5)}) {
    const FeasibilityReport report = restore_feasibility(program, start, tolerance);
    EXPECT_TRUE(report.feasible) << start.transpose() << ": " << report.infeasibility;
    EXPECT_FALSE(report.stationary_violation);
    EXPECT_GT(report.iterations, 0);
    EXPECT_LE(report.infeasibility, tolerance);
    const Eigen::VectorXd& x = report.x;
    EXPECT_NEAR(x[0] * x[0] + x[1] * x[1], 4.0, tolerance);
    EXPECT_LE(x[0] + x[2], -1.0 + tolerance);
    EXPECT_GE(x[1] * x[2], 0.5 - tolerance);
    EXPECT_GE(x[0], -1.5);
    EXPECT_GE(x[2], -1.0);
    EXPECT_LE(x[2], 2.0);
  }
}

TEST(RestoreFeasibility, LeavesAFeasiblePointAlone) {
  FormulaProgram<Between> program;
  const double x1 = -std::sqrt(4.0 - 0.25);
  const Eigen::Vector3d start(-0.5, x1, -0.6);
  const FeasibilityReport report = restore_feasibility(program, start, tolerance);
  EXPECT_TRUE(report.feasible);
  EXPECT_EQ(report.iterations, 0);
  EXPECT_EQ(report.x, start);
}

/// No point of the unit disk is beyond the line x0 + x1 = 3.
struct Apart {
  int variables = 2;
  int rows = 2;
  int residuals = 0;
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = x[0];
    out.rows[0] = x[0] * x[0] + x[1] * x[1];
    out.rows[1] = x[0] + x[1];
  }
  void bounds(Bounds b) const {
    b.row_lower << -infinity, 3.0;
    b.row_upper << 1.0, infinity;
  }
};

TEST(RestoreFeasibility, EndsWhereTheViolationIsLeast) {
  FormulaProgram<Apart> program;
  const FeasibilityReport report = restore_feasibility(program, Eigen::Vector2d(0.3, -0.2), tolerance);
  EXPECT_FALSE(report.feasible);
  EXPECT_TRUE(report.stationary_violation);
  // (2 r^2 - 1)^2 + (3 - 2 r)^2 is least at r^3 = 3/4. The search ends where a step gains less than 1e-7 of the squared
  // violation, which is flat along the circle: the violation is good to four digits, the point to the root of 1e-5.
  const double r = std::cbrt(0.75);
  EXPECT_NEAR(report.x[0], r, 3e-3);
  EXPECT_NEAR(report.x[1], r, 3e-3);
  EXPECT_NEAR(report.infeasibility, 3.0 - 2.0 * r, 1e-4);
}

/// The line x0 + x1 = 3 is beyond the box, in which the violation is least in a corner.
template <int sign>
struct Boxed {
  int variables = 2;
  int rows = 1;
  int residuals = 0;
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = x[0];
    out.rows[0] = static_cast<double>(sign) * (x[0] + x[1]);
  }
  void bounds(Bounds b) const {
    b.row_lower[0] = sign > 0 ? 3.0 : -infinity;
    b.row_upper[0] = sign > 0 ? infinity : -3.0;
    b.lower << -1.0, -2.0;
    b.upper << 1.0, 0.5;
  }
};

template <class Formula>
void expect_end(const Eigen::Vector2d& start, const Eigen::Vector2d& end, double violation) {
  FormulaProgram<Formula> program;
  const FeasibilityReport report = restore_feasibility(program, start, tolerance);
  EXPECT_FALSE(report.feasible);
  EXPECT_TRUE(report.stationary_violation);
  EXPECT_EQ(report.x, end) << report.x.transpose();
  EXPECT_EQ(report.infeasibility, violation);
}

TEST(RestoreFeasibility, StaysWithinTheBounds) {
  for (const Eigen::Vector2d& start :
       {Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(7.0, -9.0), Eigen::Vector2d(-1.0, -2.0)}) {
    expect_end<Boxed<1>>(start, {1.0, 0.5}, 1.5);
    expect_end<Boxed<-1>>(start, {1.0, 0.5}, 1.5);
  }
}

/// The same from the other side: the sum is too large at the lower corner.
struct Below {
  int variables = 2;
  int rows = 1;
  int residuals = 0;
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = x[0];
    out.rows[0] = x[0] + x[1];
  }
  void bounds(Bounds b) const {
    b.row_lower[0] = -infinity;
    b.row_upper[0] = -4.0;
    b.lower << -1.0, -2.0;
    b.upper << 1.0, 0.5;
  }
};

TEST(RestoreFeasibility, EndsAtLowerBoundsToo) { expect_end<Below>({0.3, 0.4}, {-1.0, -2.0}, 1.0); }

TEST(RestoreFeasibility, IsStoppedBeforeAStep) {
  FormulaProgram<Between> program;
  const Eigen::Vector3d start(1.0, 0.5, 0.0);
  int asked = 0;
  const FeasibilityReport report = restore_feasibility(program, start, tolerance, 200, [&] { return ++asked >= 1; });
  EXPECT_EQ(report.x, start);
  EXPECT_EQ(report.iterations, 0);
  EXPECT_FALSE(report.feasible);
  EXPECT_FALSE(report.stationary_violation) << "nothing was found out";
}

TEST(RestoreFeasibility, SaysNothingAfterTooFewSteps) {
  FormulaProgram<Between> program;
  const FeasibilityReport report = restore_feasibility(program, Eigen::Vector3d(1.0, 0.5, 0.0), tolerance, 1);
  EXPECT_FALSE(report.feasible);
  EXPECT_FALSE(report.stationary_violation);
  EXPECT_EQ(report.iterations, 2) << "one each way of looking";
}

TEST(RestoreFeasibility, KeepsTheToleranceAskedFor) {
  FormulaProgram<Between> program;
  const Eigen::Vector3d start(1.0, 0.5, 0.0);
  const FeasibilityReport loose = restore_feasibility(program, start, 1e-2);
  const FeasibilityReport tight = restore_feasibility(program, start, 1e-12);
  EXPECT_TRUE(loose.feasible);
  EXPECT_TRUE(tight.feasible);
  EXPECT_LE(loose.infeasibility, 1e-2);
  EXPECT_LE(tight.infeasibility, 1e-12);
  EXPECT_LT(loose.iterations, tight.iterations);
}

}  // namespace

}  // namespace tendril
