// Newton on the conditions of first order, down to what rounding leaves of a row.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "nlp/polish.hpp"

namespace tendril {

namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();

/// min (x0 - 1)^2 + x1^2  s.t.  slope (x0^2 + x1^2 - 2) = 0, and with `second` the same with 2 + apart in place of 2.
/// Rounding leaves some slope * eps of the row.
class Ring : public NonlinearProgram {
 public:
  explicit Ring(double slope, bool second = false, double apart = 0.0)
      : NonlinearProgram(2, second ? 2 : 1, 0), slope_(slope), apart_(apart) {
    row_lower_.setZero();
    row_upper_.setZero();
  }
  void keep_above(double second) { lower_[1] = second; }

 protected:
  void do_evaluate(ConstVectorRef x, bool derivatives, Workspace& out) override {
    out.cost = out.rest = (x[0] - 1.0) * (x[0] - 1.0) + x[1] * x[1];
    for (int i = 0; i < row_count(); ++i) {
      out.constraints[i] = slope_ * (x.squaredNorm() - (i == 0 ? 2.0 : 2.0 + apart_));
    }
    if (!derivatives) return;
    out.gradient << 2.0 * (x[0] - 1.0), 2.0 * x[1];
    out.rest_gradient = out.gradient;
    for (int i = 0; i < row_count(); ++i) out.jacobian.row(i) = 2.0 * slope_ * x.transpose();
  }
  void do_hessian(ConstVectorRef, double sigma, ConstVectorRef multipliers, Workspace& out) override {
    out.hessian.setZero();
    out.hessian.diagonal().array() = 2.0 * sigma + 2.0 * slope_ * multipliers.sum();
  }

 private:
  double slope_, apart_;
};

/// |J| |x| of the row at the solution (sqrt(2), 0): what a unit roundoff of every variable is multiplied with.
double amplified(double slope) { return 2.0 * slope * 2.0; }

TEST(Polish, ReachesItsToleranceWhereRoundingAllowsIt) {
  Ring program(1.0);
  const PolishReport report = polish(program, Eigen::Vector2d(1.3, 0.1), {});
  EXPECT_TRUE(report.converged) << report.reason;
  EXPECT_LE(report.infeasibility, PolishOptions{}.row_tolerance);
  EXPECT_NEAR(report.x[0], std::sqrt(2.0), 1e-12);
  EXPECT_NEAR(report.x[1], 0.0, 1e-12);
}

// Beside an obstacle of radius 1e-6 L a row has such a slope. Its tolerance of 1e-12 is out of reach of any double.
TEST(Polish, IsContentAtTheFloorOfRounding) {
  for (const double slope : {1e5, 1e6, 1e7}) {
    Ring program(slope);
    const PolishReport report = polish(program, Eigen::Vector2d(1.3, 0.1), {});
    EXPECT_TRUE(report.converged) << slope << ": " << report.reason << ", " << report.infeasibility;
    EXPECT_LE(report.infeasibility, eps * amplified(slope)) << slope;
    EXPECT_NEAR(report.x[0], std::sqrt(2.0), 4.0 * eps) << slope;
  }
}

// The floor belongs to the row's own slope: what is farther off than rounding explains is no solution.
TEST(Polish, TakesNoDefectForRounding) {
  for (const double slope : {1.0, 1e6}) {
    // Both rows cannot hold; the better of the points between them violates one by half of what they are apart.
    const double apart = 1e3 * eps * amplified(slope) / slope + 1e-10;
    Ring program(slope, true, apart);
    const PolishReport report = polish(program, Eigen::Vector2d(1.3, 0.1), {});
    EXPECT_FALSE(report.converged) << slope;
    EXPECT_GE(report.infeasibility, 0.4 * slope * apart) << slope;
  }
}

// On the ring the objective is largest at (-sqrt(2), 0), where the conditions of first order hold as well.
TEST(Polish, EndsAtNoMaximumWhereItDescends) {
  Ring program(1.0);
  PolishOptions descending;
  descending.descends = true;
  const Eigen::Vector2d top(-std::sqrt(2.0), 0.0);
  EXPECT_TRUE(polish(program, top, {}).converged);
  const PolishReport held = polish(program, top, {}, descending);
  EXPECT_FALSE(held.converged);
  EXPECT_STREQ(held.reason, "no minimum");
  const PolishReport beside = polish(program, Eigen::Vector2d(-1.4, 0.2), {}, descending);
  EXPECT_TRUE(!beside.converged || beside.x[0] > 0.0) << beside.x.transpose();
}

TEST(Polish, DescendsFromAfarToTheBoundInItsWay) {
  PolishOptions descending;
  descending.descends = true;
  for (const double bound : {-2.0, 0.5, 1.0}) {
    Ring program(1.0);
    program.keep_above(bound);
    const PolishReport report = polish(program, Eigen::Vector2d(0.7, 1.25), {}, descending);
    EXPECT_TRUE(report.converged) << bound << ": " << report.reason;
    const double second = std::max(0.0, bound);
    EXPECT_NEAR(report.x[1], second, 1e-12) << bound;
    EXPECT_NEAR(report.x[0], std::sqrt(2.0 - second * second), 1e-12) << bound;
  }
}

}  // namespace

}  // namespace tendril
