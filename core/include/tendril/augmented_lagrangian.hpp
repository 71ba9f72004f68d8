#pragma once

#include <cstdint>
#include <vector>

#include "tendril/export.hpp"
#include "tendril/solver.hpp"

namespace tendril {

/// Base of a backend whose library can do no more than reduce a sum of squares. It brings everything else into squares:
/// the program
///
///     min  sum r_i(x)^2 + rest(x)   s.t.  l <= c(x) <= u  (rows and bounds alike)
///
/// becomes, around the iterate x_k with multipliers y and penalty rho, half the sum of squares of
///
///     sqrt(2) r(x)
///     sqrt(rho) (s - clamp(s, l, u)),  s = c(x) + y / rho
///     W^(1/2) (x - x_k) + W^(-1/2) grad rest(x_k)
///
/// The last block is a proximal term with the rest made linear in it, completed to exact squares; W is the absolute
/// value of the rest's Hessian plus a weight that grows where the true function does not follow. Fixed variables are
/// left out. Multipliers are safeguarded, the penalty grows only when the violation does not fall enough, and a Newton
/// polish on the active set found ends the work early.
class TENDRIL_API AugmentedLagrangianSolver : public Solver {
 public:
  ~AugmentedLagrangianSolver() override;
  /// Rows, bounds and least squares, all by squares.
  SolverCapabilities capabilities() const override;

 protected:
  /// One sum of squares  |R(x)|^2 / 2  in the variables that are not fixed.
  class TENDRIL_API Subproblem {
   public:
    virtual ~Subproblem();
    /// Length of x.
    virtual int variable_count() const = 0;
    /// Length of R.
    virtual int residual_count() const = 0;
    /// Writes R and, unless `jacobian` is null, dR/dx in row-major order (residual_count() x variable_count()). False:
    /// there is no number at x, or the solve must end; then shorten the step or give up. Never throws.
    virtual bool evaluate(const double* x, double* residuals, double* jacobian) = 0;
    /// Stop when the largest entry of R^T dR/dx is below this.
    virtual double gradient_tolerance() const = 0;
    /// Most iterations of this reduction.
    virtual int iteration_limit() const = 0;
    /// Wall time left for the whole solve, s; infinity without a limit.
    virtual double seconds_left() const = 0;
  };

  /// How a reduction of the sum of squares ended.
  struct Reduction {
    bool usable = false;    ///< x was improved or is a minimum already
    bool finished = false;  ///< x is a minimum
    int iterations = 0;     ///< of the library
    std::string words{};    ///< the library's own
  };

  /// Reduces the sum of squares from x (subproblem.variable_count() entries), which holds the result after it.
  virtual Reduction reduce(Subproblem& subproblem, double* x) = 0;
  /// Native options for the report.
  virtual std::map<std::string, std::string> effective_options() const = 0;

  /// The outer loop around reduce().
  Outcome do_solve(Callbacks& callbacks, const Start& start, const SolveControl& control) final;

 private:
  class Loop;
};

}  // namespace tendril
