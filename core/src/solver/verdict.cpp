#include "solver/verdict.hpp"

#include <algorithm>
#include <cmath>

#include "solver/stop.hpp"

namespace tendril {

namespace {

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

VectorView view(const std::vector<double>& v) { return {v.data(), static_cast<Eigen::Index>(v.size())}; }

}  // namespace

double active_tolerance(double violation) { return std::clamp(10.0 * violation, 1e-6, 1e-3); }

void judge(NonlinearProgram& program, const SolveControl& control, const std::vector<double>& multipliers,
           const std::vector<double>& bound_multipliers, KktJudgement* known, OptimalityReport& report) {
  const double violation = infeasibility(program, report.x);
  const double active = active_tolerance(violation);
  const bool given = multipliers.size() == static_cast<std::size_t>(program.row_count()) &&
                     bound_multipliers.size() == static_cast<std::size_t>(program.variable_count());
  KktJudgement verdict;
  if (given) {
    const Eigen::VectorXd y = view(multipliers);
    const Eigen::VectorXd z = view(bound_multipliers);
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
        "stopped at a stationary point of the violation, which is " + shown(report.infeasibility, 3) + " there";
  } else if (report.status == SolveStatus::converged && !feasible) {
    report.status = SolveStatus::stalled;
    report.message =
        "the backend claims success at a point that violates its rows by " + shown(report.infeasibility, 3);
  } else if (report.status == SolveStatus::converged && !stationary) {
    report.status = SolveStatus::stalled;
    report.message = "the backend claims success where the Lagrangian's gradient is " + shown(report.stationarity, 3);
  }
}

}  // namespace tendril
