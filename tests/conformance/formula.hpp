#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tendril/hyper_dual.hpp"
#include "tendril/nonlinear_program.hpp"

namespace tendril::conformance {

/// Where a formula writes: the cost is  sum of residuals squared + rest.
template <class T>
struct Values {
  T rest{};
  std::vector<T> residuals;
  std::vector<T> rows;
};

struct Bounds {
  Eigen::VectorXd& lower;
  Eigen::VectorXd& upper;
  Eigen::VectorXd& row_lower;
  Eigen::VectorXd& row_upper;
};

/// A program written as one formula. `Formula` has
///
///     int variables, rows, residuals;
///     template <class T> void operator()(const T* x, Values<T>& out) const;
///     void bounds(Bounds b) const;        // everything starts open, rows as equations
///
/// Derivatives come from hyper-dual numbers and are exact.
template <class Formula>
class FormulaProgram : public NonlinearProgram {
 public:
  explicit FormulaProgram(Formula formula = {})
      : NonlinearProgram(formula.variables, formula.rows, formula.residuals), formula_(std::move(formula)) {
    resize(plain_);
    resize(dual_);
    plain_x_.resize(static_cast<std::size_t>(variable_count()));
    dual_x_.resize(static_cast<std::size_t>(variable_count()));
    formula_.bounds({lower_, upper_, row_lower_, row_upper_});
  }

 protected:
  void do_evaluate(ConstVectorRef x, bool derivatives, Workspace& out) override {
    for (Eigen::Index i = 0; i < x.size(); ++i) plain_x_[static_cast<std::size_t>(i)] = x[i];
    plain_.rest = 0.0;
    formula_(plain_x_.data(), plain_);
    out.rest = plain_.rest;
    for (Eigen::Index i = 0; i < out.residuals.size(); ++i)
      out.residuals[i] = plain_.residuals[static_cast<std::size_t>(i)];
    for (Eigen::Index i = 0; i < out.constraints.size(); ++i)
      out.constraints[i] = plain_.rows[static_cast<std::size_t>(i)];
    out.cost = out.rest + out.residuals.squaredNorm();
    if (!derivatives) return;
    for (Eigen::Index j = 0; j < x.size(); ++j) {
      along(x, j, j);
      out.rest_gradient[j] = dual_.rest.a;
      for (Eigen::Index i = 0; i < out.residuals.size(); ++i) {
        out.residual_jacobian(i, j) = dual_.residuals[static_cast<std::size_t>(i)].a;
      }
      for (Eigen::Index i = 0; i < out.constraints.size(); ++i)
        out.jacobian(i, j) = dual_.rows[static_cast<std::size_t>(i)].a;
    }
    out.gradient = out.rest_gradient;
    if (out.residuals.size() > 0) out.gradient += 2.0 * out.residual_jacobian.transpose() * out.residuals;
  }

  void do_hessian(ConstVectorRef x, double sigma, ConstVectorRef multipliers, Workspace& out) override {
    for (Eigen::Index j = 0; j < x.size(); ++j) {
      for (Eigen::Index i = 0; i <= j; ++i) {
        along(x, i, j);
        double sum = sigma * dual_.rest.ab;
        for (const HyperDual& r : dual_.residuals) sum += sigma * 2.0 * (r.v * r.ab + r.a * r.b);
        for (Eigen::Index k = 0; k < multipliers.size(); ++k)
          sum += multipliers[k] * dual_.rows[static_cast<std::size_t>(k)].ab;
        out.hessian(i, j) = out.hessian(j, i) = sum;
      }
    }
  }

 private:
  template <class T>
  void resize(Values<T>& values) {
    values.residuals.resize(static_cast<std::size_t>(residual_count()));
    values.rows.resize(static_cast<std::size_t>(row_count()));
  }

  void along(ConstVectorRef x, Eigen::Index a, Eigen::Index b) {
    for (Eigen::Index k = 0; k < x.size(); ++k) {
      dual_x_[static_cast<std::size_t>(k)] = {x[k], k == a ? 1.0 : 0.0, k == b ? 1.0 : 0.0, 0.0};
    }
    dual_.rest = 0.0;
    formula_(dual_x_.data(), dual_);
  }

  Formula formula_;
  Values<double> plain_;
  Values<HyperDual> dual_;
  std::vector<double> plain_x_;
  std::vector<HyperDual> dual_x_;
};

}  // namespace tendril::conformance
