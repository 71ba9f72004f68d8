#include <gtest/gtest.h>

#include "known_problems.hpp"

namespace tendril::conformance {

namespace {

/// Largest difference between what a program says and central differences of what it is computed from, relative to its
/// size.
double derivative_error(NonlinearProgram& program, const Eigen::VectorXd& x) {
  // Truncation h^2 = 1e-10 and rounding 1e-16/h = 1e-11 meet here.
  constexpr double step = 1e-5;
  const int n = program.variable_count();
  const int m = program.row_count();
  const Eigen::VectorXd multipliers = Eigen::VectorXd::LinSpaced(m, 0.5, 1.5);
  const double sigma = 0.7;
  const Eigen::VectorXd gradient = program.gradient(x);
  const Eigen::MatrixXd jacobian = program.jacobian(x);
  const Eigen::MatrixXd residual_jacobian = program.residual_jacobian(x);
  const Eigen::VectorXd rest_gradient = program.rest_gradient(x);
  const Eigen::MatrixXd hessian = program.hessian(x, sigma, multipliers);
  const auto lagrangian_gradient = [&](const Eigen::VectorXd& at) -> Eigen::VectorXd {
    return sigma * program.gradient(at) + program.jacobian(at).transpose() * multipliers;
  };
  double error = 0.0;
  for (int j = 0; j < n; ++j) {
    Eigen::VectorXd plus = x;
    Eigen::VectorXd minus = x;
    plus[j] += step;
    minus[j] -= step;
    const auto compare = [&](const Eigen::VectorXd& exact, const Eigen::VectorXd& difference) {
      if (exact.size() == 0) return;
      error = std::max(error, (exact - difference / (2.0 * step)).lpNorm<Eigen::Infinity>() /
                                  std::max(1.0, exact.lpNorm<Eigen::Infinity>()));
    };
    const auto one = [](double v) { return Eigen::VectorXd::Constant(1, v); };
    compare(one(gradient[j]), one(program.cost(plus) - program.cost(minus)));
    compare(one(rest_gradient[j]), one(program.rest(plus) - program.rest(minus)));
    const Eigen::VectorXd rows = program.constraints(plus);
    compare(jacobian.col(j), rows - program.constraints(minus));
    const Eigen::VectorXd residuals = program.residuals(plus);
    compare(residual_jacobian.col(j), residuals - program.residuals(minus));
    compare(hessian.col(j), lagrangian_gradient(plus) - lagrangian_gradient(minus));
  }
  return error;
}

Eigen::VectorXd inside(const NonlinearProgram& program, const Eigen::VectorXd& start) {
  Eigen::VectorXd x = start;
  for (int i = 0; i < x.size(); ++i) x[i] = std::clamp(x[i] + 0.1 + 0.03 * i, program.lower()[i], program.upper()[i]);
  return x;
}

/// Differences of programs whose third derivatives are up to 1e3 leave 1e-7.
constexpr double difference_accuracy = 1e-6;

TEST(TestPrograms, HockSchittkowskiDerivativesAgreeWithDifferences) {
  for (const KnownProblem& problem : hock_schittkowski()) {
    const auto program = problem.make();
    EXPECT_LT(derivative_error(*program, inside(*program, problem.start)), difference_accuracy) << problem.name;
  }
}

TEST(TestPrograms, MacMpecDerivativesAgreeWithDifferences) {
  for (const KnownMpcc& problem : macmpec()) {
    for (const MpccTreatment treatment : {MpccTreatment::penalty, MpccTreatment::scholtes}) {
      const auto program = problem.make(treatment, 0.3);
      EXPECT_LT(derivative_error(*program, inside(*program, problem.start)), difference_accuracy) << problem.name;
    }
  }
}

TEST(TestPrograms, PublishedSolutionsAreFeasibleAndCostWhatIsPublished) {
  for (const KnownProblem& problem : hock_schittkowski()) {
    if (problem.solution.size() == 0) continue;
    const auto program = problem.make();
    // Seven digits are printed for hs071; the others are exact.
    EXPECT_NEAR(program->cost(problem.solution), problem.optimum, 1e-6 * std::max(1.0, std::abs(problem.optimum)))
        << problem.name;
    for (int i = 0; i < program->row_count(); ++i) {
      EXPECT_GE(program->constraints(problem.solution)[i], program->row_lower()[i] - 1e-5) << problem.name;
      EXPECT_LE(program->constraints(problem.solution)[i], program->row_upper()[i] + 1e-5) << problem.name;
    }
  }
}

}  // namespace

}  // namespace tendril::conformance
