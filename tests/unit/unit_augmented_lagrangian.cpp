// The sums of squares that a program becomes for a backend that knows nothing else, and how the loop around them ends.

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <functional>
#include <limits>

#include "conformance/formula.hpp"
#include "derivatives/differences.hpp"
#include "support/contains.hpp"
#include "support/print.hpp"
#include "tendril/augmented_lagrangian.hpp"

namespace tendril {

namespace {

using conformance::Bounds;
using conformance::FormulaProgram;
using conformance::Values;

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr double first_penalty = 10.0;

/// A backend whose library does what a test says.
class Scripted : public AugmentedLagrangianSolver {
 public:
  using Subproblem = AugmentedLagrangianSolver::Subproblem;
  using Reduction = AugmentedLagrangianSolver::Reduction;
  using Script = std::function<Reduction(Subproblem&, double*)>;

  explicit Scripted(Script script) : script_(std::move(script)) {}
  std::string name() const override { return "scripted"; }

 private:
  Reduction reduce(Subproblem& subproblem, double* x) override { return script_(subproblem, x); }
  std::map<std::string, std::string> effective_options() const override { return {{"pace", "slow"}}; }

  Script script_;
};

/// Rows of each kind (an equation, one with an upper and one with a lower side), residuals, a curved rest; the second
/// variable is fixed.
struct Mixed {
  int variables = 4;
  int rows = 3;
  int residuals = 2;
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    using std::cos;
    using std::exp;
    using std::sin;
    out.residuals[0] = x[0] * x[2] - 1.0;
    out.residuals[1] = cos(x[3]) + x[1];
    out.rest = exp(0.4 * x[0]) * x[3] + x[2] * x[2];
    out.rows[0] = x[0] * x[3] - x[2];
    out.rows[1] = x[0] * x[0] + x[2] * x[1];
    out.rows[2] = sin(x[3]) - x[0];
  }
  void bounds(Bounds b) const {
    b.row_lower << 0.2, -infinity, 0.5;
    b.row_upper << 0.2, 0.1, infinity;
    b.lower << -0.1, 0.7, -5.0, -5.0;
    b.upper << 5.0, 0.7, 0.2, 5.0;
  }
};

const Eigen::Vector4d mixed_start(0.3, 0.7, 0.1, 1.1);
/// Far from balance, so that the loop begins with a sum of squares.
const Eigen::Vector3d mixed_multipliers(0.4, 2.5, -1.5);
const Eigen::Vector4d mixed_bound_multipliers(-3.5, 0.0, 2.0, 0.0);

/// Runs `look` on the first sum of squares.
void look_at_first(NonlinearProgram& program, const std::function<void(Scripted::Subproblem&, Eigen::VectorXd)>& look) {
  int calls = 0;
  Scripted([&](Scripted::Subproblem& subproblem, double* x) {
    if (calls++ == 0) look(subproblem, Eigen::Map<Eigen::VectorXd>(x, subproblem.variable_count()));
    return Scripted::Reduction{false, false, 1, "seen"};
  }).solve(program, {mixed_start, mixed_multipliers, mixed_bound_multipliers}, {});
  EXPECT_EQ(calls, 1);
}

Eigen::VectorXd residuals_at(Scripted::Subproblem& subproblem, const Eigen::VectorXd& x) {
  Eigen::VectorXd r(subproblem.residual_count());
  EXPECT_TRUE(subproblem.evaluate(x.data(), r.data(), nullptr));
  return r;
}

/// rho (s - clamp(s, l, u)), s = value + y / rho.
double pressure(double value, double y, double lower, double upper) {
  const double s = value + y / first_penalty;
  return first_penalty * (s - std::clamp(s, lower, upper));
}

TEST(AugmentedLagrangian, ItsSquaresHaveTheGradientOfTheAugmentedLagrangian) {
  FormulaProgram<Mixed> program, reference;
  look_at_first(program, [&](Scripted::Subproblem& subproblem, const Eigen::VectorXd& x) {
    ASSERT_EQ(subproblem.variable_count(), 3) << "the fixed variable is left out";
    ASSERT_EQ(subproblem.residual_count(), 2 + 3 + 3 + 3) << "residuals, rows, bounds, proximal term";
    EXPECT_EQ(x, Eigen::Vector3d(0.3, 0.1, 1.1));
    Eigen::VectorXd r(subproblem.residual_count());
    RowMajor j(subproblem.residual_count(), 3);
    ASSERT_TRUE(subproblem.evaluate(x.data(), r.data(), j.data()));
    Eigen::VectorXd expected = reference.gradient(mixed_start);
    const Eigen::VectorXd c = reference.constraints(mixed_start);
    for (int i = 0; i < 3; ++i) {
      expected += pressure(c[i], mixed_multipliers[i], reference.row_lower()[i], reference.row_upper()[i]) *
                  reference.jacobian(mixed_start).row(i).transpose();
    }
    for (int i = 0; i < 4; ++i) {
      expected[i] += pressure(mixed_start[i], mixed_bound_multipliers[i], reference.lower()[i], reference.upper()[i]);
    }
    const Eigen::Vector3d free(expected[0], expected[2], expected[3]);
    // Sums of a dozen numbers of order ten.
    EXPECT_LT((j.transpose() * r - free).lpNorm<Eigen::Infinity>(), 1e-12) << (j.transpose() * r - free).transpose();
  });
}

TEST(AugmentedLagrangian, ItsJacobianAgreesWithDifferences) {
  FormulaProgram<Mixed> program;
  look_at_first(program, [&](Scripted::Subproblem& subproblem, const Eigen::VectorXd& start) {
    const auto row = [](int i) { return "square " + std::to_string(i + 1); };
    const auto variable = [](int i) { return "free variable " + std::to_string(i + 1); };
    // Points away from where a row or bound begins to press.
    for (const Eigen::Vector3d& move :
         {Eigen::Vector3d(0.0, 0.0, 0.0), Eigen::Vector3d(1.2, -2.0, 0.4), Eigen::Vector3d(-1.0, 1.5, -0.7)}) {
      const Eigen::VectorXd x = start + move;
      Eigen::VectorXd r(subproblem.residual_count());
      RowMajor j(subproblem.residual_count(), 3);
      ASSERT_TRUE(subproblem.evaluate(x.data(), r.data(), j.data()));
      EXPECT_EQ(residuals_at(subproblem, x), r);
      expect_near("the derivative", j,
                  differences(x, [&](const Eigen::VectorXd& y) { return residuals_at(subproblem, y); }), row, variable);
    }
  });
}

TEST(AugmentedLagrangian, TheProximalTermBendsAsTheRestDoes) {
  FormulaProgram<Mixed> program, reference;
  look_at_first(program, [&](Scripted::Subproblem& subproblem, const Eigen::VectorXd& x) {
    Eigen::VectorXd r(subproblem.residual_count());
    RowMajor j(subproblem.residual_count(), 3);
    ASSERT_TRUE(subproblem.evaluate(x.data(), r.data(), j.data()));
    const Eigen::MatrixXd root = j.bottomRows(3);
    // The cost's Hessian less 2 J^T J of the residuals, on the free variables; its absolute value and the first weight.
    const Eigen::MatrixXd h = reference.hessian(mixed_start, 1.0, Eigen::Vector3d::Zero());
    const Eigen::MatrixXd jr = reference.residual_jacobian(mixed_start);
    const Eigen::MatrixXd left = h - 2.0 * jr.transpose() * jr;
    Eigen::Matrix3d reduced;
    const int free[] = {0, 2, 3};
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b < 3; ++b) reduced(a, b) = left(free[a], free[b]);
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(reduced);
    const Eigen::Matrix3d expected = eigen.eigenvectors() *
                                     (eigen.eigenvalues().cwiseAbs().array() + 1e-2).matrix().asDiagonal() *
                                     eigen.eigenvectors().transpose();
    EXPECT_LT((root.transpose() * root - expected).cwiseAbs().maxCoeff(), 1e-12);
  });
}

OptimalityReport mixed(const Scripted::Script& script, const SolveControl& control = {}) {
  FormulaProgram<Mixed> program;
  return Scripted(script).solve(program, {mixed_start, {}, {}}, control);
}

TEST(AugmentedLagrangian, EndsWhereTheLibraryGivesUp) {
  const OptimalityReport report = mixed([](Scripted::Subproblem&, double*) {
    return Scripted::Reduction{false, false, 3, "no luck"};
  });
  EXPECT_EQ(report.status, SolveStatus::stalled) << report.message;
  EXPECT_EQ(report.native_status, "no luck");
  EXPECT_EQ(report.iterations, 3);
  EXPECT_EQ(report.effective_options.at("pace"), "slow");
  EXPECT_EQ(report.effective_options.at("penalty"), "10");
}

TEST(AugmentedLagrangian, KeepsTheIterationLimit) {
  SolveControl control;
  control.max_iterations = 120;
  std::vector<int> limits;
  const OptimalityReport report = mixed(
      [&](Scripted::Subproblem& subproblem, double* x) {
        limits.push_back(subproblem.iteration_limit());
        x[0] += 1e-6;
        return Scripted::Reduction{true, false, subproblem.iteration_limit(), "more"};
      },
      control);
  // At most 50 at a time, and no more in all than are left.
  EXPECT_EQ(limits, (std::vector<int>{50, 50, 20}));
  EXPECT_EQ(report.status, SolveStatus::iteration_limit);
  EXPECT_EQ(report.iterations, 120);
}

TEST(AugmentedLagrangian, SaysThatEveryVariableIsFixed) {
  struct Nailed : FormulaProgram<Mixed> {
    Nailed() {
      lower_ << 0.2, 0.7, 0.1, 0.4;
      upper_ = lower_;
    }
  } program;
  const OptimalityReport report = Scripted([](Scripted::Subproblem&, double*) -> Scripted::Reduction {
                                    ADD_FAILURE() << "nothing is there to reduce";
                                    return {};
                                  }).solve(program, {mixed_start, {}, {}}, {});
  EXPECT_EQ(report.native_status, "every variable is fixed");
  EXPECT_NE(report.status, SolveStatus::converged) << "its rows do not hold";
}

/// The number ends at x = 1.
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

TEST(AugmentedLagrangian, SaysWhereThereIsNoNumber) {
  FormulaProgram<Cliff> program;
  const OptimalityReport report = Scripted([](Scripted::Subproblem& subproblem, double*) {
                                    const double beyond = 2.0;
                                    Eigen::VectorXd r(subproblem.residual_count());
                                    EXPECT_FALSE(subproblem.evaluate(&beyond, r.data(), nullptr));
                                    return Scripted::Reduction{true, false, 1, "stuck"};
                                  }).solve(program, {Eigen::VectorXd::Constant(1, 0.1), {}, {}}, {});
  EXPECT_EQ(report.status, SolveStatus::not_finite);
  EXPECT_TRUE(contains_text(report.message, "the cost is not finite"));
}

TEST(AugmentedLagrangian, HandsExceptionsOfTheProgramOn) {
  struct Breaking : FormulaProgram<Mixed> {
    bool broken = false;
    void do_evaluate(ConstVectorRef x, bool derivatives, Workspace& out) override {
      if (broken) throw std::runtime_error("the spring broke");
      FormulaProgram<Mixed>::do_evaluate(x, derivatives, out);
    }
  } program;
  const OptimalityReport report = Scripted([&](Scripted::Subproblem& subproblem, double*) {
                                    program.broken = true;
                                    const Eigen::Vector3d x(0.4, 0.4, 0.4);
                                    Eigen::VectorXd r(subproblem.residual_count());
                                    EXPECT_FALSE(subproblem.evaluate(x.data(), r.data(), nullptr));
                                    program.broken = false;
                                    EXPECT_FALSE(subproblem.evaluate(x.data(), r.data(), nullptr)) << "not again";
                                    return Scripted::Reduction{true, true, 1, "fine"};
                                  }).solve(program, {mixed_start, {}, {}}, {});
  EXPECT_EQ(report.status, SolveStatus::failed);
  EXPECT_EQ(report.message, "the spring broke");
}

/// Its rest does not follow its model: whatever is tried beside the start costs more.
struct Spike {
  int variables = 1;
  int rows = 0;
  int residuals = 0;
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = x[0] + 1e6 * x[0] * x[0];
  }
  void bounds(Bounds) const {}
};

TEST(AugmentedLagrangian, TakesNoStepThatCostsMore) {
  FormulaProgram<Spike> program;
  int calls = 0;
  const OptimalityReport report = Scripted([&](Scripted::Subproblem&, double* x) {
                                    EXPECT_EQ(x[0], 0.0) << "a step that cost more was taken";
                                    ++calls;
                                    x[0] = -1.0;
                                    return Scripted::Reduction{true, true, 1, "done"};
                                  }).solve(program, {Eigen::VectorXd::Zero(1), {}, {}}, {});
  EXPECT_EQ(report.status, SolveStatus::stalled) << report.message;
  EXPECT_EQ(report.native_status, "no descent");
  EXPECT_GT(calls, 10);
}

}  // namespace

}  // namespace tendril
