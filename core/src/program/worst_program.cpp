#include "program/worst_program.hpp"

#include <algorithm>
#include <utility>

namespace tendril {
namespace {

int row_total(const std::vector<WorstProgram::State>& states) {
  int rows = 0;
  for (const WorstProgram::State& s : states) rows += 1 + s.program->row_count();
  return rows;
}

int moment_count(const WorstProgram::State& state) {
  return state.program->variable_count() - static_cast<int>(state.ratios.size());
}

}  // namespace

WorstProgram::WorstProgram(std::vector<State> states, double unit)
    : NonlinearProgram(moment_count(states.front()) + 1, row_total(states), 0),
      states_(std::move(states)),
      unit_(unit),
      moments_(moment_count(states_.front())) {
  lower_ << states_.front().program->lower().head(moments_), -infinity;
  upper_ << states_.front().program->upper().head(moments_), infinity;
  int row = 0;
  for (const State& s : states_) {
    first_.push_back(row);
    row_lower_[row] = 0.0;
    row_upper_[row] = infinity;
    const int count = s.program->row_count();
    row_lower_.segment(row + 1, count) = s.program->row_lower();
    row_upper_.segment(row + 1, count) = s.program->row_upper();
    row += 1 + count;
  }
  first_.push_back(row);
  variables_.setZero(states_.front().program->variable_count());
  multipliers_.setZero(states_.front().program->row_count());
}

const Eigen::VectorXd& WorstProgram::point(std::size_t state, ConstVectorRef x) {
  variables_ << x.head(moments_), states_[state].ratios;
  return variables_;
}

Eigen::VectorXd WorstProgram::start(ConstVectorRef moments) {
  Eigen::VectorXd x(moments_ + 1);
  x << moments, 0.0;
  double worst = -infinity;
  for (std::size_t k = 0; k < states_.size(); ++k) worst = std::max(worst, states_[k].program->cost(point(k, x)));
  x[moments_] = worst / unit_;
  return x;
}

void WorstProgram::do_evaluate(ConstVectorRef x, bool derivatives, Workspace& out) {
  out.cost = out.rest = x[moments_];
  if (derivatives) {
    out.gradient.setZero();
    out.gradient[moments_] = 1.0;
    out.rest_gradient = out.gradient;
  }
  for (std::size_t k = 0; k < states_.size(); ++k) {
    ReducedProgram& state = *states_[k].program;
    const Eigen::VectorXd& at = point(k, x);
    const int row = first_[k];
    const int count = state.row_count();
    if (derivatives) {
      out.jacobian.row(row).head(moments_) = -state.gradient(at).head(moments_) / unit_;
      out.jacobian(row, moments_) = 1.0;
      out.jacobian.block(row + 1, 0, count, moments_) = state.jacobian(at).leftCols(moments_);
      out.jacobian.block(row + 1, moments_, count, 1).setZero();
    }
    out.constraints[row] = x[moments_] - state.cost(at) / unit_;
    out.constraints.segment(row + 1, count) = state.constraints(at);
  }
}

void WorstProgram::do_hessian(ConstVectorRef x, double /*sigma*/, ConstVectorRef multipliers, Workspace& out) {
  out.hessian.setZero();
  for (std::size_t k = 0; k < states_.size(); ++k) {
    ReducedProgram& state = *states_[k].program;
    multipliers_ = multipliers.segment(first_[k] + 1, state.row_count());
    const MatrixView own = state.hessian(point(k, x), -multipliers[first_[k]] / unit_, multipliers_);
    out.hessian.topLeftCorner(moments_, moments_) += own.topLeftCorner(moments_, moments_);
  }
}

std::string WorstProgram::row_name(int row) const {
  const auto behind = std::upper_bound(first_.begin(), first_.end(), row);
  const auto k = static_cast<std::size_t>(behind - first_.begin()) - 1;
  const std::string name = "state of friction " + std::to_string(k + 1) + ": ";
  return name + (row == first_[k] ? "cost" : states_[k].program->row_name(row - first_[k] - 1));
}

std::string WorstProgram::variable_name(int variable) const {
  return variable == moments_ ? "worst cost" : states_.front().program->variable_name(variable);
}

}  // namespace tendril
