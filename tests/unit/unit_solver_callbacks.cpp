// The program as a backend sees it: where it was best, where its cost has no lower bound, and the polish on the way.

#include <gtest/gtest.h>

#include <vector>

#include "conformance/formula.hpp"
#include "scripted_solver.hpp"
#include "support/print.hpp"

namespace tendril {

namespace {

using conformance::Bounds;
using conformance::FormulaProgram;
using conformance::Values;
using Callbacks = ScriptedSolver::Callbacks;
using Start = ScriptedSolver::Start;
using Outcome = ScriptedSolver::Outcome;

/// A line without end.
struct Falling {
  int variables = 1;
  int rows = 0;
  int residuals = 0;
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = -1e10 * x[0];
  }
  void bounds(Bounds) const {}
};

TEST(SolverCallbacks, EndWhereTheCostHasNoLowerBound) {
  const auto at = [](double x) {
    FormulaProgram<Falling> program;
    return ScriptedSolver([x](Callbacks& callbacks, const Start&) {
             callbacks.cost(Eigen::VectorXd::Constant(1, x));
             Outcome outcome;
             outcome.status = SolveStatus::iteration_limit;
             return outcome;
           })
        .solve(program, {Eigen::VectorXd::Zero(1), {}, {}}, {});
  };
  const OptimalityReport low = at(2e10);
  EXPECT_EQ(low.status, SolveStatus::diverged);
  EXPECT_EQ(low.message, "the cost fell to -2e+20: it has no lower bound");
  EXPECT_EQ(at(0.5e10).status, SolveStatus::iteration_limit);
}

/// Costs and violations are those of x alone: min x0  s.t.  x1 = 0.
struct Plain {
  int variables = 2;
  int rows = 1;
  int residuals = 0;
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = x[0];
    out.rows[0] = x[1];
  }
  void bounds(Bounds) const {}
};

/// Where a solve ends whose backend only tried these points, with the violation 0.1 at the start.
Eigen::Vector2d best_of(const std::vector<Eigen::Vector2d>& points, double tolerance = 1e-9) {
  FormulaProgram<Plain> program;
  SolveControl control;
  control.tolerance = tolerance;
  return ScriptedSolver([&](Callbacks& callbacks, const Start&) {
           for (const Eigen::Vector2d& x : points) callbacks.cost(x);
           Outcome outcome;
           outcome.status = SolveStatus::iteration_limit;
           const Eigen::VectorXd best = callbacks.best_x();
           EXPECT_EQ(best.size(), 2);
           return outcome;
         })
      .solve(program, {Eigen::Vector2d(5.0, 0.1), {}, {}}, control)
      .x;
}

TEST(SolverCallbacks, RememberThePointThatViolatesLeastAndThenCostsLeast) {
  using V = Eigen::Vector2d;
  EXPECT_EQ(best_of({}), V(5.0, 0.1));
  EXPECT_EQ(best_of({V(1.0, 0.2)}), V(5.0, 0.1)) << "cheaper, but it violates more";
  EXPECT_EQ(best_of({V(9.0, 0.01), V(1.0, 0.2)}), V(9.0, 0.01)) << "dearer, but it violates less";
  EXPECT_EQ(best_of({V(9.0, -0.01), V(7.0, 0.01), V(8.0, 0.01)}), V(7.0, 0.01)) << "as much on either side";
  // Violations below a tenth of the tolerance are equal; above they count.
  EXPECT_EQ(best_of({V(3.0, 0.0), V(2.0, 0.9e-3), V(2.5, 0.0)}, 1e-2), V(2.0, 0.9e-3));
  EXPECT_EQ(best_of({V(3.0, 0.0), V(2.0, 1.1e-3)}, 1e-2), V(3.0, 0.0));
}

/// A minimum at x1 = 2 of x0 = 1, a saddle at (1, 0) and a minimum at x1 = -2.
struct Saddle {
  int variables = 2;
  int rows = 1;
  int residuals = 0;
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = 2.0 * x[0] + (x[1] * x[1] - 4.0) * (x[1] * x[1] - 4.0);
    out.rows[0] = x[0];
  }
  void bounds(Bounds b) const { b.row_lower[0] = 1.0, b.row_upper[0] = infinity; }
};

TEST(SolverCallbacks, PolishTakesAMinimumAndLeavesASaddle) {
  const auto polished = [](Eigen::Vector2d x, bool expected) {
    FormulaProgram<Saddle> program;
    Eigen::VectorXd at = x;
    Eigen::VectorXd rows = Eigen::VectorXd::Constant(1, -2.0);
    Eigen::VectorXd bounds = Eigen::VectorXd::Zero(2);
    ScriptedSolver([&](Callbacks& callbacks, const Start&) {
      EXPECT_EQ(callbacks.polish(at, rows, bounds, 1e-2), expected);
      return converged_at({at[0], at[1]});
    }).solve(program, {x, {}, {}}, {});
    EXPECT_EQ(rows[0], -2.0);
    return at;
  };
  const Eigen::VectorXd minimum = polished({1.001, 2.01}, true);
  EXPECT_NEAR(minimum[0], 1.0, 1e-12);
  EXPECT_NEAR(minimum[1], 2.0, 1e-9);
  EXPECT_EQ(polished({1.001, 0.01}, false), Eigen::Vector2d(1.001, 0.01));
}

TEST(SolveStatus, HasTheNamesThatResultsWrite) {
  const std::pair<SolveStatus, const char*> names[] = {
      {SolveStatus::converged, "converged"},     {SolveStatus::iteration_limit, "iteration_limit"},
      {SolveStatus::time_limit, "time_limit"},   {SolveStatus::interrupted, "interrupted"},
      {SolveStatus::infeasible, "infeasible"},   {SolveStatus::diverged, "diverged"},
      {SolveStatus::stalled, "stalled"},         {SolveStatus::not_finite, "not_finite"},
      {SolveStatus::unsupported, "unsupported"}, {SolveStatus::failed, "failed"}};
  for (const auto& [status, name] : names) EXPECT_EQ(to_string(status), name);
}

}  // namespace

}  // namespace tendril
