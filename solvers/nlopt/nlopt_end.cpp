// Where a run of NLopt ended: how good that is, and how to a point that violates nothing if it is not.

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "nlopt_run.hpp"

namespace tendril::nlopt_plugin {

NloptSolver::Verdict NloptSolver::judge(Callbacks& callbacks, const SolveControl& control, const VectorView& x) {
  if (!x.allFinite()) return {};
  const Callbacks::Judgement verdict = callbacks.judge(x);
  const double stationarity = verdict.stationarity / verdict.gradient_scale;
  const bool feasible = verdict.infeasibility <= 10.0 * control.tolerance;
  return {feasible, feasible && stationarity <= std::max(1e-6, 10.0 * control.tolerance),
          std::max(verdict.infeasibility, stationarity)};
}

/// NLopt returns the cheapest point among those within the tolerance of feasible, which may be off by the root of
/// that tolerance along the rows; the last iterate is normally far better. Leaves the better of both in x.
NloptSolver::Verdict NloptSolver::better_end(Run& run, const SolveControl& control, std::vector<double>& x) {
  const VectorView last(run.last.data(), run.last.size());
  const Verdict of_last = judge(run.callbacks, control, last);
  if (!of_last.good) {
    const Verdict of_best = judge(run.callbacks, control, {x.data(), static_cast<Eigen::Index>(x.size())});
    if (of_best.defect < of_last.defect) return of_best;
  }
  x.assign(last.begin(), last.end());
  return of_last;
}

/// Signed violation of each row at x.
Eigen::VectorXd NloptSolver::violations(Callbacks& callbacks, const Eigen::VectorXd& x) {
  const NonlinearProgram& program = callbacks.program();
  const VectorView c = callbacks.constraints(x);
  return (c - program.row_upper()).cwiseMax(0.0) - (program.row_lower() - c).cwiseMax(0.0);
}

/// Levenberg-Marquardt on the violation within the bounds. SLSQP leaves rows violated by 1e-8 where its inner least
/// squares lose digits, and gives up where the linearized rows contradict each other; both end here, near x, at a
/// feasible point or at one where the violation is least.
void NloptSolver::restore(Callbacks& callbacks, const SolveControl& control, std::vector<double>& point) {
  const NonlinearProgram& program = callbacks.program();
  Eigen::VectorXd x = VectorView(point.data(), static_cast<Eigen::Index>(point.size()))
                          .cwiseMax(program.lower())
                          .cwiseMin(program.upper());
  double damping = 1e-14;
  for (int step = 0; step < 100; ++step) {
    Eigen::MatrixXd violated = callbacks.jacobian(x);
    const Eigen::VectorXd v = violations(callbacks, x);
    if (v.lpNorm<Eigen::Infinity>() <= 0.1 * control.tolerance) break;
    for (int i = 0; i < v.size(); ++i) {
      if (v[i] == 0.0) violated.row(i).setZero();
    }
    for (int j = 0; j < x.size(); ++j) {
      const double slope = violated.col(j).dot(v);
      if ((slope > 0.0 && x[j] <= program.lower()[j]) || (slope < 0.0 && x[j] >= program.upper()[j]))
        violated.col(j).setZero();
    }
    const Eigen::VectorXd slope = violated.transpose() * v;
    if (slope.norm() <= 1e-12 * v.norm() * std::max(1.0, violated.norm())) break;
    Eigen::MatrixXd normal = violated.transpose() * violated;
    const double size = std::max(1e-300, normal.diagonal().maxCoeff());
    bool accepted = false;
    while (!accepted && damping < 1e8) {
      normal.diagonal().array() += damping * size;
      const Eigen::VectorXd trial =
          (x - normal.ldlt().solve(slope)).cwiseMax(program.lower()).cwiseMin(program.upper());
      normal.diagonal().array() -= damping * size;
      accepted = trial.allFinite() && improves(callbacks, trial, v.squaredNorm());
      if (accepted) x = trial;
      damping *= accepted ? 0.1 : 10.0;
    }
    if (!accepted) break;
    damping = std::max(damping, 1e-14);
  }
  point.assign(x.begin(), x.end());
}

bool NloptSolver::improves(Callbacks& callbacks, const Eigen::VectorXd& x, double squared_violation) {
  try {
    return violations(callbacks, x).squaredNorm() < squared_violation;
  } catch (const NotFiniteError&) {
    return false;
  }
}

}  // namespace tendril::nlopt_plugin
