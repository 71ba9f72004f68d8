#include "tendril/solver.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "clock.hpp"
#include "tendril/multipliers.hpp"
#include "tendril/polish.hpp"

namespace tendril {

namespace {

/// A cost below this has no minimum that a program of order one could mean.
constexpr double unbounded_cost = -1e20;

/// Ends a solve from inside a callback; only Solver::solve may catch it.
class StopSolve : public Error {
 public:
  StopSolve(SolveStatus why, const std::string& message) : Error(message), status(why) {}
  SolveStatus status;
};

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

/// Multiplying by zero leaves NaN exactly where an entry is NaN or infinite, and vectorizes.
template <class Derived>
bool all_finite(const Eigen::MatrixBase<Derived>& m) {
  return m.size() == 0 || (m.array() * 0.0).sum() == 0.0;
}

[[noreturn]] void throw_not_finite(const std::string& what, double value) {
  throw NotFiniteError(what + " is not finite (" + number(value) + ")");
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

/// "6 equilibrium rows, 1 contact_gap row": rows are counted by the name that stands before their number.
std::string count_rows(const NonlinearProgram& program, bool equalities) {
  std::vector<std::pair<std::string, int>> groups;
  for (int i = 0; i < program.row_count(); ++i) {
    if (program.is_equality(i) != equalities) continue;
    std::string group = program.row_name(i);
    const auto end = group.find_last_not_of("0123456789 ");
    if (end != std::string::npos) group.resize(end + 1);
    const std::string tail = " row";
    if (group.size() > tail.size() && group.ends_with(tail)) group.resize(group.size() - tail.size());
    const auto known = std::find_if(groups.begin(), groups.end(), [&](const auto& g) { return g.first == group; });
    if (known == groups.end()) {
      groups.emplace_back(group, 1);
    } else {
      ++known->second;
    }
  }
  std::string text;
  for (const auto& [group, count] : groups) {
    if (!text.empty()) text += ", ";
    text += std::to_string(count) + " ";
    if (group != "row") text += group + " ";
    text += count == 1 ? "row" : "rows";
  }
  return text;
}

/// A bound that nothing can satisfy, in words; empty if there is none.
std::string contradiction(const NonlinearProgram& program) {
  const auto check = [](double lower, double upper) {
    return !(lower <= upper) || lower == infinity || upper == -infinity;
  };
  for (int i = 0; i < program.variable_count(); ++i) {
    if (check(program.lower()[i], program.upper()[i])) {
      return program.variable_name(i) + " must be at least " + number(program.lower()[i]) + " and at most " +
             number(program.upper()[i]);
    }
  }
  for (int i = 0; i < program.row_count(); ++i) {
    if (check(program.row_lower()[i], program.row_upper()[i])) {
      return program.row_name(i) + " must be at least " + number(program.row_lower()[i]) + " and at most " +
             number(program.row_upper()[i]);
    }
  }
  return "";
}

/// x is a stationary point of the violation, squared or summed, along the rows and bounds that hold with equality: no
/// feasible point is near.
bool violation_is_stationary(NonlinearProgram& program, const Eigen::VectorXd& x, double violation) {
  constexpr double accuracy = 1e-5;
  const double touching = std::max(1e-7, 1e-5 * violation);
  const int n = program.variable_count();
  const MatrixView jacobian = program.jacobian(x);
  const VectorView c = program.constraints(x);
  Eigen::VectorXd squared = Eigen::VectorXd::Zero(n);
  Eigen::VectorXd summed = Eigen::VectorXd::Zero(n);
  double squared_size = 0.0;
  double summed_size = 0.0;
  Eigen::MatrixXd held(n, program.row_count() + n);
  std::vector<MultiplierSign> signs;
  for (int i = 0; i < program.row_count(); ++i) {
    const double v = std::max(c[i] - program.row_upper()[i], 0.0) - std::max(program.row_lower()[i] - c[i], 0.0);
    if (std::abs(v) > touching) {
      const double size = std::max(1.0, jacobian.row(i).norm());
      squared += v * jacobian.row(i).transpose();
      summed += std::copysign(1.0, v) * jacobian.row(i).transpose();
      squared_size += std::abs(v) * size;
      summed_size += size;
    } else if (const Activity a = activity(c[i], program.row_lower()[i], program.row_upper()[i], touching); a.any()) {
      held.col(static_cast<Eigen::Index>(signs.size())) = jacobian.row(i).transpose();
      signs.push_back(a.sign());
    }
  }
  for (int i = 0; i < n; ++i) {
    const Activity a = activity(x[i], program.lower()[i], program.upper()[i], touching);
    if (!a.any()) continue;
    held.col(static_cast<Eigen::Index>(signs.size())) = Eigen::VectorXd::Unit(n, i);
    signs.push_back(a.sign());
  }
  if (summed_size == 0.0) return false;
  const auto remainder = [&](const Eigen::VectorXd& slope) {
    return recover_multipliers(slope, held.leftCols(static_cast<Eigen::Index>(signs.size())), signs).residual.norm();
  };
  return remainder(squared) <= accuracy * squared_size || remainder(summed) <= accuracy * summed_size;
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

Eigen::VectorXd to_eigen(const std::vector<double>& v) {
  return VectorView(v.data(), static_cast<Eigen::Index>(v.size()));
}

VectorView view(const Eigen::VectorXd& v) { return {v.data(), v.size()}; }

/// How near counts as active: a point is as accurate as its rows are.
double active_tolerance(double violation) { return std::clamp(10.0 * violation, 1e-6, 1e-3); }

/// What the first-order conditions say at the end, with the backend's multipliers or, where those are missing or worse,
/// with recovered ones.
void judge(NonlinearProgram& program, const SolveControl& control, const std::vector<double>& multipliers,
           const std::vector<double>& bound_multipliers, KktJudgement* known, OptimalityReport& report) {
  const double violation = infeasibility(program, report.x);
  const double active = active_tolerance(violation);
  const bool given = multipliers.size() == static_cast<std::size_t>(program.row_count()) &&
                     bound_multipliers.size() == static_cast<std::size_t>(program.variable_count());
  KktJudgement verdict;
  if (given) {
    const Eigen::VectorXd y = to_eigen(multipliers);
    const Eigen::VectorXd z = to_eigen(bound_multipliers);
    if (y.allFinite() && z.allFinite()) verdict = judge_kkt(program, report.x, active, &y, &z);
  }
  if (!(verdict.stationarity <= 10.0 * control.tolerance)) {
    KktJudgement recovered = known != nullptr ? std::move(*known) : judge_kkt(program, report.x, active);
    if (!(verdict.stationarity <= recovered.stationarity)) {
      verdict = std::move(recovered);
      report.multipliers_recovered = true;
    }
  }
  report.cost = verdict.cost;
  report.infeasibility = verdict.infeasibility;
  report.stationarity = verdict.stationarity;
  report.multipliers = std::move(verdict.multipliers);
  report.bound_multipliers = std::move(verdict.bound_multipliers);
}

/// Lets the judgement overrule the backend's own word.
void weigh(NonlinearProgram& program, const SolveControl& control, OptimalityReport& report) {
  const bool ended_by_itself = report.status == SolveStatus::converged || report.status == SolveStatus::stalled ||
                               (report.status == SolveStatus::failed && report.message.empty());
  if (!ended_by_itself) return;
  const double slope_scale = std::max(1.0, program.gradient(report.x).lpNorm<Eigen::Infinity>());
  const bool feasible = report.infeasibility <= std::max(1e-6, 10.0 * control.tolerance);
  const bool stationary = report.stationarity <= std::max(1e-4, 10.0 * control.tolerance) * slope_scale;
  if (!feasible && violation_is_stationary(program, report.x, report.infeasibility)) {
    report.status = SolveStatus::infeasible;
    report.message =
        "stopped at a stationary point of the violation, which is " + number(report.infeasibility) + " there";
  } else if (report.status == SolveStatus::converged && !feasible) {
    report.status = SolveStatus::stalled;
    report.message = "the backend claims success at a point that violates its rows by " + number(report.infeasibility);
  } else if (report.status == SolveStatus::converged && !stationary) {
    report.status = SolveStatus::stalled;
    report.message = "the backend claims success where the Lagrangian's gradient is " + number(report.stationarity);
  }
}

}  // namespace

NotFiniteError::~NotFiniteError() = default;

Solver::~Solver() = default;

std::string_view to_string(SolveStatus status) {
  switch (status) {
    case SolveStatus::converged:
      return "converged";
    case SolveStatus::iteration_limit:
      return "iteration_limit";
    case SolveStatus::time_limit:
      return "time_limit";
    case SolveStatus::interrupted:
      return "interrupted";
    case SolveStatus::infeasible:
      return "infeasible";
    case SolveStatus::diverged:
      return "diverged";
    case SolveStatus::stalled:
      return "stalled";
    case SolveStatus::not_finite:
      return "not_finite";
    case SolveStatus::unsupported:
      return "unsupported";
    case SolveStatus::failed:
      return "failed";
  }
  return "unknown";
}

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
      throw StopSolve(SolveStatus::diverged, "the cost fell to " + number(cost) + ": it has no lower bound");
    }
  }
  if (control_.stop != nullptr && control_.stop->load(std::memory_order_relaxed)) {
    throw StopSolve(SolveStatus::interrupted, "stop was asked for");
  }
  if (seconds_left() <= 0.0) {
    throw StopSolve(SolveStatus::time_limit, "the time limit of " + number(control_.time_limit) + " s is over");
  }
}

std::string Solver::refusal(const NonlinearProgram& program) const {
  const SolverCapabilities can = capabilities();
  if (!can.equalities) {
    const std::string rows = count_rows(program, true);
    if (!rows.empty()) return name() + " cannot take equality constraints: " + rows;
  }
  if (!can.inequalities) {
    const std::string rows = count_rows(program, false);
    if (!rows.empty()) return name() + " cannot take inequality constraints: " + rows;
  }
  if (can.needs_finite_bounds) {
    for (int i = 0; i < program.variable_count(); ++i) {
      if (!std::isfinite(program.lower()[i]) || !std::isfinite(program.upper()[i])) {
        return name() + " needs finite bounds: " + program.variable_name(i) + " has none on one side";
      }
    }
  }
  return "";
}

OptimalityReport Solver::solve(NonlinearProgram& program, const SolverStart& start, const SolveControl& control) {
  const int n = program.variable_count();
  const int m = program.row_count();
  const auto require_size = [](const Eigen::VectorXd& v, int size, bool may_be_empty, const char* what) {
    if (v.size() == size || (may_be_empty && v.size() == 0)) return;
    throw Error(std::string(what) + " of the start has " + std::to_string(v.size()) + " entries, expected " +
                std::to_string(size));
  };
  require_size(start.x, n, false, "x");
  require_size(start.multipliers, m, true, "the vector of multipliers");
  require_size(start.bound_multipliers, n, true, "the vector of bound multipliers");

  const EvaluationCounts before = program.counts();
  Callbacks callbacks(program, control);
  OptimalityReport report;
  report.x = start.x;
  report.multipliers.setZero(m);
  report.bound_multipliers.setZero(n);
  report.cost = report.infeasibility = report.stationarity = infinity;
  const auto end_with = [&](SolveStatus status, std::string message) {
    report.status = status;
    report.message = std::move(message);
  };
  const auto explain_exception = [&] {
    try {
      std::rethrow_exception(callbacks.exception_);
    } catch (const StopSolve& e) {
      end_with(e.status, e.what());
    } catch (const NotFiniteError& e) {
      end_with(SolveStatus::not_finite, e.what());
    } catch (const std::exception& e) {
      end_with(SolveStatus::failed, e.what());
    } catch (...) {
      end_with(SolveStatus::failed, "an exception of unknown type");
    }
  };

  bool started = false;
  Outcome outcome;
  try {
    if (std::string why = refusal(program); !why.empty()) {
      end_with(SolveStatus::unsupported, std::move(why));
    } else if (std::string clash = contradiction(program); !clash.empty()) {
      end_with(SolveStatus::infeasible, std::move(clash));
    } else {
      for (int i = 0; i < n; ++i) {
        if (!std::isfinite(start.x[i])) throw_not_finite("the start of " + program.variable_name(i), start.x[i]);
        report.x[i] = std::clamp(start.x[i], program.lower()[i], program.upper()[i]);
      }
      callbacks.best_x_ = report.x;
      callbacks.gradient(report.x);
      callbacks.jacobian(report.x);
      callbacks.cost(report.x);
      callbacks.constraints(report.x);
      started = true;
      outcome = do_solve(callbacks, {view(report.x), view(start.multipliers), view(start.bound_multipliers)}, control);
      report.status = outcome.status;
      report.message = outcome.message;
    }
  } catch (...) {
    callbacks.record_exception();
  }
  report.native_status = std::move(outcome.native_status);
  report.iterations = outcome.iterations;
  report.effective_options = std::move(outcome.effective_options);

  if (callbacks.has_exception()) {
    explain_exception();
    if (started && callbacks.best_x_.size() == n) report.x = callbacks.best_x_;
  } else if (started) {
    const bool usable = outcome.x.size() == static_cast<std::size_t>(n) && to_eigen(outcome.x).allFinite();
    if (usable) {
      report.x = to_eigen(outcome.x);
    } else {
      report.x = callbacks.best_x_;
      if (!outcome.x.empty()) end_with(SolveStatus::not_finite, "the backend returned a point that is not finite");
    }
    if (report.status != SolveStatus::converged && control.stop != nullptr && control.stop->load()) {
      end_with(SolveStatus::interrupted, "stop was asked for");
    }
  }

  if (started) {
    try {
      const bool known = callbacks.judged_x_.size() == n && callbacks.judged_x_ == report.x;
      judge(program, control, outcome.multipliers, outcome.bound_multipliers, known ? &callbacks.verdict_ : nullptr,
            report);
      weigh(program, control, report);
    } catch (...) {
      callbacks.exception_ = std::current_exception();
      explain_exception();
    }
    if (!std::isfinite(report.cost) && report.status == SolveStatus::converged) {
      end_with(SolveStatus::not_finite, "the cost at the end is not finite");
    }
  }
  report.evaluations.values = program.counts().values - before.values;
  report.evaluations.first_derivatives = program.counts().first_derivatives - before.first_derivatives;
  report.evaluations.hessians = program.counts().hessians - before.hessians;
  report.evaluations.seconds = report.seconds_evaluating = program.counts().seconds - before.seconds;
  report.seconds = now() - callbacks.start_time_;
  return report;
}

}  // namespace tendril
