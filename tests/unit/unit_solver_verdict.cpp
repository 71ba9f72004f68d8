// What core makes of a backend's word: the judgement of the point and of the multipliers that it hands back.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "conformance/formula.hpp"
#include "scripted_solver.hpp"
#include "support/contains.hpp"
#include "support/print.hpp"

namespace tendril {

namespace {

using conformance::Bounds;
using conformance::FormulaProgram;
using conformance::Values;
using Outcome = ScriptedSolver::Outcome;

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

/// min (x0 - 1)^2 + (x1 - 2)^2  s.t.  x0 + x1 <= 2,  -1 <= x0 x1 <= 5,  0.75 <= x0 <= 3. At (0.75, 1.25) the gradient
/// is (-0.5, -1.5): the first row pushes back with 1.5, the lower bound with -1.
struct CornerFormula {
  int variables = 2;
  int rows = 2;
  int residuals = 2;
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.residuals[0] = x[0] - 1.0;
    out.residuals[1] = x[1] - 2.0;
    out.rows[0] = x[0] + x[1];
    out.rows[1] = x[0] * x[1];
  }
  void bounds(Bounds b) const {
    b.row_lower << -infinity, -1.0;
    b.row_upper << 2.0, 5.0;
    b.lower[0] = 0.75;
    b.upper[0] = 3.0;
  }
};

const std::vector<double> corner_minimum{0.75, 1.25};
const std::vector<double> right_rows{1.5, 0.0};
const std::vector<double> right_bounds{-1.0, 0.0};

template <class Formula>
OptimalityReport solved(const Outcome& outcome, const Eigen::VectorXd& start, const SolveControl& control = {}) {
  FormulaProgram<Formula> program;
  return ScriptedSolver([&](ScriptedSolver::Callbacks&, const ScriptedSolver::Start&) { return outcome; })
      .solve(program, {start, {}, {}}, control);
}

OptimalityReport corner(const Outcome& outcome, const SolveControl& control = {}) {
  return solved<CornerFormula>(outcome, Eigen::Vector2d(1.0, 0.5), control);
}

Outcome claim(SolveStatus status, std::vector<double> x, std::vector<double> rows = {},
              std::vector<double> bounds = {}) {
  Outcome outcome;
  outcome.status = status;
  outcome.native_status = "its own word";
  outcome.x = std::move(x);
  outcome.multipliers = std::move(rows);
  outcome.bound_multipliers = std::move(bounds);
  return outcome;
}

void expect_right_multipliers(const OptimalityReport& report, double accuracy) {
  EXPECT_NEAR(report.multipliers[0], 1.5, accuracy);
  EXPECT_EQ(report.multipliers[1], 0.0);
  EXPECT_NEAR(report.bound_multipliers[0], -1.0, accuracy);
  EXPECT_EQ(report.bound_multipliers[1], 0.0);
}

TEST(SolverVerdict, KeepsTheBackendsMultipliersWhereTheyBalance) {
  const OptimalityReport report = corner(claim(SolveStatus::converged, corner_minimum, right_rows, right_bounds));
  EXPECT_EQ(report.status, SolveStatus::converged) << report.message;
  EXPECT_FALSE(report.multipliers_recovered);
  expect_right_multipliers(report, 0.0);
  EXPECT_EQ(report.stationarity, 0.0);
  EXPECT_EQ(report.infeasibility, 0.0);
  EXPECT_DOUBLE_EQ(report.cost, 0.0625 + 0.5625);
}

TEST(SolverVerdict, KeepsTheBackendsMultipliersWithinTenTolerances) {
  SolveControl control;
  control.tolerance = 1e-3;
  const OptimalityReport near =
      corner(claim(SolveStatus::converged, corner_minimum, {1.505, 0.0}, {-1.005, 0.0}), control);
  EXPECT_FALSE(near.multipliers_recovered);
  EXPECT_NEAR(near.stationarity, 0.005, 1e-15);
  const OptimalityReport far =
      corner(claim(SolveStatus::converged, corner_minimum, {1.52, 0.0}, {-1.02, 0.0}), control);
  EXPECT_TRUE(far.multipliers_recovered);
  expect_right_multipliers(far, 1e-14);
}

TEST(SolverVerdict, RecoversMultipliersThatTheBackendHasNot) {
  const OptimalityReport report = corner(claim(SolveStatus::converged, corner_minimum));
  EXPECT_EQ(report.status, SolveStatus::converged) << report.message;
  EXPECT_TRUE(report.multipliers_recovered);
  expect_right_multipliers(report, 1e-14);
}

TEST(SolverVerdict, DoesNotBelieveMultipliersThatAreWrong) {
  struct Wrong {
    const char* what;
    std::vector<double> rows, bounds;
  };
  for (const auto& [what, rows, bounds] :
       {Wrong{"the sign of the row", {-1.5, 0.0}, {-1.0, 0.0}}, Wrong{"the sign of the bound", {1.5, 0.0}, {1.0, 0.0}},
        Wrong{"a factor of two", {3.0, 0.0}, {-2.0, 0.0}}, Wrong{"rows swapped", {0.0, 1.5}, {-1.0, 0.0}},
        Wrong{"bounds swapped", {1.5, 0.0}, {0.0, -1.0}}, Wrong{"not a number", {unknown, 0.0}, {-1.0, 0.0}},
        Wrong{"not a number among bounds", {1.5, 0.0}, {-1.0, unknown}}, Wrong{"too few", {1.5}, {-1.0, 0.0}},
        Wrong{"no bounds", {1.5, 0.0}, {}}, Wrong{"too many bounds", {1.5, 0.0}, {-1.0, 0.0, 0.0}}}) {
    const OptimalityReport report = corner(claim(SolveStatus::converged, corner_minimum, rows, bounds));
    EXPECT_EQ(report.status, SolveStatus::converged) << what << ": " << report.message;
    EXPECT_TRUE(report.multipliers_recovered) << what;
    expect_right_multipliers(report, 1e-14);
    EXPECT_LT(report.stationarity, 1e-14) << what;
  }
}

// A multiplier of what is not active counts for nothing, and the rest is judged as it is.
TEST(SolverVerdict, SetsMultipliersOfInactiveRowsToZero) {
  const OptimalityReport report = corner(claim(SolveStatus::converged, corner_minimum, {1.5, 0.1}, {-1.0, 0.1}));
  EXPECT_FALSE(report.multipliers_recovered);
  expect_right_multipliers(report, 0.0);
}

/// min x^2  s.t.  -1 <= x <= 1, once as a row and once as bounds: at x = 1 and x = -1 nothing can pull inwards.
template <bool as_row>
struct Inward {
  int variables = 1;
  int rows = 1;
  int residuals = 1;
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.residuals[0] = x[0];
    out.rows[0] = x[0];
  }
  void bounds(Bounds b) const {
    b.row_lower[0] = as_row ? -1.0 : -2.0;
    b.row_upper[0] = as_row ? 1.0 : 2.0;
    b.lower[0] = as_row ? -2.0 : -1.0;
    b.upper[0] = as_row ? 2.0 : 1.0;
  }
};

// Multipliers that would balance the gradient if only they pushed the other way.
TEST(SolverVerdict, NoMultiplierPullsInwards) {
  for (const double x : {1.0, -1.0}) {
    const OptimalityReport row =
        solved<Inward<true>>(claim(SolveStatus::converged, {x}, {-2.0 * x}, {0.0}), Eigen::VectorXd::Zero(1));
    EXPECT_EQ(row.status, SolveStatus::stalled) << x;
    EXPECT_EQ(row.stationarity, 2.0) << x;
    const OptimalityReport bound =
        solved<Inward<false>>(claim(SolveStatus::converged, {x}, {0.0}, {-2.0 * x}), Eigen::VectorXd::Zero(1));
    EXPECT_EQ(bound.status, SolveStatus::stalled) << x;
    EXPECT_EQ(bound.stationarity, 2.0) << x;
  }
}

/// Along the first row by d from the minimum, with no bound in the way, the gradient is 2 d off.
struct LineFormula : CornerFormula {
  void bounds(Bounds b) const {
    CornerFormula::bounds(b);
    b.lower[0] = -3.0;
  }
};

TEST(SolverVerdict, BelievesSuccessOnlyWhereTheGradientVanishes) {
  const auto beside = [](double d) {
    return solved<LineFormula>(claim(SolveStatus::converged, {0.5 + d, 1.5 - d}), Eigen::Vector2d(0.0, 0.0));
  };
  const OptimalityReport near = beside(2.5e-5);
  EXPECT_EQ(near.status, SolveStatus::converged) << near.message;
  EXPECT_NEAR(near.stationarity, 5e-5, 1e-9);
  const OptimalityReport far = beside(1e-4);
  EXPECT_EQ(far.status, SolveStatus::stalled);
  EXPECT_EQ(far.message, "the backend claims success where the Lagrangian's gradient is 0.0002");
  EXPECT_EQ(far.native_status, "its own word");
}

TEST(SolverVerdict, BelievesSuccessOnlyWhereTheRowsHold) {
  const auto beyond = [](double d) { return corner(claim(SolveStatus::converged, {0.75, 1.25 + d})); };
  const OptimalityReport near = beyond(5e-7);
  EXPECT_EQ(near.status, SolveStatus::converged) << near.message;
  EXPECT_NEAR(near.infeasibility, 5e-7, 1e-12);
  const OptimalityReport far = beyond(2e-6);
  EXPECT_EQ(far.status, SolveStatus::stalled);
  EXPECT_EQ(far.message, "the backend claims success at a point that violates its rows by 2e-06");
}

TEST(SolverVerdict, ALooseToleranceLoosensBothTests) {
  SolveControl control;
  control.tolerance = 1e-4;
  const OptimalityReport rows = corner(claim(SolveStatus::converged, {0.75, 1.2505}), control);
  EXPECT_EQ(rows.status, SolveStatus::converged) << rows.message;
  const OptimalityReport slope =
      solved<LineFormula>(claim(SolveStatus::converged, {0.5003, 1.4997}), Eigen::Vector2d(0.0, 0.0), control);
  EXPECT_EQ(slope.status, SolveStatus::converged) << slope.message;
}

/// A gradient a thousand times as large is known to as many digits less.
struct Steep {
  int variables = 1;
  int rows = 1;
  int residuals = 0;
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = 1000.0 * x[0] + 500.0 * (x[0] - 1.0) * (x[0] - 1.0);
    out.rows[0] = x[0];
  }
  void bounds(Bounds b) const { b.row_upper[0] = infinity, b.row_lower[0] = -infinity; }
};

TEST(SolverVerdict, MeasuresTheGradientAgainstTheCostsOwn) {
  // The cost is 500 x^2 + 500: at x the gradient is 1000 x, and nothing balances it.
  const OptimalityReport far = solved<Steep>(claim(SolveStatus::converged, {1.0}), Eigen::VectorXd::Zero(1));
  EXPECT_EQ(far.status, SolveStatus::stalled);
  EXPECT_NEAR(far.stationarity, 1000.0, 1e-9);
  // A gradient of 0.9e-4 is below 1e-4 * 1; one of 1.1e-4 above.
  EXPECT_EQ(solved<Steep>(claim(SolveStatus::converged, {0.9e-7}), Eigen::VectorXd::Zero(1)).status,
            SolveStatus::converged);
  EXPECT_EQ(solved<Steep>(claim(SolveStatus::converged, {1.1e-7}), Eigen::VectorXd::Zero(1)).status,
            SolveStatus::stalled);
}

/// No point of the unit disk is beyond the line x0 + x1 = 3.
struct ApartFormula {
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

/// The same with the disk's part played by the upper bounds of the variables, and by rows beyond their upper side.
struct BoxedFormula {
  int variables = 2;
  int rows = 1;
  int residuals = 0;
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = x[0];
    out.rows[0] = -1.0 * x[0] - x[1];
  }
  void bounds(Bounds b) const {
    b.row_lower[0] = -infinity;
    b.row_upper[0] = -3.0;
    b.lower.setZero();
    b.upper.setOnes();
  }
};

TEST(SolverVerdict, KnowsAStationaryPointOfTheViolation) {
  const double r = std::sqrt(0.5);
  for (const SolveStatus said : {SolveStatus::converged, SolveStatus::stalled, SolveStatus::failed}) {
    const OptimalityReport report = solved<ApartFormula>(claim(said, {r, r}), Eigen::Vector2d(0.3, -0.2));
    EXPECT_EQ(report.status, SolveStatus::infeasible) << "the backend said " << to_string(said);
    EXPECT_EQ(report.message, "stopped at a stationary point of the violation, which is 1.59 there");
    EXPECT_EQ(solved<BoxedFormula>(claim(said, {1.0, 1.0}), Eigen::Vector2d(0.3, 0.2)).status, SolveStatus::infeasible)
        << "the backend said " << to_string(said);
  }
}

TEST(SolverVerdict, ViolatedRowsAreNotInfeasibleWhereTheViolationCanFall) {
  // On the circle, but not where it is nearest to the line.
  EXPECT_EQ(solved<ApartFormula>(claim(SolveStatus::stalled, {1.0, 0.0}), Eigen::Vector2d(0.3, -0.2)).status,
            SolveStatus::stalled);
  // The bounds at (0, 0) and (1, 0) hold back the wrong way, or only one of two ways.
  for (const std::vector<double>& x : {std::vector<double>{0.0, 0.0}, std::vector<double>{1.0, 0.0}}) {
    EXPECT_EQ(solved<BoxedFormula>(claim(SolveStatus::stalled, x), Eigen::Vector2d(0.3, 0.2)).status,
              SolveStatus::stalled)
        << x[0];
  }
}

TEST(SolverVerdict, LimitsAndReasonsOfTheBackendStand) {
  const double r = std::sqrt(0.5);
  for (const SolveStatus said : {SolveStatus::iteration_limit, SolveStatus::time_limit, SolveStatus::interrupted,
                                 SolveStatus::diverged, SolveStatus::not_finite, SolveStatus::unsupported}) {
    EXPECT_EQ(solved<ApartFormula>(claim(said, {r, r}), Eigen::Vector2d(0.3, -0.2)).status, said);
  }
  Outcome failed = claim(SolveStatus::failed, {r, r});
  failed.message = "out of memory";
  const OptimalityReport report = solved<ApartFormula>(failed, Eigen::Vector2d(0.3, -0.2));
  EXPECT_EQ(report.status, SolveStatus::failed);
  EXPECT_EQ(report.message, "out of memory");
}

}  // namespace

}  // namespace tendril
