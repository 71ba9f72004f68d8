#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>

namespace tendril {

/// The normal equations of a least-squares fit where it stands: J^T J, and J^T times the residuals.
struct NormalEquations {
  Eigen::MatrixXd normal;
  Eigen::VectorXd gradient;
};

/// What became of a step that was tried.
enum class StepTried {
  moved,    ///< it was better, and the fit stands there now
  worse,    ///< or there was no such point
  too_long  ///< for the linearization to mean anything
};

/// How a fit ended.
enum class FitEnd { converged, stuck, step_limit };

/// Levenberg and Marquardt's method: `here(equations)` fills in the normal equations where the fit stands, or tells
/// that it has converged; `attempt(shift)` tries a step. `over()` ends it: then it is stuck. It stands here, and not
/// behind a Solver, since every residual is an equilibrium that is solved for in turn: a point that has none is a step
/// that was too long, each shape starts from the one before, and no plugin has to be there.
template <class Here, class Attempt, class Over>
FitEnd levenberg(int most_steps, Here here, Attempt attempt, Over over) {
  // Something that moves nothing must not be singular either.
  constexpr double least_weight = 1e-12;
  constexpr double most_damping = 1e12;
  constexpr double least_damping = 1e-9;
  double damping = 1e-3;
  NormalEquations at;
  for (int step = 0; step < most_steps && !over(); ++step) {
    if (here(at)) return FitEnd::converged;
    const Eigen::VectorXd weights = at.normal.diagonal().cwiseMax(least_weight);
    for (bool moved = false; !moved;) {
      if (!(damping < most_damping) || over()) return FitEnd::stuck;
      Eigen::MatrixXd damped = at.normal;
      damped.diagonal() += damping * weights;
      const StepTried tried = attempt(Eigen::VectorXd(-damped.ldlt().solve(at.gradient)));
      moved = tried == StepTried::moved;
      if (moved) {
        damping = damping < least_damping ? 0.0 : 0.1 * damping;
      } else {
        damping = std::max(least_damping, (tried == StepTried::too_long ? 4.0 : 10.0) * damping);
      }
    }
  }
  return FitEnd::step_limit;
}

}  // namespace tendril
