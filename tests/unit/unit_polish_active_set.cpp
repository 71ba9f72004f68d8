// The active set of the polish: what is added, what is dropped, and the multipliers of either side.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "conformance/formula.hpp"
#include "nlp/polish.hpp"

namespace tendril {

namespace {

using conformance::Bounds;
using conformance::FormulaProgram;
using conformance::Values;

/// min |x - t|^2, t = (0, 2, 0, 2, 3, 5, 1): a row at its lower side, one at its upper, a lower and an upper bound, an
/// equation x4 + x5 = 1 and a fixed variable; the last row idles.
struct Sides {
  int variables = 7;
  int rows = 4;
  int residuals = 7;
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    const double t[] = {0.0, 2.0, 0.0, 2.0, 3.0, 5.0, 1.0};
    for (std::size_t i = 0; i < 7; ++i) out.residuals[i] = x[i] - t[i];
    out.rows[0] = x[0];
    out.rows[1] = x[1];
    out.rows[2] = x[4] + x[5];
    out.rows[3] = x[0] + x[1];
  }
  void bounds(Bounds b) const {
    b.row_lower << 1.0, -3.0, 1.0, -9.0;
    b.row_upper << 4.0, 1.0, 1.0, 9.0;
    b.lower << -infinity, -infinity, 1.0, -3.0, -infinity, -infinity, 0.3;
    b.upper << infinity, infinity, 4.0, 1.0, infinity, infinity, 0.3;
  }
};

Eigen::VectorXd vector(std::initializer_list<double> values) {
  Eigen::VectorXd v(static_cast<Eigen::Index>(values.size()));
  std::copy(values.begin(), values.end(), v.begin());
  return v;
}

const Eigen::VectorXd minimum = vector({1.0, 1.0, 1.0, 1.0, -0.5, 1.5, 0.3});
const Eigen::VectorXd multipliers = vector({-2.0, 2.0, 7.0, 0.0});
const Eigen::VectorXd bound_multipliers = vector({0.0, 0.0, -2.0, 2.0, 0.0, 0.0, 1.4});

void expect_minimum(const PolishReport& report) {
  ASSERT_TRUE(report.converged) << report.reason;
  // A quadratic program in small numbers: rounding only.
  constexpr double accuracy = 1e-12;
  EXPECT_LT((report.x - minimum).lpNorm<Eigen::Infinity>(), accuracy) << report.x.transpose();
  EXPECT_LT((report.multipliers - multipliers).lpNorm<Eigen::Infinity>(), accuracy) << report.multipliers.transpose();
  EXPECT_LT((report.bound_multipliers - bound_multipliers).lpNorm<Eigen::Infinity>(), accuracy)
      << report.bound_multipliers.transpose();
  EXPECT_LT(report.infeasibility, accuracy);
  EXPECT_LT(report.stationarity, accuracy);
}

TEST(PolishActiveSet, IsRightWhereTheStartIsNear) {
  FormulaProgram<Sides> program;
  const Eigen::VectorXd off = vector({1e-6, -1e-6, 1e-6, -1e-6, 0.2, -0.3, 0.0});
  expect_minimum(polish(program, minimum + off, {}));
  expect_minimum(polish(program, minimum + off, multipliers));
}

TEST(PolishActiveSet, GrowsByWhatIsViolated) {
  FormulaProgram<Sides> program;
  const Eigen::VectorXd start = vector({2.0, 0.0, 2.0, 0.0, 1.0, 1.0, 0.3});
  const PolishReport report = polish(program, start, {});
  expect_minimum(report);
}

TEST(PolishActiveSet, LosesWhatHasAMultiplierOfTheWrongSign) {
  FormulaProgram<Sides> program;
  // Every row and bound at its other side, where nothing pushes.
  const Eigen::VectorXd start = vector({4.0, -3.0, 4.0, -3.0, 1.0, 1.0, 0.3});
  expect_minimum(polish(program, start, {}));
}

TEST(PolishActiveSet, MovesTheStartOntoTheBounds) {
  FormulaProgram<Sides> program;
  expect_minimum(polish(program, vector({2.0, 0.0, -8.0, 8.0, 1.0, 1.0, 5.0}), {}));
}

/// min (x - t)^2  s.t.  0 <= x <= 1 as a row.
struct Line {
  int variables = 1;
  int rows = 1;
  int residuals = 1;
  double t = 0.0;
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.residuals[0] = x[0] - t;
    out.rows[0] = x[0];
  }
  void bounds(Bounds b) const { b.row_lower[0] = 0.0, b.row_upper[0] = 1.0; }
};

/// Newton steps that the polish took.
int step_count(double target, double start, const Eigen::VectorXd& given, double expected) {
  Line line;
  line.t = target;
  FormulaProgram<Line> program(line);
  const PolishReport report = polish(program, Eigen::VectorXd::Constant(1, start), given);
  EXPECT_TRUE(report.converged) << report.reason;
  EXPECT_NEAR(report.x[0], expected, 1e-12);
  return report.iterations;
}

TEST(PolishActiveSet, BelievesAMultiplierOfZero) {
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(1);
  // A hair inside a side that does not push: with its multiplier known to be 0 it is not even tried.
  EXPECT_EQ(step_count(0.5, 1e-6, none, 0.5), 1);
  EXPECT_EQ(step_count(0.5, 1.0 - 1e-6, none, 0.5), 1);
  EXPECT_GT(step_count(0.5, 1e-6, {}, 0.5), 1);
  EXPECT_GT(step_count(0.5, 1.0 - 1e-6, {}, 0.5), 1);
}

TEST(PolishActiveSet, SaysWhyItGaveUp) {
  FormulaProgram<Sides> program;
  const Eigen::VectorXd start = vector({4.0, -3.0, 4.0, -3.0, 1.0, 1.0, 0.3});
  PolishOptions options;
  options.max_iterations = 2;
  const PolishReport few = polish(program, start, {}, options);
  EXPECT_FALSE(few.converged);
  EXPECT_STREQ(few.reason, "too many steps");
  options = {};
  options.stop = [] { return true; };
  const PolishReport stopped = polish(program, start, {}, options);
  EXPECT_FALSE(stopped.converged);
  EXPECT_STREQ(stopped.reason, "stopped");
  EXPECT_EQ(stopped.x[0], 4.0);
}

/// No number beyond x = 1.
struct SteepCliff {
  int variables = 1;
  int rows = 0;
  int residuals = 0;
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    using std::sqrt;
    out.rest = -10.0 * x[0] - 4.0 * sqrt(1.0 - x[0]);
  }
  void bounds(Bounds) const {}
};

TEST(PolishActiveSet, ShortensItsStepWhereThereIsNoNumber) {
  FormulaProgram<SteepCliff> program;
  const PolishReport report = polish(program, Eigen::VectorXd::Constant(1, 0.9), {});
  EXPECT_TRUE(report.converged) << report.reason;
  EXPECT_NEAR(report.x[0], 0.96, 1e-9);
  const PolishReport beyond = polish(program, Eigen::VectorXd::Constant(1, 2.0), {});
  EXPECT_FALSE(beyond.converged);
  EXPECT_STREQ(beyond.reason, "a value is not finite");
}

/// Two rows that cannot hold together, one of each side.
struct Clash {
  int variables = 1;
  int rows = 2;
  int residuals = 1;
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.residuals[0] = x[0];
    out.rows[0] = x[0];
    out.rows[1] = 2.0 * x[0];
  }
  void bounds(Bounds b) const {
    b.row_lower << 1.0, -infinity;
    b.row_upper << infinity, 1.0;
  }
};

TEST(PolishActiveSet, DoesNotConvergeWhereRowsContradictEachOther) {
  FormulaProgram<Clash> program;
  for (const double start : {-1.0, 0.4, 0.7, 3.0}) {
    const PolishReport report = polish(program, Eigen::VectorXd::Constant(1, start), {});
    EXPECT_FALSE(report.converged) << start;
    EXPECT_STRNE(report.reason, "") << start;
  }
}

TEST(PolishActiveSet, OnePolisherTakesProgramsOfEverySize) {
  Polisher polisher;
  FormulaProgram<Sides> large;
  FormulaProgram<SteepCliff> small;
  const Eigen::VectorXd start = vector({2.0, 0.0, 2.0, 0.0, 1.0, 1.0, 0.3});
  expect_minimum(polisher.run(large, start, {}));
  EXPECT_NEAR(polisher.run(small, Eigen::VectorXd::Constant(1, 0.9), {}).x[0], 0.96, 1e-9);
  expect_minimum(polisher.run(large, start, {}));
}

}  // namespace

}  // namespace tendril
