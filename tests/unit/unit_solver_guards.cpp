// What stands between a program and a backend: refusals, finiteness, limits, exceptions, counts, the best point seen.

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <limits>
#include <string>

#include "conformance/formula.hpp"
#include "scripted_solver.hpp"
#include "support/contains.hpp"
#include "support/print.hpp"

namespace tendril {

namespace {

using conformance::Bounds;
using conformance::FormulaProgram;
using conformance::Values;
using Callbacks = ScriptedSolver::Callbacks;
using Start = ScriptedSolver::Start;
using Outcome = ScriptedSolver::Outcome;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// min (x0 - 1)^2 + (x1 - 2)^2 + 0.1 x0  s.t.  x0 + x1 <= 2,  x0 x1 = 0.5,  0 <= x0 <= 3.
struct Small {
  int variables = 2;
  int rows = 2;
  int residuals = 2;
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.residuals[0] = x[0] - 1.0;
    out.residuals[1] = x[1] - 2.0;
    out.rest = 0.1 * x[0];
    out.rows[0] = x[0] + x[1];
    out.rows[1] = x[0] * x[1];
  }
  void bounds(Bounds b) const {
    b.row_lower << -infinity, 0.5;
    b.row_upper << 2.0, 0.5;
    b.lower[0] = 0.0;
    b.upper[0] = 3.0;
  }
};

enum class Part { none, cost, gradient, constraints, jacobian, hessian, residuals, residual_jacobian, rest, slope };

/// One number of it can be made not finite.
class Poisoned : public FormulaProgram<Small> {
 public:
  Part poison = Part::none;
  std::string row_name(int row) const override { return "spring row " + std::to_string(row + 1); }
  std::string variable_name(int i) const override { return "knob " + std::to_string(i + 1); }
  using FormulaProgram<Small>::lower_;
  using FormulaProgram<Small>::upper_;
  using FormulaProgram<Small>::row_lower_;
  using FormulaProgram<Small>::row_upper_;

 protected:
  void do_evaluate(ConstVectorRef x, bool derivatives, Workspace& out) override {
    FormulaProgram<Small>::do_evaluate(x, derivatives, out);
    if (poison == Part::cost) out.cost = infinity;
    if (poison == Part::gradient) out.gradient[1] = nan;
    if (poison == Part::constraints) out.constraints[1] = nan;
    if (poison == Part::jacobian) out.jacobian(0, 1) = infinity;
    if (poison == Part::residuals) out.residuals[1] = nan;
    if (poison == Part::residual_jacobian) out.residual_jacobian(1, 0) = nan;
    if (poison == Part::rest) out.rest = nan;
    if (poison == Part::slope) out.rest_gradient[0] = nan;
  }
  void do_hessian(ConstVectorRef x, double sigma, ConstVectorRef multipliers, Workspace& out) override {
    FormulaProgram<Small>::do_hessian(x, sigma, multipliers, out);
    if (poison == Part::hessian) out.hessian(1, 0) = nan;
  }
};

const Eigen::Vector2d start(1.0, 0.5);

OptimalityReport run(NonlinearProgram& program, ScriptedSolver::Script script, const SolveControl& control = {},
                     SolverCapabilities can = {}) {
  return ScriptedSolver(std::move(script), can).solve(program, {start, {}, {}}, control);
}

Outcome never(Callbacks&, const Start&) {
  ADD_FAILURE() << "the backend was asked";
  return {};
}

TEST(SolverGuards, NameTheNumberThatIsNotFinite) {
  struct Case {
    Part part;
    const char* message;
    std::function<void(Callbacks&, ConstVectorRef)> ask;
  };
  const Eigen::Vector2d y(0.3, -0.4);
  for (const Case& c :
       {Case{Part::cost, "the cost is not finite (inf)", [](Callbacks&k, ConstVectorRef x) { k.cost(x); }},
        Case{Part::gradient, "the derivative of the cost by knob 2 is not finite (nan)",
             [](Callbacks&k, ConstVectorRef x) { k.gradient(x); }},
        Case{Part::constraints, "spring row 2 is not finite (nan)",
             [](Callbacks&k, ConstVectorRef x) { k.constraints(x); }},
        Case{Part::jacobian, "the derivative of spring row 1 by knob 2 is not finite (inf)",
             [](Callbacks&k, ConstVectorRef x) { k.jacobian(x); }},
        Case{Part::hessian, "the second derivative of the Lagrangian by knob 2 and knob 1 is not finite (nan)",
             [&y](Callbacks&k, ConstVectorRef x) { k.hessian(x, 1.0, y); }},
        Case{Part::residuals, "residual 2 of the cost is not finite (nan)",
             [](Callbacks&k, ConstVectorRef x) { k.residuals(x); }},
        Case{Part::residual_jacobian, "the derivative of residual 2 of the cost by knob 1 is not finite (nan)",
             [](Callbacks&k, ConstVectorRef x) { k.residual_jacobian(x); }},
        Case{Part::rest, "the cost is not finite (nan)", [](Callbacks&k, ConstVectorRef x) { k.rest(x); }},
        Case{Part::slope, "the derivative of the cost by knob 1 is not finite (nan)",
             [](Callbacks&k, ConstVectorRef x) { k.rest_gradient(x); }}}) {
    Poisoned program;
    const OptimalityReport report = run(program, [&](Callbacks& callbacks, const Start&) {
      program.poison = c.part;
      const Eigen::Vector2d elsewhere(0.8, 0.6);
      c.ask(callbacks, elsewhere);
      ADD_FAILURE() << "handed over: " << c.message;
      return converged_at({0.8, 0.6});
    });
    EXPECT_EQ(report.status, SolveStatus::not_finite) << c.message;
    EXPECT_EQ(report.message, c.message);
    EXPECT_EQ(report.x, start) << c.message;
  }
}

TEST(SolverGuards, LookAtTheStartBeforeTheBackendDoes) {
  for (const Part part : {Part::cost, Part::gradient, Part::constraints, Part::jacobian}) {
    Poisoned program;
    program.poison = part;
    const OptimalityReport report = run(program, never);
    EXPECT_EQ(report.status, SolveStatus::not_finite) << report.message;
    EXPECT_EQ(report.cost, infinity);
  }
}

TEST(SolverGuards, ABackendMayStepBackFromWhatIsNotFinite) {
  Poisoned program;
  const OptimalityReport report = run(program, [&](Callbacks& callbacks, const Start&) {
    program.poison = Part::cost;
    try {
      callbacks.cost(Eigen::Vector2d(0.8, 0.6));
    } catch (const NotFiniteError&) {
    }
    program.poison = Part::none;
    Outcome outcome = converged_at({1.0, 0.5});
    outcome.status = SolveStatus::iteration_limit;
    return outcome;
  });
  EXPECT_EQ(report.status, SolveStatus::iteration_limit) << report.message;
}

TEST(SolverGuards, MoveTheStartOntoTheBounds) {
  for (const auto& [from, to] : {std::pair{-4.0, 0.0}, std::pair{0.7, 0.7}, std::pair{4.0, 3.0}}) {
    Poisoned program;
    double found = nan;
    ScriptedSolver([&](Callbacks&, const Start& given) {
      found = given.x[0];
      return converged_at({given.x[0], given.x[1]});
    }).solve(program, {Eigen::Vector2d(from, 0.5), {}, {}}, {});
    EXPECT_EQ(found, to);
  }
}

TEST(SolverGuards, HandTheMultipliersOfTheStartOn) {
  Poisoned program;
  const Eigen::Vector2d y(0.3, -0.4), z(0.1, -0.2);
  ScriptedSolver solver([&](Callbacks&, const Start& given) {
    EXPECT_TRUE(given.has_multipliers());
    EXPECT_EQ(given.multipliers, y);
    EXPECT_EQ(given.bound_multipliers, z);
    return converged_at({1.0, 0.5});
  });
  solver.solve(program, {start, y, z}, {});
  ScriptedSolver cold([&](Callbacks&, const Start& given) {
    EXPECT_FALSE(given.has_multipliers());
    return converged_at({1.0, 0.5});
  });
  cold.solve(program, {start, {}, {}}, {});
}

TEST(SolverGuards, RefuseAStartOfTheWrongSize) {
  const auto message = [](const SolverStart& given) -> std::string {
    Poisoned program;
    try {
      ScriptedSolver(never).solve(program, given, {});
    } catch (const Error& e) {
      return e.what();
    }
    return "nothing was refused";
  };
  const Eigen::VectorXd three = Eigen::VectorXd::Zero(3);
  EXPECT_EQ(message({three, {}, {}}), "x of the start has 3 entries, expected 2");
  EXPECT_EQ(message({{}, {}, {}}), "x of the start has 0 entries, expected 2");
  EXPECT_EQ(message({start, three, {}}), "the vector of multipliers of the start has 3 entries, expected 2");
  EXPECT_EQ(message({start, {}, three}), "the vector of bound multipliers of the start has 3 entries, expected 2");
}

TEST(SolverGuards, SayWhatTheBackendCannotTake) {
  const auto message = [](SolverCapabilities can) {
    Poisoned program;
    const OptimalityReport report = run(program, never, {}, can);
    EXPECT_EQ(report.status, SolveStatus::unsupported);
    EXPECT_EQ(report.evaluations.values, 0);
    return report.message;
  };
  SolverCapabilities can;
  can.equalities = false;
  EXPECT_EQ(message(can), "scripted cannot take equality constraints: 1 spring row");
  can = {};
  can.inequalities = false;
  EXPECT_EQ(message(can), "scripted cannot take inequality constraints: 1 spring row");
  can = {};
  can.needs_finite_bounds = true;
  EXPECT_EQ(message(can), "scripted needs finite bounds: knob 2 has none on one side");
  // A program without what the backend cannot take is taken.
  Poisoned program;
  program.lower_ << 0.0, -1.0;
  program.upper_ << 3.0, 1.0;
  const OptimalityReport report = run(
      program,
      [](Callbacks&, const Start&) {
        return converged_at({1.0, 0.5});
      },
      {}, can);
  EXPECT_NE(report.status, SolveStatus::unsupported) << report.message;
}

TEST(SolverGuards, NameBoundsThatNothingSatisfies) {
  struct Case {
    double lower, upper;
    const char* words;
  };
  for (const auto& [lower, upper, words] :
       {Case{2.0, 1.0, " must be at least 2 and at most 1"}, Case{nan, 1.0, " must be at least nan and at most 1"},
        Case{infinity, infinity, " must be at least inf and at most inf"},
        Case{-infinity, -infinity, " must be at least -inf and at most -inf"}}) {
    Poisoned variable;
    variable.lower_[1] = lower;
    variable.upper_[1] = upper;
    const OptimalityReport of_variable = run(variable, never);
    EXPECT_EQ(of_variable.status, SolveStatus::infeasible) << words;
    EXPECT_EQ(of_variable.message, std::string("knob 2") + words);
    Poisoned row;
    row.row_lower_[0] = lower;
    row.row_upper_[0] = upper;
    const OptimalityReport of_row = run(row, never);
    EXPECT_EQ(of_row.status, SolveStatus::infeasible) << words;
    EXPECT_EQ(of_row.message, std::string("spring row 1") + words);
  }
}

TEST(SolverGuards, EndWhenTheTimeIsOver) {
  Poisoned program;
  SolveControl control;
  control.time_limit = 0.0;
  const OptimalityReport report = run(program, never, control);
  EXPECT_EQ(report.status, SolveStatus::time_limit);
  EXPECT_EQ(report.message, "the time limit of 0 s is over");
}

TEST(SolverGuards, KnowTheTimeLeft) {
  Poisoned program;
  SolveControl control;
  control.time_limit = infinity;
  run(
      program,
      [](Callbacks& callbacks, const Start&) {
        EXPECT_EQ(callbacks.seconds_left(), infinity);
        EXPECT_FALSE(callbacks.must_stop());
        return converged_at({1.0, 0.5});
      },
      control);
  control.time_limit = 1e6;
  run(
      program,
      [](Callbacks& callbacks, const Start&) {
        EXPECT_LT(callbacks.seconds_left(), 1e6);
        EXPECT_GT(callbacks.seconds_left(), 9e5);
        return converged_at({1.0, 0.5});
      },
      control);
}

TEST(SolverGuards, EndWhenTheyAreStopped) {
  Poisoned program;
  std::atomic<bool> stop{false};
  SolveControl control;
  control.stop = &stop;
  const OptimalityReport thrown = run(
      program,
      [&](Callbacks& callbacks, const Start&) {
        EXPECT_FALSE(callbacks.must_stop());
        stop = true;
        EXPECT_TRUE(callbacks.must_stop());
        callbacks.cost(Eigen::Vector2d(0.8, 0.6));
        ADD_FAILURE() << "went on";
        return converged_at({0.8, 0.6});
      },
      control);
  EXPECT_EQ(thrown.status, SolveStatus::interrupted);
  EXPECT_EQ(thrown.message, "stop was asked for");
  // A backend that ended by itself without success was stopped; one that succeeded first has succeeded.
  for (const SolveStatus said : {SolveStatus::stalled, SolveStatus::time_limit, SolveStatus::failed}) {
    stop = false;
    const OptimalityReport ended = run(
        program,
        [&](Callbacks&, const Start&) {
          stop = true;
          Outcome outcome = converged_at({1.0, 0.5});
          outcome.status = said;
          return outcome;
        },
        control);
    EXPECT_EQ(ended.status, SolveStatus::interrupted) << to_string(said);
  }
}

TEST(SolverGuards, ReportTheFirstExceptionThatWasKept) {
  Poisoned program;
  const OptimalityReport report = run(program, [](Callbacks& callbacks, const Start&) {
    for (const char* words : {"the spring broke", "the rest followed"}) {
      EXPECT_EQ(callbacks.has_exception(), std::string(words) != "the spring broke");
      try {
        throw std::runtime_error(words);
      } catch (...) {
        callbacks.record_exception();
      }
      EXPECT_TRUE(callbacks.must_stop());
    }
    return converged_at({1.0, 0.5});
  });
  EXPECT_EQ(report.status, SolveStatus::failed);
  EXPECT_EQ(report.message, "the spring broke");
}

TEST(SolverGuards, ReportWhatIsThrown) {
  Poisoned program;
  const OptimalityReport standard =
      run(program, [](Callbacks&, const Start&) -> Outcome { throw std::runtime_error("out of luck"); });
  EXPECT_EQ(standard.status, SolveStatus::failed);
  EXPECT_EQ(standard.message, "out of luck");
  EXPECT_EQ(standard.x, start);
  EXPECT_TRUE(std::isfinite(standard.cost));
  const OptimalityReport other = run(program, [](Callbacks&, const Start&) -> Outcome { throw 42; });
  EXPECT_EQ(other.status, SolveStatus::failed);
  EXPECT_EQ(other.message, "an exception of unknown type");
}

TEST(SolverGuards, APointThatIsNotFiniteIsNotTaken) {
  Poisoned program;
  for (const std::vector<double>& x : {std::vector<double>{nan, 0.5}, std::vector<double>{1.0, infinity},
                                       std::vector<double>{1.0}, std::vector<double>{1.0, 0.5, 0.0}}) {
    const OptimalityReport report = run(program, [&](Callbacks&, const Start&) { return converged_at(x); });
    EXPECT_EQ(report.status, SolveStatus::not_finite);
    EXPECT_EQ(report.message, "the backend returned a point that is not finite");
    EXPECT_EQ(report.x, start);
  }
}

TEST(SolverGuards, CountTheEvaluationsOfThisSolveAlone) {
  Poisoned program;
  const Eigen::Vector2d before(0.2, 0.2);
  program.gradient(before);
  program.hessian(before, 1.0, Eigen::Vector2d::Zero());
  const OptimalityReport report = run(program, [](Callbacks& callbacks, const Start&) {
    const Eigen::Vector2d x(0.8, 0.6);
    callbacks.cost(x);
    callbacks.gradient(x);
    callbacks.hessian(x, 1.0, Eigen::Vector2d::Zero());
    callbacks.hessian(x, 0.5, Eigen::Vector2d::Zero());
    Outcome outcome = converged_at({0.8, 0.6});
    outcome.status = SolveStatus::iteration_limit;
    outcome.iterations = 7;
    outcome.native_status = "enough";
    outcome.effective_options["pace"] = "slow";
    return outcome;
  });
  // The start and x; the judgement at the end is at x again.
  EXPECT_EQ(report.evaluations.values, 2);
  EXPECT_EQ(report.evaluations.first_derivatives, 2);
  EXPECT_EQ(report.evaluations.hessians, 2);
  EXPECT_EQ(report.iterations, 7);
  EXPECT_EQ(report.native_status, "enough");
  EXPECT_EQ(report.effective_options.at("pace"), "slow");
}

TEST(SolverGuards, JudgeAPointForTheBackend) {
  Poisoned program;
  run(program, [](Callbacks& callbacks, const Start&) {
    const Callbacks::Judgement here = callbacks.judge(Eigen::Vector2d(0.5, 1.0));
    EXPECT_EQ(here.infeasibility, 0.0);
    EXPECT_DOUBLE_EQ(here.gradient_scale, 2.0);
    // Gradient (-0.9, -2), the row's (1, 0.5): least squares leave (0.62, -1.24).
    EXPECT_NEAR(here.stationarity, 1.24, 1e-12);
    const Callbacks::Judgement off = callbacks.judge(Eigen::Vector2d(0.9, 1.9));
    EXPECT_NEAR(off.infeasibility, 0.9 * 1.9 - 0.5, 1e-12);
    EXPECT_EQ(off.gradient_scale, 1.0);
    return converged_at({1.0, 0.5});
  });
}

}  // namespace

}  // namespace tendril
