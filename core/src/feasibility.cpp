#include "tendril/feasibility.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "tendril/multipliers.hpp"

namespace tendril {
namespace {

/// Signed violation of every row.
void violations(const VectorView& c, const NonlinearProgram& program, Eigen::VectorXd& v) {
  v = (c - program.row_upper()).cwiseMax(0.0) - (program.row_lower() - c).cwiseMax(0.0);
}

}  // namespace

FeasibilityReport restore_feasibility(NonlinearProgram& program, ConstVectorRef start, double tolerance,
                                      int max_iterations, const std::function<bool()>& stop) {
  FeasibilityReport report;
  const int n = program.variable_count();
  Eigen::VectorXd x = start.cwiseMax(program.lower()).cwiseMin(program.upper());
  Eigen::VectorXd v;
  violations(program.constraints(x), program, v);
  double damping = 1e-3;
  double merit = v.squaredNorm();
  for (; report.iterations < max_iterations && std::isfinite(merit); ++report.iterations) {
    if (v.size() == 0 || v.cwiseAbs().maxCoeff() <= tolerance || (stop && stop())) break;
    const Eigen::MatrixXd jacobian = program.jacobian(x);
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd slope = Eigen::VectorXd::Zero(n);
    for (int i = 0; i < v.size(); ++i) {
      if (v[i] == 0.0) continue;
      normal.noalias() += jacobian.row(i).transpose() * jacobian.row(i);
      slope += v[i] * jacobian.row(i).transpose();
    }
    // Variables that push against their bound stay there.
    double largest = 0.0;
    for (int i = 0; i < n; ++i) {
      const bool held =
          (slope[i] > 0.0 && x[i] <= program.lower()[i]) || (slope[i] < 0.0 && x[i] >= program.upper()[i]);
      if (held) {
        normal.row(i).setZero();
        normal.col(i).setZero();
        normal(i, i) = 1.0;
        slope[i] = 0.0;
      }
      largest = std::max(largest, std::abs(slope[i]));
    }
    // Relative to the violation: its square has no descent direction left.
    if (largest <= 1e-8 * std::sqrt(merit)) {
      report.stationary_violation = true;
      break;
    }
    bool moved = false;
    while (damping < 1e12) {
      Eigen::MatrixXd damped = normal;
      damped.diagonal().array() += damping * (1.0 + normal.diagonal().array());
      const Eigen::VectorXd next = (x - damped.ldlt().solve(slope)).cwiseMax(program.lower()).cwiseMin(program.upper());
      Eigen::VectorXd next_v;
      violations(program.constraints(next), program, next_v);
      const double next_merit = next_v.squaredNorm();
      if (std::isfinite(next_merit) && next_merit < merit) {
        // Almost no progress over a full step: the valley floor of an infeasible program.
        const bool floor = next_merit > merit * (1.0 - 1e-7) && damping < 1.0;
        x = next;
        v = next_v;
        merit = next_merit;
        damping = std::max(1e-12, 0.2 * damping);
        moved = true;
        report.stationary_violation = floor;
        break;
      }
      damping *= 5.0;
    }
    if (!moved || report.stationary_violation) {
      report.stationary_violation = true;
      break;
    }
  }
  report.x = x;
  report.infeasibility = infeasibility(program, x);
  report.feasible = report.infeasibility <= tolerance;
  if (report.feasible) report.stationary_violation = false;
  return report;
}

}  // namespace tendril
