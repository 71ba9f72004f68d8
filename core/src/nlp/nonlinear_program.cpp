#include "tendril/nonlinear_program.hpp"

#include <chrono>
#include <cstring>

#include "tendril/error.hpp"

namespace tendril {

namespace {

bool same_bits(const ConstVectorRef& a, const Eigen::VectorXd& b) {
  return std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(b.size())) == 0;
}

/// Adds the time of its own life to a sum, also when the program throws.
class Stopwatch {
 public:
  explicit Stopwatch(double& sum) : sum_(sum), start_(std::chrono::steady_clock::now()) {}
  ~Stopwatch() { sum_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  double& sum_;
  std::chrono::steady_clock::time_point start_;
};

void require_size(const ConstVectorRef& v, Eigen::Index size, const char* what) {
  if (v.size() != size) {
    throw Error(std::string(what) + " has " + std::to_string(v.size()) + " entries, expected " + std::to_string(size));
  }
}

}  // namespace

NonlinearProgram::NonlinearProgram(int variables, int rows, int residuals)
    : lower_(Eigen::VectorXd::Constant(variables, -infinity)),
      upper_(Eigen::VectorXd::Constant(variables, infinity)),
      row_lower_(Eigen::VectorXd::Zero(rows)),
      row_upper_(Eigen::VectorXd::Zero(rows)),
      x_(Eigen::VectorXd::Zero(variables)),
      hessian_multipliers_(Eigen::VectorXd::Zero(rows)) {
  work_.gradient.setZero(variables);
  work_.constraints.setZero(rows);
  work_.residuals.setZero(residuals);
  work_.rest_gradient.setZero(variables);
  work_.jacobian.setZero(rows, variables);
  work_.hessian.setZero(variables, variables);
  work_.residual_jacobian.setZero(residuals, variables);
}

NonlinearProgram::~NonlinearProgram() = default;

double NonlinearProgram::cost(ConstVectorRef x) {
  move_to(x, false);
  return work_.cost;
}

VectorView NonlinearProgram::gradient(ConstVectorRef x) {
  move_to(x, true);
  return view(work_.gradient);
}

VectorView NonlinearProgram::constraints(ConstVectorRef x) {
  move_to(x, false);
  return view(work_.constraints);
}

MatrixView NonlinearProgram::jacobian(ConstVectorRef x) {
  move_to(x, true);
  return view(work_.jacobian);
}

MatrixView NonlinearProgram::hessian(ConstVectorRef x, double sigma, ConstVectorRef multipliers) {
  require_size(multipliers, hessian_multipliers_.size(), "the vector of multipliers");
  move_to(x, true);
  if (!hessian_known_ || sigma != hessian_sigma_ || !same_bits(multipliers, hessian_multipliers_)) {
    hessian_known_ = false;
    hessian_sigma_ = sigma;
    hessian_multipliers_ = multipliers;
    ++counts_.hessians;
    const Stopwatch watch(counts_.seconds);
    do_hessian(x_, sigma, hessian_multipliers_, work_);
    hessian_known_ = true;
  }
  return view(work_.hessian);
}

VectorView NonlinearProgram::residuals(ConstVectorRef x) {
  move_to(x, false);
  return view(work_.residuals);
}

MatrixView NonlinearProgram::residual_jacobian(ConstVectorRef x) {
  move_to(x, true);
  return view(work_.residual_jacobian);
}

double NonlinearProgram::rest(ConstVectorRef x) {
  move_to(x, false);
  return work_.rest;
}

VectorView NonlinearProgram::rest_gradient(ConstVectorRef x) {
  move_to(x, true);
  return view(work_.rest_gradient);
}

std::string NonlinearProgram::row_name(int row) const { return "row " + std::to_string(row + 1); }

std::string NonlinearProgram::variable_name(int variable) const { return "variable " + std::to_string(variable + 1); }

void NonlinearProgram::invalidate() { values_known_ = derivatives_known_ = hessian_known_ = false; }

void NonlinearProgram::move_to(ConstVectorRef x, bool derivatives) {
  require_size(x, x_.size(), "the point");
  if (!values_known_ || !same_bits(x, x_)) {
    invalidate();
    x_ = x;
  }
  if (derivatives ? derivatives_known_ : values_known_) return;
  if (!values_known_) ++counts_.values;
  if (derivatives) ++counts_.first_derivatives;
  // A program that throws half way must not leave an old mark behind.
  values_known_ = derivatives_known_ = hessian_known_ = false;
  {
    const Stopwatch watch(counts_.seconds);
    do_evaluate(x_, derivatives, work_);
  }
  values_known_ = true;
  derivatives_known_ = derivatives;
}

}  // namespace tendril
