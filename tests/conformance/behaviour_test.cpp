#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>

#include "known_problems.hpp"
#include "solvers.hpp"
#include "support/clock.hpp"
#include "support/contains.hpp"
#include "support/print.hpp"

namespace tendril::conformance {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// A known problem with something done to it before or after each evaluation.
template <class Formula>
class Disturbed : public FormulaProgram<Formula> {
 public:
  using Workspace = typename FormulaProgram<Formula>::Workspace;
  using Hook = std::function<void(int evaluation, ConstVectorRef x, double& cost, Eigen::VectorXd& rows)>;

  explicit Disturbed(Hook hook) : hook_(std::move(hook)) {}
  std::string row_name(int row) const override { return "spring row " + std::to_string(row + 1); }
  int evaluations() const { return evaluations_; }

 protected:
  void do_evaluate(ConstVectorRef x, bool derivatives, Workspace& out) override {
    FormulaProgram<Formula>::do_evaluate(x, derivatives, out);
    const double before = out.cost;
    hook_(++evaluations_, x, out.cost, out.constraints);
    if (!(out.cost == before)) out.rest += out.cost - before;
  }

 private:
  Hook hook_;
  int evaluations_ = 0;
};

/// min (x0 - 1)^2 + 10 (x1 - x0^2)^2  s.t.  x0 + x1 <= 3,  x0 x1 >= -4
struct Valley {
  int variables = 2;
  int rows = 2;
  int residuals = 2;
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.residuals[0] = x[0] - 1.0;
    out.residuals[1] = std::sqrt(10.0) * (x[1] - x[0] * x[0]);
    out.rows[0] = x[0] + x[1];
    out.rows[1] = x[0] * x[1];
  }
  void bounds(Bounds b) const {
    b.row_lower << -infinity, -4.0;
    b.row_upper << 3.0, infinity;
  }
};

Eigen::Vector2d valley_start() { return {-1.2, 1.5}; }

/// No point of the unit disk is beyond the line x0 + x1 = 3; the violation is least at x0 = x1.
struct Contradictory {
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

struct Bottomless {
  int variables = 2;
  int rows = 1;
  int residuals = 0;
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = -1.0 * x[0] * x[0] * x[0] + x[1] * x[1];
    out.rows[0] = x[0] - x[1];
  }
  void bounds(Bounds b) const {
    b.row_lower[0] = 0.0;
    b.row_upper[0] = infinity;
    b.lower[0] = 0.0;
  }
};

/// The minimum at x = 0.96 is near x = 1, beyond which there is no number.
struct Cliff {
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

class Behaviour : public testing::TestWithParam<std::string> {
 protected:
  std::unique_ptr<Solver> solver() const { return make_solver(GetParam()); }

  template <class Program>
  OptimalityReport solve(Program& program, const Eigen::VectorXd& start, const SolveControl& control = {}) const {
    return solver()->solve(program, {start, {}, {}}, control);
  }

  /// Known failures are listed, not skipped.
  void expect(bool holds, const std::string& test, const OptimalityReport& report) const {
    const std::string reason = expected_failure(GetParam(), test);
    const std::string ended =
        std::string(to_string(report.status)) + " (" + report.native_status + ") '" + report.message + "'";
    if (reason.empty()) {
      EXPECT_TRUE(holds) << GetParam() << ": " << test << " ended as " << ended;
    } else {
      EXPECT_FALSE(holds) << GetParam() << " passes '" << test << "': take it out of the table (" << reason << ")";
    }
  }
};

const Disturbed<Valley>::Hook undisturbed = [](int, ConstVectorRef, double&, Eigen::VectorXd&) {};

TEST_P(Behaviour, WarmStartTakesFewerIterationsThanColdStart) {
  const KnownProblem& problem = *std::find_if(hock_schittkowski().begin(), hock_schittkowski().end(),
                                              [](const KnownProblem& p) { return p.name == "hs071"; });
  const auto program = problem.make();
  const auto backend = solver();
  const OptimalityReport cold = backend->solve(*program, {problem.start, {}, {}}, {});
  ASSERT_EQ(problem.check(cold), "");
  const OptimalityReport warm = backend->solve(*program, {cold.x, cold.multipliers, cold.bound_multipliers}, {});
  EXPECT_EQ(problem.check(warm), "");
  EXPECT_LT(warm.iterations, cold.iterations);
}

TEST_P(Behaviour, MultipliersHaveTheSignsOfTheOneConvention) {
  // At (1, 4.74, 3.82, 1.38) the product row is at its lower and the first variable at its lower bound; published in
  // the documentation of several solvers: 0.5523, 0.1615 and 1.0879.
  const KnownProblem& problem = *std::find_if(hock_schittkowski().begin(), hock_schittkowski().end(),
                                              [](const KnownProblem& p) { return p.name == "hs071"; });
  const auto program = problem.make();
  const OptimalityReport report = solve(*program, problem.start);
  ASSERT_EQ(problem.check(report), "");
  // Multipliers are as accurate as the point is stationary, some 1e-7.
  EXPECT_NEAR(report.multipliers[0], -0.55229, 1e-4);
  EXPECT_NEAR(report.multipliers[1], 0.16147, 1e-4);
  EXPECT_NEAR(report.bound_multipliers[0], -1.08787, 1e-4);
}

TEST_P(Behaviour, FixedVariablesStayAndCountAsStationary) {
  class Fixed : public FormulaProgram<Valley> {
   public:
    Fixed() { lower_[0] = upper_[0] = 0.5; }
  };
  Fixed program;
  const OptimalityReport report = solve(program, valley_start());
  EXPECT_EQ(report.status, SolveStatus::converged) << report.native_status << report.message;
  EXPECT_NEAR(report.x[0], 0.5, 1e-9);
  EXPECT_NEAR(report.x[1], 0.25, 1e-6);
  EXPECT_LT(report.stationarity, 1e-5);
}

TEST_P(Behaviour, InfeasibleProgramIsNeverCalledSolved) {
  FormulaProgram<Contradictory> program;
  const OptimalityReport report = solve(program, Eigen::Vector2d(0.3, -0.2));
  EXPECT_NE(report.status, SolveStatus::converged);
  EXPECT_GT(report.infeasibility, 0.1);
  expect(report.status == SolveStatus::infeasible, "infeasible", report);
}

TEST_P(Behaviour, ContradictoryBoundsAreNamed) {
  class Crossed : public FormulaProgram<Valley> {
   public:
    Crossed() { lower_[1] = 2.0, upper_[1] = 1.0; }
    std::string variable_name(int i) const override { return "knob " + std::to_string(i); }
  };
  Crossed program;
  const OptimalityReport report = solve(program, valley_start());
  EXPECT_EQ(report.status, SolveStatus::infeasible);
  EXPECT_TRUE(contains_text(report.message, "knob 1"));
}

TEST_P(Behaviour, UnboundedProgramIsNeverCalledSolved) {
  FormulaProgram<Bottomless> program;
  const OptimalityReport report = solve(program, Eigen::Vector2d(1.0, 0.5));
  EXPECT_NE(report.status, SolveStatus::converged);
  expect(report.status == SolveStatus::diverged, "unbounded", report);
}

TEST_P(Behaviour, NanAtTheStartNamesTheRow) {
  Disturbed<Valley> program([](int, ConstVectorRef, double&, Eigen::VectorXd& rows) { rows[1] = nan; });
  const OptimalityReport report = solve(program, valley_start());
  EXPECT_EQ(report.status, SolveStatus::not_finite);
  EXPECT_TRUE(contains_text(report.message, "spring row 2"));
}

TEST_P(Behaviour, InfiniteCostAtTheStartNamesTheCost) {
  Disturbed<Valley> program([](int, ConstVectorRef, double& cost, Eigen::VectorXd&) { cost = infinity; });
  const OptimalityReport report = solve(program, valley_start());
  EXPECT_EQ(report.status, SolveStatus::not_finite);
  EXPECT_TRUE(contains_text(report.message, "cost"));
}

TEST_P(Behaviour, NanInTheStartItselfNamesTheVariable) {
  FormulaProgram<Valley> program;
  const OptimalityReport report = solve(program, Eigen::Vector2d(1.0, nan));
  EXPECT_EQ(report.status, SolveStatus::not_finite);
  EXPECT_TRUE(contains_text(report.message, "variable 2"));
}

TEST_P(Behaviour, NanBeyondACliffShortensTheStep) {
  FormulaProgram<Cliff> program;
  const OptimalityReport report = solve(program, Eigen::VectorXd::Constant(1, 0.1));
  expect(report.status == SolveStatus::converged && std::abs(report.x[0] - 0.96) < 1e-6, "cliff", report);
  EXPECT_TRUE(report.status == SolveStatus::converged || report.status == SolveStatus::not_finite)
      << report.native_status;
}

TEST_P(Behaviour, NanEverywhereButAtTheStartEndsAsNotFinite) {
  const Eigen::Vector2d start = valley_start();
  Disturbed<Valley> program([start](int, ConstVectorRef x, double& cost, Eigen::VectorXd&) {
    if (x != start) cost = nan;
  });
  const OptimalityReport report = solve(program, start);
  EXPECT_EQ(report.status, SolveStatus::not_finite) << report.native_status << report.message;
  EXPECT_TRUE(contains_text(report.message, "cost"));
  EXPECT_EQ(report.x, start);
}

TEST_P(Behaviour, ExceptionAtTheStartReachesTheCaller) {
  Disturbed<Valley> program([](int, ConstVectorRef, double&, Eigen::VectorXd&) {
    throw std::runtime_error("term 'spring' has no stiffness");
  });
  const OptimalityReport report = solve(program, valley_start());
  EXPECT_EQ(report.status, SolveStatus::failed);
  EXPECT_EQ(report.message, "term 'spring' has no stiffness");
}

TEST_P(Behaviour, ExceptionMidwayReachesTheCallerAndLeavesAPoint) {
  Disturbed<Valley> program([](int evaluation, ConstVectorRef, double&, Eigen::VectorXd&) {
    if (evaluation > 3) throw std::runtime_error("term 'spring' broke");
  });
  const OptimalityReport report = solve(program, valley_start());
  EXPECT_EQ(report.status, SolveStatus::failed);
  EXPECT_EQ(report.message, "term 'spring' broke");
  EXPECT_TRUE(report.x.allFinite());
}

TEST_P(Behaviour, ExceptionThatIsNoStandardOneIsReported) {
  Disturbed<Valley> program([](int evaluation, ConstVectorRef, double&, Eigen::VectorXd&) {
    if (evaluation > 3) throw 42;
  });
  const OptimalityReport report = solve(program, valley_start());
  EXPECT_EQ(report.status, SolveStatus::failed);
  EXPECT_NE(report.message, "");
}

TEST_P(Behaviour, IterationLimitIsKept) {
  Disturbed<Valley> program(undisturbed);
  SolveControl control;
  control.max_iterations = 2;
  const OptimalityReport report = solve(program, valley_start(), control);
  EXPECT_EQ(report.status, SolveStatus::iteration_limit) << report.native_status;
  EXPECT_LE(report.iterations, 2);
  EXPECT_TRUE(std::isfinite(report.cost));
}

TEST_P(Behaviour, TimeLimitIsKept) {
  Disturbed<Valley> program(
      [](int, ConstVectorRef, double&, Eigen::VectorXd&) { support::advance_clock(std::chrono::seconds(20'000)); });
  SolveControl control;
  control.time_limit = 5e4;
  // The clock is set forward at every evaluation: the limit is met after three, long before any backend can be done.
  const OptimalityReport report = solve(program, valley_start(), control);
  EXPECT_EQ(report.status, SolveStatus::time_limit) << report.native_status << report.message;
  EXPECT_TRUE(std::isfinite(report.cost));
}

TEST_P(Behaviour, StopBeforeTheStartIsObeyed) {
  Disturbed<Valley> program(undisturbed);
  const std::atomic<bool> stop{true};
  SolveControl control;
  control.stop = &stop;
  EXPECT_EQ(solve(program, valley_start(), control).status, SolveStatus::interrupted);
}

TEST_P(Behaviour, StopMidwayIsObeyed) {
  std::atomic<bool> stop{false};
  Disturbed<Valley> program(
      [&stop](int evaluation, ConstVectorRef, double&, Eigen::VectorXd&) { stop = evaluation >= 4; });
  SolveControl control;
  control.stop = &stop;
  const OptimalityReport report = solve(program, valley_start(), control);
  EXPECT_EQ(report.status, SolveStatus::interrupted) << report.native_status << report.message;
  // A backend may ask for a few more points before it hears of it.
  EXPECT_LE(program.evaluations(), 8);
}

/// Two equations that agree, for one variable.
struct Overdetermined {
  int variables = 1;
  int rows = 2;
  int residuals = 0;
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = x[0];
    out.rows[0] = x[0] - 1.0;
    out.rows[1] = x[0] * x[0] - 1.0;
  }
  void bounds(Bounds) const {}
};

TEST_P(Behaviour, MoreEquationsThanVariablesAreSolvedOrRefusedInWords) {
  FormulaProgram<Overdetermined> program;
  const OptimalityReport report = solve(program, Eigen::VectorXd::Constant(1, 0.5));
  if (report.status == SolveStatus::converged) {
    EXPECT_NEAR(report.x[0], 1.0, 1e-6);
  } else {
    EXPECT_EQ(report.status, SolveStatus::unsupported) << report.native_status;
    EXPECT_TRUE(contains_text(report.message, "2 rows"));
  }
}

TEST_P(Behaviour, EvaluationsAreCountedAndTimed) {
  Disturbed<Valley> program(undisturbed);
  const OptimalityReport report = solve(program, valley_start());
  EXPECT_EQ(report.status, SolveStatus::converged) << report.native_status << report.message;
  EXPECT_GT(report.evaluations.values, 0);
  EXPECT_EQ(report.evaluations.values, program.counts().values);
  EXPECT_EQ(report.evaluations.first_derivatives, program.counts().first_derivatives);
  EXPECT_EQ(report.evaluations.hessians, program.counts().hessians);
  EXPECT_GT(report.seconds_evaluating, 0.0);
  EXPECT_LE(report.seconds_evaluating, report.seconds);
  EXPECT_FALSE(report.effective_options.empty());
}

TEST_P(Behaviour, OneSolverObjectSolvesManyPrograms) {
  const auto backend = solver();
  FormulaProgram<Contradictory> hopeless;
  backend->solve(hopeless, {Eigen::Vector2d(0.3, -0.2), {}, {}}, {});
  for (const KnownProblem& problem : hock_schittkowski()) {
    if (problem.name != "hs012" && problem.name != "hs042") continue;
    const auto program = problem.make();
    EXPECT_EQ(problem.check(backend->solve(*program, {problem.start, {}, {}}, {})), "") << problem.name;
  }
}

TEST_P(Behaviour, StartOfTheWrongSizeThrows) {
  FormulaProgram<Valley> program;
  EXPECT_THROW(solve(program, Eigen::VectorXd::Zero(3)), Error);
}

INSTANTIATE_TEST_SUITE_P(EverySolver, Behaviour, testing::ValuesIn(solver_names()),
                         [](const auto& each) { return each.param; });

}  // namespace

}  // namespace tendril::conformance
