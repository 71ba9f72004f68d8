#pragma once

#include <functional>

#include "tendril/nonlinear_program.hpp"

namespace tendril {

/// Where a search for a feasible point ended.
struct FeasibilityReport {
  Eigen::VectorXd x;                ///< The point reached: variable_count() entries.
  double infeasibility = infinity;  ///< largest violation of rows and bounds
  bool feasible = false;            ///< infeasibility below the tolerance asked for
  /// Not feasible, and no direction within the bounds reduces the violation: a stationary point of its square.
  bool stationary_violation = false;
  int iterations = 0;  ///< steps taken
};

/// Reduces the violation of rows and bounds alone, by a projected Levenberg-Marquardt method with exact Jacobians. It
/// decides between "the solver failed" and "nothing feasible is near". `stop` is asked before every step; true: give
/// up.
TENDRIL_API FeasibilityReport restore_feasibility(NonlinearProgram& program, ConstVectorRef x, double tolerance,
                                                  int max_iterations = 200, const std::function<bool()>& stop = {});

}  // namespace tendril
