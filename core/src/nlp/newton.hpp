#pragma once

#include <Eigen/Core>
#include <cmath>

namespace tendril {

/// Whether, and after how many steps.
struct NewtonOutcome {
  bool converged = false;
  int steps = 0;
};

/// Newton's method on a square system from z on. `correct(z, dz)` fills the correction at z and tells its size, which
/// is not finite where there is none. `share(z, dz, size)` tells how much of it is taken, at most 1; 0 gives up.
/// Corrections are squared from one step to the next: after a whole one of at most `small` one more is the last one.
template <class Correct, class Share>
NewtonOutcome newton(Eigen::VectorXd& z, Eigen::VectorXd& dz, int most_steps, double small, Correct correct,
                     Share share) {
  constexpr double rounding = 1e-12;
  NewtonOutcome out;
  for (bool last = false; out.steps < most_steps;) {
    ++out.steps;
    const double size = correct(z, dz);
    const double taken = std::isfinite(size) ? share(z, dz, size) : 0.0;
    if (!(taken > 0.0)) return out;
    z += taken * dz;
    const bool whole = taken == 1.0;
    out.converged = whole && (last || size <= rounding);
    if (out.converged) return out;
    last = whole && size <= small;
  }
  return out;
}

}  // namespace tendril
