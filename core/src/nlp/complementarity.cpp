#include "nlp/complementarity.hpp"

#include <algorithm>
#include <cmath>

namespace tendril {

std::string_view to_string(Treatment treatment) {
  switch (treatment) {
    case Treatment::penalty:
      return "penalty";
    case Treatment::slack:
      return "slack";
    case Treatment::scholtes:
      return "scholtes";
    case Treatment::fischer_burmeister:
      return "fischer_burmeister";
  }
  return "?";
}
namespace {

int extra_rows(Treatment treatment, std::size_t pairs) {
  return treatment == Treatment::penalty ? 0 : static_cast<int>(pairs);
}

int extra_variables(Treatment treatment, std::size_t pairs) {
  return treatment == Treatment::slack ? static_cast<int>(pairs) : 0;
}

}  // namespace

ComplementarityProgram::ComplementarityProgram(NonlinearProgram& base, std::vector<ComplementaryPair> pairs,
                                               Treatment treatment, double parameter)
    : NonlinearProgram(base.variable_count() + extra_variables(treatment, pairs.size()),
                       base.row_count() + extra_rows(treatment, pairs.size()), base.residual_count()),
      base_(base),
      pairs_(std::move(pairs)),
      treatment_(treatment),
      parameter_(parameter),
      base_variables_(base.variable_count()),
      base_rows_(base.row_count()) {
  base_x_.setZero(base_variables_);
  base_multipliers_.setZero(base_rows_);
  refresh_bounds();
}

ComplementarityProgram::~ComplementarityProgram() = default;

void ComplementarityProgram::refresh_bounds() {
  lower_.setZero();
  upper_.setConstant(infinity);
  lower_.head(base_variables_) = base_.lower();
  upper_.head(base_variables_) = base_.upper();
  row_lower_.setZero();
  row_upper_.setZero();
  row_lower_.head(base_rows_) = base_.row_lower();
  row_upper_.head(base_rows_) = base_.row_upper();
  if (treatment_ == Treatment::scholtes) {
    row_lower_.tail(row_count() - base_rows_).setConstant(-infinity);
    row_upper_.tail(row_count() - base_rows_).setConstant(parameter_);
  }
  invalidate();
}

void ComplementarityProgram::set_parameter(double parameter) {
  parameter_ = parameter;
  refresh_bounds();
}

Eigen::VectorXd ComplementarityProgram::extend(ConstVectorRef base_x) {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(variable_count());
  x.head(base_variables_) = base_x;
  if (treatment_ == Treatment::slack) {
    const VectorView c = base_.constraints(base_x);
    for (std::size_t k = 0; k < pairs_.size(); ++k) {
      x[base_variables_ + static_cast<int>(k)] = std::max(0.0, c[pairs_[k].row] * base_x[pairs_[k].variable]);
    }
  }
  return x;
}

ComplementarityProgram::Coupling ComplementarityProgram::couple(double g, double f) const {
  if (treatment_ == Treatment::fischer_burmeister) {
    const double root = std::sqrt(g * g + f * f + 2.0 * parameter_);
    const double cube = root * root * root;
    return {g + f - root,   1.0 - g / root,
            1.0 - f / root, -(f * f + 2.0 * parameter_) / cube,
            g * f / cube,   -(g * g + 2.0 * parameter_) / cube};
  }
  return {g * f, f, g, 0.0, 1.0, 0.0};
}

void ComplementarityProgram::do_evaluate(ConstVectorRef x, bool derivatives, Workspace& out) {
  base_x_ = x.head(base_variables_);
  const VectorView c = base_.constraints(base_x_);
  out.constraints.head(base_rows_) = c;
  out.cost = base_.cost(base_x_);
  out.rest = base_.rest(base_x_);
  out.residuals = base_.residuals(base_x_);
  double extra = 0.0;
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    const auto i = static_cast<int>(k);
    const double g = c[pairs_[k].row];
    const double f = base_x_[pairs_[k].variable];
    if (treatment_ == Treatment::penalty) extra += parameter_ * g * f;
    if (treatment_ == Treatment::slack) extra += parameter_ * x[base_variables_ + i];
    if (!has_rows()) continue;
    out.constraints[base_rows_ + i] =
        couple(g, f).value - (treatment_ == Treatment::slack ? x[base_variables_ + i] : 0.0);
  }
  out.cost += extra;
  out.rest += extra;
  if (!derivatives) return;

  const MatrixView jacobian = base_.jacobian(base_x_);
  out.jacobian.topLeftCorner(base_rows_, base_variables_) = jacobian;
  out.gradient.head(base_variables_) = base_.gradient(base_x_);
  out.rest_gradient.head(base_variables_) = base_.rest_gradient(base_x_);
  out.residual_jacobian.leftCols(base_variables_) = base_.residual_jacobian(base_x_);
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    const auto i = static_cast<int>(k);
    const auto [row, variable] = pairs_[k];
    const double g = c[row];
    const double f = base_x_[variable];
    if (treatment_ == Treatment::penalty) {
      for (Eigen::VectorXd* gradient : {&out.gradient, &out.rest_gradient}) {
        gradient->noalias() += parameter_ * f * jacobian.row(row).transpose();
        (*gradient)[variable] += parameter_ * g;
      }
      continue;
    }
    const Coupling psi = couple(g, f);
    out.jacobian.row(base_rows_ + i).head(base_variables_) = psi.g * jacobian.row(row);
    out.jacobian(base_rows_ + i, variable) += psi.f;
    if (treatment_ == Treatment::slack) {
      out.jacobian(base_rows_ + i, base_variables_ + i) = -1.0;
      out.gradient[base_variables_ + i] = parameter_;
      out.rest_gradient[base_variables_ + i] = parameter_;
    }
  }
}

void ComplementarityProgram::do_hessian(ConstVectorRef x, double sigma, ConstVectorRef multipliers, Workspace& out) {
  base_x_ = x.head(base_variables_);
  const VectorView c = base_.constraints(base_x_);
  base_multipliers_ = multipliers.head(base_rows_);
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    const double f = base_x_[pairs_[k].variable];
    if (treatment_ == Treatment::penalty) {
      base_multipliers_[pairs_[k].row] += sigma * parameter_ * f;
    } else {
      base_multipliers_[pairs_[k].row] += multipliers[base_rows_ + static_cast<int>(k)] * couple(c[pairs_[k].row], f).g;
    }
  }
  out.hessian.topLeftCorner(base_variables_, base_variables_) = base_.hessian(base_x_, sigma, base_multipliers_);
  const MatrixView jacobian = base_.jacobian(base_x_);
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    const auto [row, variable] = pairs_[k];
    double gg = 0.0;
    double gf = sigma * parameter_;
    double ff = 0.0;
    if (has_rows()) {
      const Coupling psi = couple(c[row], base_x_[variable]);
      const double y = multipliers[base_rows_ + static_cast<int>(k)];
      gg = y * psi.gg;
      gf = y * psi.gf;
      ff = y * psi.ff;
    }
    for (int i = 0; i < base_variables_; ++i) {
      const double gi = jacobian(row, i);
      if (gi == 0.0) continue;
      if (gg != 0.0) {
        for (int j = 0; j < base_variables_; ++j) out.hessian(i, j) += gg * gi * jacobian(row, j);
      }
      out.hessian(i, variable) += gf * gi;
      out.hessian(variable, i) += gf * gi;
    }
    out.hessian(variable, variable) += ff;
  }
}

std::string ComplementarityProgram::row_name(int row) const {
  return row < base_rows_ ? base_.row_name(row) : "complementarity row " + std::to_string(row - base_rows_ + 1);
}

std::string ComplementarityProgram::variable_name(int variable) const {
  return variable < base_variables_ ? base_.variable_name(variable)
                                    : "slack " + std::to_string(variable - base_variables_ + 1);
}

}  // namespace tendril
