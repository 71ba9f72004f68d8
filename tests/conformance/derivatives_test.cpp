#include <gtest/gtest.h>

#include <random>

#include "derivatives/differences.hpp"
#include "known_problems.hpp"

namespace tendril::conformance {

namespace {

Eigen::VectorXd inside(const NonlinearProgram& program, const Eigen::VectorXd& start) {
  Eigen::VectorXd x = start;
  for (int i = 0; i < x.size(); ++i) x[i] = std::clamp(x[i] + 0.1 + 0.03 * i, program.lower()[i], program.upper()[i]);
  return x;
}

TEST(TestPrograms, HockSchittkowskiDerivativesAgreeWithDifferences) {
  std::mt19937 random(1);
  for (const KnownProblem& problem : hock_schittkowski()) {
    SCOPED_TRACE(problem.name);
    const auto program = problem.make();
    const Eigen::VectorXd x = inside(*program, problem.start);
    expect_first_derivatives(*program, x);
    expect_hessian(*program, x, random);
  }
}

TEST(TestPrograms, MacMpecDerivativesAgreeWithDifferences) {
  std::mt19937 random(2);
  for (const KnownMpcc& problem : macmpec()) {
    for (const MpccTreatment treatment : {MpccTreatment::penalty, MpccTreatment::scholtes}) {
      SCOPED_TRACE(problem.name);
      const auto program = problem.make(treatment, 0.3);
      const Eigen::VectorXd x = inside(*program, problem.start);
      expect_first_derivatives(*program, x);
      expect_hessian(*program, x, random);
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
