// The four treatments of complementarity: what they add to a program, and its derivatives.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "conformance/formula.hpp"
#include "derivatives/differences.hpp"
#include "nlp/complementarity.hpp"
#include "support/print.hpp"

namespace tendril {

namespace {

using conformance::Bounds;
using conformance::FormulaProgram;
using conformance::Values;

/// Four variables, of which the last two have a row each as their partner; rows, residuals and rest are all curved.
struct Base {
  int variables = 4;
  int rows = 3;
  int residuals = 2;
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    using std::cos;
    using std::exp;
    using std::sin;
    out.residuals[0] = x[0] * x[1] - x[2];
    out.residuals[1] = cos(x[3]) + x[0];
    out.rest = exp(0.2 * x[0]) * x[3];
    out.rows[0] = x[0] * x[1] * x[2];
    out.rows[1] = x[0] * x[0] + sin(x[1]) * x[2] + 1.5;
    out.rows[2] = exp(0.3 * x[0]) - x[1] * x[3];
  }
  void bounds(Bounds b) const {
    b.lower << -5.0, -4.0, 0.0, 0.0;
    b.upper << 5.0, 4.0, 3.0, infinity;
    b.row_lower << -1.0, 0.0, 0.0;
    b.row_upper << 2.0, infinity, infinity;
  }
};

class BaseProgram : public FormulaProgram<Base> {
 public:
  void set_upper(int variable, double bound) { upper_[variable] = bound; }
  std::string row_name(int row) const override { return "base row " + std::to_string(row); }
  std::string variable_name(int variable) const override { return "base variable " + std::to_string(variable); }
};

/// The second pair comes first, so that the order of pairs is not that of rows or variables.
const std::vector<ComplementaryPair> pairs{{2, 3}, {1, 2}};
constexpr int pair_count = 2;
constexpr int base_rows = 3;
constexpr int base_variables = 4;
constexpr Treatment treatments[] = {Treatment::penalty, Treatment::slack, Treatment::scholtes,
                                    Treatment::fischer_burmeister};
constexpr double parameters[] = {0.3, 7.0};

Eigen::VectorXd random_vector(Eigen::Index size, std::mt19937& random) {
  std::uniform_real_distribution<double> d(-1.5, 1.5);
  Eigen::VectorXd x(size);
  for (double& value : x) value = d(random);
  return x;
}

class Treated : public testing::TestWithParam<Treatment> {};

TEST_P(Treated, AddsWhatTheModelSays) {
  std::mt19937 random(3);
  for (const double parameter : parameters) {
    BaseProgram base;
    ComplementarityProgram program(base, pairs, GetParam(), parameter);
    const Eigen::VectorXd x = random_vector(program.variable_count(), random);
    const Eigen::VectorXd base_x = x.head(base_variables);
    const Eigen::VectorXd c = base.constraints(base_x);
    double added = 0.0;
    for (int k = 0; k < pair_count; ++k) {
      const double g = c[pairs[static_cast<std::size_t>(k)].row];
      const double f = base_x[pairs[static_cast<std::size_t>(k)].variable];
      double row = 0.0;
      switch (GetParam()) {
        case Treatment::penalty:
          added += parameter * g * f;
          continue;
        case Treatment::slack:
          row = g * f - x[base_variables + k];
          added += parameter * x[base_variables + k];
          break;
        case Treatment::scholtes:
          row = g * f;
          break;
        case Treatment::fischer_burmeister:
          row = g + f - std::sqrt(g * g + f * f + 2.0 * parameter);
          break;
      }
      // The same formula: rounding only.
      EXPECT_NEAR(program.constraints(x)[base_rows + k], row, 1e-14 * (1.0 + std::abs(row))) << "pair " << k;
    }
    EXPECT_NEAR(program.cost(x), base.cost(base_x) + added, 1e-13);
    EXPECT_NEAR(program.rest(x), base.rest(base_x) + added, 1e-13);
    EXPECT_EQ(program.residuals(x), base.residuals(base_x));
    EXPECT_EQ(program.constraints(x).head(base_rows), c);
  }
}

TEST_P(Treated, FirstDerivativesAgreeWithDifferences) {
  std::mt19937 random(5);
  for (const double parameter : parameters) {
    BaseProgram base;
    ComplementarityProgram program(base, pairs, GetParam(), parameter);
    // Several points of one program: what one of them left behind must not show at the next.
    for (int trial = 0; trial < 4; ++trial) {
      SCOPED_TRACE("parameter " + std::to_string(parameter) + ", point " + std::to_string(trial));
      expect_first_derivatives(program, random_vector(program.variable_count(), random));
    }
  }
}

TEST_P(Treated, HessiansAgreeWithDifferencesForEveryWeightOfTheCost) {
  std::mt19937 random(7);
  for (const double parameter : parameters) {
    BaseProgram base;
    ComplementarityProgram program(base, pairs, GetParam(), parameter);
    for (const double sigma : {1.0, 0.3, 2.5, 0.0}) {
      for (int trial = 0; trial < 3; ++trial) {
        SCOPED_TRACE("parameter " + std::to_string(parameter) + ", weight of the cost " + std::to_string(sigma));
        expect_hessian(program, random_vector(program.variable_count(), random), random, sigma);
      }
    }
  }
}

TEST_P(Treated, HessiansAgreeWithDifferencesAtTheCorner) {
  std::mt19937 random(9);
  BaseProgram base;
  ComplementarityProgram program(base, pairs, GetParam(), 0.3);
  for (int trial = 0; trial < 3; ++trial) {
    Eigen::VectorXd x = random_vector(program.variable_count(), random);
    // The force of either pair vanishes, as it does in most plans.
    x[2] = x[3] = 0.0;
    expect_first_derivatives(program, x);
    expect_hessian(program, x, random, 0.6);
  }
}

TEST_P(Treated, TakesANewParameterEverywhere) {
  std::mt19937 random(11);
  BaseProgram base, other_base;
  ComplementarityProgram moved(base, pairs, GetParam(), 0.3);
  ComplementarityProgram fresh(other_base, pairs, GetParam(), 0.01);
  const Eigen::VectorXd x = random_vector(moved.variable_count(), random);
  const Eigen::VectorXd y = random_vector(moved.row_count(), random);
  (void)moved.hessian(x, 0.5, y);
  moved.set_parameter(0.01);
  EXPECT_EQ(moved.parameter(), 0.01);
  EXPECT_EQ(moved.cost(x), fresh.cost(x));
  EXPECT_EQ(moved.gradient(x), fresh.gradient(x));
  EXPECT_EQ(moved.constraints(x), fresh.constraints(x));
  EXPECT_EQ(moved.jacobian(x), fresh.jacobian(x));
  EXPECT_EQ(moved.hessian(x, 0.5, y), fresh.hessian(x, 0.5, y));
  EXPECT_EQ(moved.row_lower(), fresh.row_lower());
  EXPECT_EQ(moved.row_upper(), fresh.row_upper());
}

TEST_P(Treated, KeepsTheBoundsOfTheBaseAndNamesWhatItAdds) {
  BaseProgram base;
  ComplementarityProgram program(base, pairs, GetParam(), 0.3);
  base.set_upper(0, 1.25);
  EXPECT_EQ(program.upper()[0], 5.0);
  program.refresh_bounds();
  EXPECT_EQ(program.upper().head(base_variables), base.upper());
  EXPECT_EQ(program.lower().head(base_variables), base.lower());
  EXPECT_EQ(program.row_lower().head(base_rows), base.row_lower());
  EXPECT_EQ(program.row_upper().head(base_rows), base.row_upper());
  EXPECT_EQ(program.row_name(2), "base row 2");
  EXPECT_EQ(program.variable_name(3), "base variable 3");
  const bool slack = GetParam() == Treatment::slack;
  ASSERT_EQ(program.variable_count(), base_variables + (slack ? pair_count : 0));
  ASSERT_EQ(program.row_count(), base_rows + (GetParam() == Treatment::penalty ? 0 : pair_count));
  for (int k = 0; slack && k < pair_count; ++k) {
    EXPECT_EQ(program.lower()[base_variables + k], 0.0);
    EXPECT_EQ(program.upper()[base_variables + k], infinity);
    EXPECT_EQ(program.variable_name(base_variables + k), "slack " + std::to_string(k + 1));
  }
  for (int i = base_rows; i < program.row_count(); ++i) {
    const bool one_sided = GetParam() == Treatment::scholtes;
    EXPECT_EQ(program.row_lower()[i], one_sided ? -infinity : 0.0);
    EXPECT_EQ(program.row_upper()[i], one_sided ? 0.3 : 0.0);
    EXPECT_EQ(program.row_name(i), "complementarity row " + std::to_string(i - base_rows + 1));
  }
}

TEST_P(Treated, StartsWhereTheBaseDoes) {
  std::mt19937 random(13);
  BaseProgram base;
  ComplementarityProgram program(base, pairs, GetParam(), 0.3);
  const Eigen::VectorXd base_x(Eigen::Vector4d(0.4, 0.7, 0.5, 0.8));
  const Eigen::VectorXd x = program.extend(base_x);
  ASSERT_EQ(x.size(), program.variable_count());
  EXPECT_EQ(x.head(base_variables), base_x);
  if (GetParam() != Treatment::slack) return;
  // The slack is the product, so that its row holds; where the product is negative, 0 is the nearest that it may be.
  EXPECT_LT(program.constraints(x).tail(pair_count).cwiseAbs().maxCoeff(), 1e-15);
  const Eigen::VectorXd beyond = program.extend(Eigen::Vector4d(0.4, 0.7, 0.5, -0.8));
  EXPECT_EQ(beyond[base_variables], 0.0);
  EXPECT_GT(beyond[base_variables + 1], 0.0);
}

INSTANTIATE_TEST_SUITE_P(All, Treated, testing::ValuesIn(treatments),
                         [](const auto& each) { return testing::PrintToString(each.param); });

/// Where one side of the pair is zero and the other not, a parameter of 0 makes the row of Fischer and Burmeister hold
/// exactly; elsewhere it does not.
TEST(FischerBurmeister, VanishesExactlyWhereThePairIsComplementary) {
  BaseProgram base;
  ComplementarityProgram program(base, pairs, Treatment::fischer_burmeister, 0.0);
  const Eigen::Vector4d open(0.4, 0.7, 0.0, 0.0);
  EXPECT_NEAR(program.constraints(open).tail(2).cwiseAbs().maxCoeff(), 0.0, 1e-15);
  const Eigen::Vector4d both(0.4, 0.7, 0.5, 0.5);
  EXPECT_GT(program.constraints(both).tail(2).minCoeff(), 0.1);
}

}  // namespace

}  // namespace tendril
