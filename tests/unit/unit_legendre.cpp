#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <vector>

#include "tendril/coordinate_model.hpp"
#include "tendril/error.hpp"

namespace tendril {
namespace {

struct Table {
  Eigen::MatrixXd value, first, second;
};

Table evaluate(int order, const std::vector<double>& sigma) {
  const auto rows = static_cast<Eigen::Index>(sigma.size());
  Table t{Eigen::MatrixXd(rows, order), Eigen::MatrixXd(rows, order), Eigen::MatrixXd(rows, order)};
  LegendreBasis(order).evaluate(sigma, t.value, t.first, t.second);
  return t;
}

/// Gauss-Legendre nodes and weights on [0,1], from the eigenvalues of the Jacobi matrix (Golub and Welsch).
void gauss(int n, std::vector<double>& nodes, std::vector<double>& weights) {
  Eigen::MatrixXd jacobi = Eigen::MatrixXd::Zero(n, n);
  for (int i = 1; i < n; ++i) jacobi(i, i - 1) = jacobi(i - 1, i) = i / std::sqrt(4.0 * i * i - 1.0);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(jacobi);
  for (int i = 0; i < n; ++i) {
    nodes.push_back(0.5 * (1.0 + solver.eigenvalues()[i]));
    weights.push_back(solver.eigenvectors()(0, i) * solver.eigenvectors()(0, i));
  }
}

TEST(LegendreBasis, FirstFunctionsAreThoseOfTheFormula) {
  // beta_1 = s, beta_2 = s^2 - s, beta_3 = 2 s^3 - 3 s^2 + s (model.md section 2).
  const double s = 0.3;
  const Table t = evaluate(3, {s});
  // A few roundings of numbers below 1.
  constexpr double rounding = 1e-15;
  EXPECT_NEAR(t.value(0, 0), s, rounding);
  EXPECT_NEAR(t.value(0, 1), s * s - s, rounding);
  EXPECT_NEAR(t.value(0, 2), 2 * s * s * s - 3 * s * s + s, rounding);
  EXPECT_NEAR(t.first(0, 2), 6 * s * s - 6 * s + 1, rounding);
  EXPECT_NEAR(t.second(0, 2), 12 * s - 6, 6 * rounding);
}

TEST(LegendreBasis, EndValuesAreExact) {
  const Table t = evaluate(LegendreBasis::maximum_order, {0.0, 1.0});
  for (int i = 0; i < LegendreBasis::maximum_order; ++i) {
    EXPECT_EQ(t.value(0, i), 0.0) << "function " << i + 1;
    EXPECT_EQ(t.value(1, i), i == 0 ? 1.0 : 0.0) << "function " << i + 1;
    EXPECT_EQ(t.first(1, i), 1.0) << "function " << i + 1;
    EXPECT_EQ(t.first(0, i), i % 2 == 0 ? 1.0 : -1.0) << "function " << i + 1;
  }
}

TEST(LegendreBasis, DerivativesAgreeWithCentralDifferences) {
  constexpr int order = LegendreBasis::maximum_order;
  constexpr double h = 1e-5;
  for (const double s : {0.02, 0.1, 0.37, 0.5, 0.81, 0.98}) {
    const Table t = evaluate(order, {s - h, s, s + h});
    for (int i = 0; i < order; ++i) {
      const double first = (t.value(2, i) - t.value(0, i)) / (2 * h);
      const double second = (t.first(2, i) - t.first(0, i)) / (2 * h);
      // h^2/6 times the derivative two orders up. P_n turns like cos(n theta) with dtheta/dsigma = 1/sqrt(s(1-s)), so
      // each derivative brings that factor; 2 for the envelope; plus rounding of a few 1e-16 / h.
      const double rate = (i + 1) / std::sqrt(s * (1 - s));
      EXPECT_NEAR(t.first(1, i), first, 2 * h * h / 6 * rate * rate + 1e-10) << "function " << i + 1 << " at " << s;
      EXPECT_NEAR(t.second(1, i), second, 2 * h * h / 6 * rate * rate * rate + 1e-9)
          << "function " << i + 1 << " at " << s;
    }
  }
}

TEST(LegendreBasis, SlopesAreOrthogonal) {
  constexpr int order = LegendreBasis::maximum_order;
  std::vector<double> nodes;
  std::vector<double> weights;
  gauss(order, nodes, weights);
  const Table t = evaluate(order, nodes);
  const Eigen::Map<const Eigen::VectorXd> w(weights.data(), order);
  const Eigen::MatrixXd gram = t.first.transpose() * w.asDiagonal() * t.first;
  for (int i = 0; i < order; ++i) {
    for (int k = 0; k < order; ++k) {
      // The rule is exact up to degree 127; 64 terms of size 1 and nodes good to a few 1e-16, slopes up to n^2 = 4e3.
      EXPECT_NEAR(gram(i, k), i == k ? 1.0 / (2 * i + 1) : 0.0, 1e-13) << i << ' ' << k;
    }
  }
}

TEST(LegendreBasis, ALowerOrderIsTheBeginningOfAHigherOne) {
  const std::vector<double> sigma{0.25, 0.75};
  EXPECT_EQ(evaluate(5, sigma).value, evaluate(9, sigma).value.leftCols(5));
}

TEST(LegendreBasis, PiecesAreEqualAndSumToOne) {
  EXPECT_EQ(LegendreBasis(3).subdivision(), std::vector<double>{1.0});
  EXPECT_EQ(LegendreBasis(3, 4).subdivision(), (std::vector<double>{0.25, 0.25, 0.25, 0.25}));
}

TEST(LegendreBasis, OrdersAndPiecesOutOfRangeAreRefused) {
  EXPECT_THROW(LegendreBasis(0), Error);
  EXPECT_THROW(LegendreBasis(65), Error);
  EXPECT_THROW(LegendreBasis(3, 0), Error);
  EXPECT_NO_THROW(LegendreBasis(64));
}

}  // namespace
}  // namespace tendril
