#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>
#include <random>

#include "nlp/multipliers.hpp"
#include "support/print.hpp"
#include "tendril/error.hpp"

namespace tendril {

namespace {

using Signs = std::vector<MultiplierSign>;

bool allowed(double y, MultiplierSign sign) {
  return sign == MultiplierSign::free || (sign == MultiplierSign::non_negative ? y >= 0.0 : y <= 0.0);
}

/// The smallest residual over all choices of which bounded multipliers are zero.
double brute_force(const Eigen::VectorXd& g, const Eigen::MatrixXd& a, const Signs& signs) {
  double best = g.norm();
  const auto k = static_cast<unsigned>(signs.size());
  for (unsigned subset = 0; subset < (1U << k); ++subset) {
    Eigen::MatrixXd part(a.rows(), 0);
    Signs part_signs;
    for (unsigned j = 0; j < k; ++j) {
      if ((subset >> j & 1U) == 0U) continue;
      part.conservativeResize(Eigen::NoChange, part.cols() + 1);
      part.rightCols(1) = a.col(j);
      part_signs.push_back(signs[j]);
    }
    if (part.cols() == 0) continue;
    const Eigen::VectorXd y = part.completeOrthogonalDecomposition().solve(-g);
    bool fits = true;
    for (Eigen::Index j = 0; j < y.size(); ++j) fits = fits && allowed(y[j], part_signs[static_cast<std::size_t>(j)]);
    if (fits) best = std::min(best, (g + part * y).norm());
  }
  return best;
}

TEST(RecoverMultipliers, FindsTheLeastResidualOfRandomProblems) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  std::uniform_int_distribution<int> rows(1, 7);
  std::uniform_int_distribution<int> columns(1, 8);
  std::uniform_int_distribution<int> sign(0, 2);
  for (int trial = 0; trial < 2000; ++trial) {
    const int n = rows(random);
    const int k = columns(random);
    Eigen::MatrixXd a = Eigen::MatrixXd::NullaryExpr(n, k, [&] { return normal(random); });
    const Eigen::VectorXd g = Eigen::VectorXd::NullaryExpr(n, [&] { return normal(random); });
    // Dependent columns are the rule at degenerate points.
    if (trial % 3 == 0 && k > 1) a.col(k - 1) = -a.col(0);
    Signs signs;
    for (int j = 0; j < k; ++j) signs.push_back(static_cast<MultiplierSign>(sign(random)));
    const MultiplierFit fit = recover_multipliers(g, a, signs);
    ASSERT_TRUE(fit.exact_signs);
    for (int j = 0; j < k; ++j)
      ASSERT_TRUE(allowed(fit.multipliers[j], signs[static_cast<std::size_t>(j)])) << "trial " << trial;
    // Both are sums of a few products of numbers of order one.
    ASSERT_LT((g + a * fit.multipliers - fit.residual).norm(), 1e-12);
    ASSERT_NEAR(fit.residual.norm(), brute_force(g, a, signs), 1e-10) << "trial " << trial;
  }
}

TEST(RecoverMultipliers, LeavesAWrongSignedColumnAlone) {
  const Eigen::Vector2d g(1.0, 0.0);
  const Eigen::MatrixXd a = Eigen::MatrixXd::Identity(2, 1);
  EXPECT_EQ(recover_multipliers(g, a, Signs{MultiplierSign::non_negative}).multipliers[0], 0.0);
  EXPECT_EQ(recover_multipliers(g, a, Signs{MultiplierSign::non_positive}).multipliers[0], -1.0);
}

TEST(RecoverMultipliers, HasNoMultipliersWithoutColumns) {
  const Eigen::Vector2d g(3.0, 4.0);
  const MultiplierFit fit = recover_multipliers(g, Eigen::MatrixXd(2, 0), {});
  EXPECT_EQ(fit.multipliers.size(), 0);
  EXPECT_EQ(fit.residual, g);
}

TEST(RecoverMultipliers, RefusesSizesThatDoNotFit) {
  EXPECT_THROW(recover_multipliers(Eigen::Vector2d::Zero(), Eigen::MatrixXd::Zero(3, 1), Signs(1)), Error);
  EXPECT_THROW(recover_multipliers(Eigen::Vector2d::Zero(), Eigen::MatrixXd::Zero(2, 1), Signs(2)), Error);
}

TEST(Activity, KnowsTheSideAndItsSign) {
  EXPECT_FALSE(activity(0.5, 0.0, 1.0, 1e-6).any());
  EXPECT_EQ(activity(1e-7, 0.0, 1.0, 1e-6).sign(), MultiplierSign::non_positive);
  EXPECT_EQ(activity(1.5, 0.0, 1.0, 1e-6).sign(), MultiplierSign::non_negative);
  EXPECT_EQ(activity(7.0, 0.0, 0.0, 1e-6).sign(), MultiplierSign::free);
  EXPECT_FALSE(activity(7.0, -infinity, infinity, 1e-6).any());
}

/// min x0 + 2 x1  s.t.  x0 + x1 >= 1,  0 <= x: at (1, 0) the multipliers are -1 (row) and -1 (second bound).
class Corner : public NonlinearProgram {
 public:
  Corner() : NonlinearProgram(2, 1, 0) {
    lower_.setZero();
    row_lower_[0] = 1.0;
    row_upper_[0] = infinity;
  }

 protected:
  void do_evaluate(ConstVectorRef x, bool derivatives, Workspace& out) override {
    out.cost = out.rest = x[0] + 2.0 * x[1];
    out.constraints[0] = x[0] + x[1];
    if (!derivatives) return;
    out.gradient << 1.0, 2.0;
    out.rest_gradient = out.gradient;
    out.jacobian.setOnes();
  }
  void do_hessian(ConstVectorRef, double, ConstVectorRef, Workspace& out) override { out.hessian.setZero(); }
};

TEST(JudgeKkt, RecoversTheMultipliersOfACorner) {
  Corner program;
  const KktJudgement verdict = judge_kkt(program, Eigen::Vector2d(1.0, 0.0), 1e-6);
  EXPECT_EQ(verdict.infeasibility, 0.0);
  EXPECT_NEAR(verdict.stationarity, 0.0, 1e-14);
  EXPECT_NEAR(verdict.multipliers[0], -1.0, 1e-14);
  EXPECT_NEAR(verdict.bound_multipliers[0], 0.0, 1e-14);
  EXPECT_NEAR(verdict.bound_multipliers[1], -1.0, 1e-14);
}

TEST(JudgeKkt, DoesNotBelieveMultipliersOfInactiveOrWrongSides) {
  Corner program;
  const Eigen::VectorXd rows = Eigen::VectorXd::Constant(1, -1.0);
  const Eigen::VectorXd bounds = Eigen::Vector2d(0.0, -1.0);
  EXPECT_NEAR(judge_kkt(program, Eigen::Vector2d(1.0, 0.0), 1e-6, &rows, &bounds).stationarity, 0.0, 1e-14);
  // At (2, 0) the row is not active: its multiplier counts as zero and the gradient's first entry is left over.
  EXPECT_NEAR(judge_kkt(program, Eigen::Vector2d(2.0, 0.0), 1e-6, &rows, &bounds).stationarity, 1.0, 1e-14);
  const Eigen::VectorXd wrong = Eigen::VectorXd::Constant(1, 1.0);
  EXPECT_EQ(judge_kkt(program, Eigen::Vector2d(1.0, 0.0), 1e-6, &wrong, &bounds).multipliers[0], 0.0);
}

TEST(JudgeKkt, MeasuresTheLargestViolation) {
  Corner program;
  EXPECT_NEAR(judge_kkt(program, Eigen::Vector2d(0.25, -0.5), 1e-6).infeasibility, 1.25, 1e-15);
  EXPECT_NEAR(infeasibility(program, Eigen::Vector2d(2.0, -0.5)), 0.5, 1e-15);
}

}  // namespace

}  // namespace tendril
