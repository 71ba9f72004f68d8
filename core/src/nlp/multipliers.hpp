#pragma once

#include <Eigen/Core>
#include <span>

#include "tendril/export.hpp"
#include "tendril/nonlinear_program.hpp"

namespace tendril {

/// What sign a multiplier may have.
enum class MultiplierSign : unsigned char { free, non_negative, non_positive };

/// Multipliers of a bounded least-squares fit, and what they leave of the gradient.
struct MultiplierFit {
  Eigen::VectorXd multipliers;  ///< one per column of the matrix
  Eigen::VectorXd residual;     ///< gradient + active * multipliers
  bool exact_signs = true;  ///< false only if the iteration limit was met: the signs hold, the minimum is not proven
};

/// Bounded least squares: the y that minimizes |gradient + active * y|_2 under the signs asked for. `active` is n x k,
/// its columns the gradients of what is active; `signs` has k entries, else Error. Dependent columns are allowed: the
/// residual is unique all the same, and y is then one of the minimizers (the shortest one if no sign binds).
TENDRIL_API MultiplierFit recover_multipliers(ConstVectorRef gradient, ConstMatrixRef active,
                                              std::span<const MultiplierSign> signs);

/// Which side of lower <= value <= upper a multiplier may act on, within `tolerance` of the side.
struct Activity {
  bool at_lower = false;  ///< near or beyond the lower limit
  bool at_upper = false;  ///< near or beyond the upper limit
  /// Whether a multiplier may act at all.
  bool any() const { return at_lower || at_upper; }
  /// The sign that it may then have, in the convention of KktJudgement.
  MultiplierSign sign() const {
    if (at_lower && at_upper) return MultiplierSign::free;
    return at_lower ? MultiplierSign::non_positive : MultiplierSign::non_negative;
  }
};
/// Compares a value with its limits.
TENDRIL_API Activity activity(double value, double lower, double upper, double tolerance);

/// Judges x. Rows and bounds nearer than `active_tolerance` (or violated) count as active; their multipliers are
/// recovered by bounded least squares. With `multipliers` and `bound_multipliers` given (both, or neither) those are
/// judged instead, after inactive and wrong-signed entries are set to zero. Evaluates the program at x; its exceptions
/// pass.
TENDRIL_API KktJudgement judge_kkt(NonlinearProgram& program, ConstVectorRef x, double active_tolerance,
                                   const Eigen::VectorXd* multipliers = nullptr,
                                   const Eigen::VectorXd* bound_multipliers = nullptr);

/// The same for given multipliers, into `out`, whose memory is used again.
TENDRIL_API void judge_kkt(NonlinearProgram& program, ConstVectorRef x, double active_tolerance,
                           const Eigen::VectorXd& multipliers, const Eigen::VectorXd& bound_multipliers,
                           KktJudgement& out);

/// Largest violation of rows and bounds at x.
TENDRIL_API double infeasibility(NonlinearProgram& program, ConstVectorRef x);

}  // namespace tendril
