#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <random>

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

/// Rows, cost, residuals and rest of a program at x, and that they belong together.
inline void expect_first_derivatives(NonlinearProgram& program, const Eigen::VectorXd& x) {
  const auto expect = [](const Eigen::MatrixXd& found, const Eigen::MatrixXd& expected) {
    EXPECT_LT(largest(found - expected), tolerance * (1.0 + largest(expected)));
  };
  const auto alone = [](double value) { return Eigen::VectorXd::Constant(1, value); };
  expect(program.jacobian(x), differences(x, [&](const Eigen::VectorXd& y) { return program.constraints(y); }));
  expect(program.gradient(x).transpose(),
         differences(x, [&](const Eigen::VectorXd& y) { return alone(program.cost(y)); }));
  expect(program.residual_jacobian(x), differences(x, [&](const Eigen::VectorXd& y) { return program.residuals(y); }));
  expect(program.rest_gradient(x).transpose(),
         differences(x, [&](const Eigen::VectorXd& y) { return alone(program.rest(y)); }));
  EXPECT_NEAR(program.cost(x), program.residuals(x).squaredNorm() + program.rest(x),
              1e-12 * (1.0 + std::abs(program.cost(x))));
}

/// The Hessian of the Lagrangian at x with random multipliers.
inline void expect_hessian(NonlinearProgram& program, const Eigen::VectorXd& x, std::mt19937& random) {
  std::uniform_real_distribution<double> d(-1.0, 1.0);
  Eigen::VectorXd y(program.row_count());
  for (double& value : y) value = d(random);
  const double sigma = 0.7;
  const Eigen::MatrixXd expected = differences(x, [&](const Eigen::VectorXd& z) {
    return Eigen::VectorXd(sigma * program.gradient(z) + program.jacobian(z).transpose() * y);
  });
  const Eigen::MatrixXd h = program.hessian(x, sigma, y);
  EXPECT_LT(largest(h - expected), tolerance * (1.0 + largest(expected)));
  EXPECT_LT(largest(h - h.transpose()), 1e-12 * (1.0 + largest(expected)));
}

}  // namespace tendril
