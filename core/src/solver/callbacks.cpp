// The program as a backend sees it: finite, within the time limit, and remembered where it was best.

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "base/clock.hpp"
#include "nlp/polish.hpp"
#include "solver/stop.hpp"
#include "solver/verdict.hpp"

namespace tendril {

namespace {

/// A cost below this has no minimum that a program of order one could mean.
constexpr double unbounded_cost = -1e20;

/// Multiplying by zero leaves NaN exactly where an entry is NaN or infinite, and vectorizes.
template <class Derived>
bool all_finite(const Eigen::MatrixBase<Derived>& m) {
  return m.size() == 0 || (m.array() * 0.0).sum() == 0.0;
}

void require_finite(double value, const char* what) {
  if (!std::isfinite(value)) throw_not_finite(what, value);
}

template <class Name>
void require_finite(const VectorView& v, const Name& name) {
  if (all_finite(v)) return;
  for (int i = 0; i < v.size(); ++i) {
    if (!std::isfinite(v[i])) throw_not_finite(name(i), v[i]);
  }
}

template <class Name>
void require_finite(const MatrixView& m, const Name& name) {
  if (all_finite(m)) return;
  for (int i = 0; i < m.rows(); ++i) {
    for (int j = 0; j < m.cols(); ++j) {
      if (!std::isfinite(m(i, j))) throw_not_finite(name(i, j), m(i, j));
    }
  }
}

/// The Lagrangian's Hessian has no negative direction along what is active: Newton did not run to a saddle.
bool curves_upward(NonlinearProgram& program, const PolishReport& report) {
  const int n = program.variable_count();
  std::vector<Eigen::VectorXd> active;
  const MatrixView jacobian = program.jacobian(report.x);
  for (int i = 0; i < program.row_count(); ++i) {
    if (program.is_equality(i) || report.multipliers[i] != 0.0) active.emplace_back(jacobian.row(i).transpose());
  }
  for (int i = 0; i < n; ++i) {
    const bool fixed = program.lower()[i] == program.upper()[i];
    if (fixed || report.bound_multipliers[i] != 0.0) active.emplace_back(Eigen::VectorXd::Unit(n, i));
  }
  Eigen::MatrixXd tangent = Eigen::MatrixXd::Identity(n, n);
  if (!active.empty()) {
    Eigen::MatrixXd columns(n, static_cast<Eigen::Index>(active.size()));
    for (Eigen::Index k = 0; k < columns.cols(); ++k) columns.col(k) = active[static_cast<std::size_t>(k)];
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(columns);
    tangent = Eigen::MatrixXd(qr.householderQ()).rightCols(n - qr.rank());
  }
  if (tangent.cols() == 0) return true;
  const Eigen::MatrixXd hessian = program.hessian(report.x, 1.0, report.multipliers);
  const Eigen::MatrixXd reduced = tangent.transpose() * hessian * tangent;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(reduced, Eigen::EigenvaluesOnly);
  return eigen.eigenvalues()[0] >= -1e-7 * std::max(1.0, hessian.norm());
}

}  // namespace

NotFiniteError::~NotFiniteError() = default;

Solver::Callbacks::Callbacks(NonlinearProgram& program, const SolveControl& control)
    : program_(program), control_(control), start_time_(now()), seen_(program.counts()) {}

double Solver::Callbacks::cost(ConstVectorRef x) {
  const double value = program_.cost(x);
  require_finite(value, "the cost");
  arrive(x);
  return value;
}

VectorView Solver::Callbacks::gradient(ConstVectorRef x) {
  const VectorView value = program_.gradient(x);
  require_finite(value, [&](int i) { return "the derivative of the cost by " + program_.variable_name(i); });
  arrive(x);
  return value;
}

VectorView Solver::Callbacks::constraints(ConstVectorRef x) {
  const VectorView value = program_.constraints(x);
  require_finite(value, [&](int i) { return program_.row_name(i); });
  arrive(x);
  return value;
}

MatrixView Solver::Callbacks::jacobian(ConstVectorRef x) {
  const MatrixView value = program_.jacobian(x);
  require_finite(value, [&](int i, int j) {
    return "the derivative of " + program_.row_name(i) + " by " + program_.variable_name(j);
  });
  arrive(x);
  return value;
}

MatrixView Solver::Callbacks::hessian(ConstVectorRef x, double sigma, ConstVectorRef multipliers) {
  const MatrixView value = program_.hessian(x, sigma, multipliers);
  require_finite(value, [&](int i, int j) {
    return "the second derivative of the Lagrangian by " + program_.variable_name(i) + " and " +
           program_.variable_name(j);
  });
  arrive(x);
  return value;
}

VectorView Solver::Callbacks::residuals(ConstVectorRef x) {
  const VectorView value = program_.residuals(x);
  require_finite(value, [](int i) { return "residual " + std::to_string(i + 1) + " of the cost"; });
  arrive(x);
  return value;
}

MatrixView Solver::Callbacks::residual_jacobian(ConstVectorRef x) {
  const MatrixView value = program_.residual_jacobian(x);
  require_finite(value, [&](int i, int j) {
    return "the derivative of residual " + std::to_string(i + 1) + " of the cost by " + program_.variable_name(j);
  });
  arrive(x);
  return value;
}

double Solver::Callbacks::rest(ConstVectorRef x) {
  const double value = program_.rest(x);
  require_finite(value, "the cost");
  arrive(x);
  return value;
}

VectorView Solver::Callbacks::rest_gradient(ConstVectorRef x) {
  const VectorView value = program_.rest_gradient(x);
  require_finite(value, [&](int i) { return "the derivative of the cost by " + program_.variable_name(i); });
  arrive(x);
  return value;
}

bool Solver::Callbacks::must_stop() const {
  return has_exception() || (control_.stop != nullptr && control_.stop->load(std::memory_order_relaxed)) ||
         seconds_left() <= 0.0;
}

void Solver::Callbacks::record_exception() {
  if (!exception_) exception_ = std::current_exception();
}

double Solver::Callbacks::seconds_left() const { return control_.time_limit - (now() - start_time_); }

Solver::Callbacks::Judgement Solver::Callbacks::judge(ConstVectorRef x) {
  const double scale = std::max(1.0, gradient(x).lpNorm<Eigen::Infinity>());
  constraints(x);
  jacobian(x);
  const double violation = infeasibility(program_, x);
  judged_x_ = x;
  verdict_ = judge_kkt(program_, x, active_tolerance(violation));
  return {verdict_.infeasibility, verdict_.stationarity, scale};
}

bool Solver::Callbacks::polish(VectorRef x, VectorRef multipliers, VectorRef bound_multipliers,
                               double active_tolerance) {
  PolishOptions options;
  options.active_tolerance = active_tolerance;
  const PolishReport report = tendril::polish(program_, x, multipliers, options);
  if (!report.converged || !curves_upward(program_, report)) return false;
  x = report.x;
  // Through the door of the callbacks: the point counts for best_x(), stop and time limit.
  cost(x);
  multipliers = report.multipliers;
  bound_multipliers = report.bound_multipliers;
  return true;
}

/// Called after every evaluation; costs nothing when the program knew the answer already.
void Solver::Callbacks::arrive(ConstVectorRef x) {
  const EvaluationCounts& counts = program_.counts();
  const bool new_values = counts.values != seen_.values;
  if (!new_values && counts.first_derivatives == seen_.first_derivatives && counts.hessians == seen_.hessians) return;
  seen_ = counts;
  if (new_values) {
    const double cost = program_.cost(x);
    // Violations below a tenth of the tolerance are equal: the cost decides there.
    const double violation = std::max(infeasibility(program_, x), 0.1 * control_.tolerance);
    if (std::isfinite(cost) && (violation < best_violation_ || (violation == best_violation_ && cost < best_cost_))) {
      best_violation_ = violation;
      best_cost_ = cost;
      best_x_ = x;
    }
    if (cost < unbounded_cost) {
      throw StopSolve(SolveStatus::diverged, "the cost fell to " + shown(cost, 3) + ": it has no lower bound");
    }
  }
  if (control_.stop != nullptr && control_.stop->load(std::memory_order_relaxed)) {
    throw StopSolve(SolveStatus::interrupted, "stop was asked for");
  }
  if (seconds_left() <= 0.0) {
    throw StopSolve(SolveStatus::time_limit, "the time limit of " + shown(control_.time_limit, 3) + " s is over");
  }
}

}  // namespace tendril
