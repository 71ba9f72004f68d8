#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "tendril/nonlinear_program.hpp"

namespace tendril {

/// Of sixth-order central differences: the error is step^6 times seventh derivatives and 1e-16/step from rounding,
/// relative to values that reach thousands where short pieces bend sharply; both stay below 1e-8 of the largest entry.
inline constexpr double step = 3e-4;
/// Of derivatives against differences, relative to 1 + the largest entry.
inline constexpr double tolerance = 1e-7;

/// Derivatives of f at x by central differences of sixth order, a column per entry of x.
template <class F>
Eigen::MatrixXd differences(const Eigen::VectorXd& x, F&& f, double e = step) {
  Eigen::MatrixXd out;
  for (int i = 0; i < x.size(); ++i) {
    const auto at = [&](double shift) {
      Eigen::VectorXd moved = x;
      moved[i] += shift;
      return Eigen::VectorXd(f(moved));
    };
    const Eigen::VectorXd d =
        (45.0 * (at(e) - at(-e)) - 9.0 * (at(2.0 * e) - at(-2.0 * e)) + (at(3.0 * e) - at(-3.0 * e))) / (60.0 * e);
    if (i == 0) out.resize(d.size(), x.size());
    out.col(i) = d;
  }
  return out;
}

inline double largest(const Eigen::MatrixXd& m) { return m.size() == 0 ? 0.0 : m.cwiseAbs().maxCoeff(); }

/// That no entry is further off than `tolerance` of 1 + the largest one; names the worst by what stands for its row and
/// its column.
template <class RowName, class ColumnName>
void expect_near(const char* what, const Eigen::MatrixXd& found, const Eigen::MatrixXd& expected, RowName&& row_name,
                 ColumnName&& column_name, double relative = tolerance) {
  ASSERT_EQ(found.rows(), expected.rows()) << what;
  ASSERT_EQ(found.cols(), expected.cols()) << what;
  if (expected.size() == 0) return;
  Eigen::Index row = 0;
  Eigen::Index column = 0;
  // NaN counts as the worst: no comparison holds for it.
  double worst = -1.0;
  for (Eigen::Index i = 0; i < expected.rows(); ++i) {
    for (Eigen::Index j = 0; j < expected.cols(); ++j) {
      const double off = std::abs(found(i, j) - expected(i, j));
      if (off <= worst || std::isnan(worst)) continue;
      worst = off;
      row = i;
      column = j;
    }
  }
  EXPECT_LT(worst, relative * (1.0 + largest(expected)))
      << what << " of " << row_name(static_cast<int>(row)) << " by " << column_name(static_cast<int>(column))
      << " (row " << row << ", column " << column << "): stated " << found(row, column) << ", expected "
      << expected(row, column);
}

/// Rows, cost, residuals and rest of a program at x, and that they belong together.
inline void expect_first_derivatives(NonlinearProgram& program, const Eigen::VectorXd& x) {
  const auto variable = [&](int i) { return program.variable_name(i); };
  const auto row = [&](int i) { return program.row_name(i); };
  const auto residual = [](int i) { return "residual " + std::to_string(i + 1); };
  const auto cost = [](int) { return std::string("the cost"); };
  const auto rest = [](int) { return std::string("the rest"); };
  const auto alone = [](double value) { return Eigen::VectorXd::Constant(1, value); };
  expect_near("the derivative", program.jacobian(x),
              differences(x, [&](const Eigen::VectorXd& y) { return program.constraints(y); }), row, variable);
  expect_near("the derivative", program.gradient(x).transpose(),
              differences(x, [&](const Eigen::VectorXd& y) { return alone(program.cost(y)); }), cost, variable);
  expect_near("the derivative", program.residual_jacobian(x),
              differences(x, [&](const Eigen::VectorXd& y) { return program.residuals(y); }), residual, variable);
  expect_near("the derivative", program.rest_gradient(x).transpose(),
              differences(x, [&](const Eigen::VectorXd& y) { return alone(program.rest(y)); }), rest, variable);
  EXPECT_NEAR(program.cost(x), program.residuals(x).squaredNorm() + program.rest(x),
              1e-12 * (1.0 + std::abs(program.cost(x))));
}

/// The Hessian of the Lagrangian at x with random multipliers of either sign, for a cost that has the weight `sigma`.
inline void expect_hessian(NonlinearProgram& program, const Eigen::VectorXd& x, std::mt19937& random,
                           double sigma = 0.7) {
  std::uniform_real_distribution<double> d(-1.0, 1.0);
  Eigen::VectorXd y(program.row_count());
  for (double& value : y) value = d(random);
  const Eigen::MatrixXd expected = differences(x, [&](const Eigen::VectorXd& z) {
    return Eigen::VectorXd(sigma * program.gradient(z) + program.jacobian(z).transpose() * y);
  });
  const Eigen::MatrixXd h = program.hessian(x, sigma, y);
  const auto variable = [&](int i) { return program.variable_name(i); };
  expect_near("the second derivative of the Lagrangian", h, expected, variable, variable);
  expect_near("the symmetry of the Lagrangian's second derivatives", h, h.transpose(), variable, variable, 1e-12);
}

}  // namespace tendril
