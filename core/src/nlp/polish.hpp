#pragma once

#include <functional>
#include <memory>

#include "tendril/nonlinear_program.hpp"

namespace tendril {

/// When the polish is content, and when it gives up.
struct PolishOptions {
  double active_tolerance =
      1e-5;                      ///< a row or bound this near, or with a multiplier, is taken to be active at the start
  double row_tolerance = 1e-12;  ///< active rows are solved to this (dimensionless; equilibrium must reach 1e-9)
  double slope_tolerance = 1e-10;  ///< gradient of the Lagrangian, relative to 1 + largest multiplier
  int max_iterations = 40;         ///< Newton steps, over all active sets
  /// From a point that may be far off: bounds stop the steps, and an end from which the objective falls is none.
  bool descends = false;
  std::function<bool()> stop{};  ///< asked before every step; true: give up
};

/// Where the polish ended.
struct PolishReport {
  bool converged = false;             ///< All first-order conditions hold to the tolerances asked for.
  Eigen::VectorXd x;                  ///< variable_count() entries
  Eigen::VectorXd multipliers;        ///< of the rows, convention of SolverStart
  Eigen::VectorXd bound_multipliers;  ///< of the variables, convention of SolverStart
  double infeasibility = infinity;    ///< of all rows and bounds
  double stationarity = infinity;     ///< largest entry of the Lagrangian's gradient
  int iterations = 0;                 ///< Newton steps taken
  const char* reason = "";            ///< why it did not converge
};

/// Newton's method on the first-order conditions with the exact Hessian, on an active set that is corrected until no
/// inactive row is violated and no multiplier has the wrong sign. Local: it sharpens what a solver found, and it is the
/// warm start from one step of a trajectory to the next. Keeps its memory: as long as program sizes and active set stay
/// what they were in the run before, and no system is singular, a run allocates nothing.
class TENDRIL_API Polisher {
 public:
  Polisher();
  Polisher(Polisher&&) noexcept;             ///< the other may then only be assigned to or destroyed
  Polisher& operator=(Polisher&&) noexcept;  ///< likewise
  ~Polisher();

  /// Later runs begin with the factorization of the run before, if the active set is its own, as long as they converge
  /// fast: for a program that changes little, near where that run ended.
  void keep_factorization();
  /// `multipliers` may be empty: they are fitted at x. The report is this object's, until the next run.
  const PolishReport& run(NonlinearProgram& program, ConstVectorRef x, const Eigen::VectorXd& multipliers,
                          const PolishOptions& options = {});

 private:
  class Newton;
  std::unique_ptr<Newton> newton_;
};

/// One run of a Polisher of its own.
TENDRIL_API PolishReport polish(NonlinearProgram& program, ConstVectorRef x, const Eigen::VectorXd& multipliers,
                                const PolishOptions& options = {});

}  // namespace tendril
