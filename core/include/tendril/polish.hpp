#pragma once

#include <functional>

#include "tendril/nonlinear_program.hpp"

namespace tendril {

/// When the polish is content, and when it gives up.
struct PolishOptions {
  double active_tolerance =
      1e-5;                      ///< a row or bound this near, or with a multiplier, is taken to be active at the start
  double row_tolerance = 1e-12;  ///< active rows are solved to this (dimensionless; equilibrium must reach 1e-9)
  double slope_tolerance = 1e-10;  ///< gradient of the Lagrangian, relative to 1 + largest multiplier
  int max_iterations = 40;         ///< Newton steps, over all active sets
  std::function<bool()> stop{};    ///< asked before every step; true: give up
};

/// Where the polish ended.
struct PolishReport {
  bool converged = false;
  Eigen::VectorXd x;
  Eigen::VectorXd multipliers, bound_multipliers;  ///< convention of SolverStart
  double infeasibility = infinity;                 ///< of all rows and bounds
  double stationarity = infinity;
  int iterations = 0;
  const char* reason = "";  ///< why it did not converge
};

/// Newton's method on the first-order conditions with the exact Hessian, on an active set that is corrected until no
/// inactive row is violated and no multiplier has the wrong sign. Local: it sharpens what a solver found, and it is the
/// warm start from one step of a trajectory to the next. `multipliers` may be empty.
TENDRIL_API PolishReport polish(NonlinearProgram& program, ConstVectorRef x, const Eigen::VectorXd& multipliers,
                                const PolishOptions& options = {});

}  // namespace tendril
