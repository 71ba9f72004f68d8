#pragma once

#include <Eigen/Core>
#include <atomic>
#include <exception>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tendril/error.hpp"
#include "tendril/export.hpp"
#include "tendril/nonlinear_program.hpp"

namespace tendril {

/// How a solve ended, the same words for every backend.
enum class SolveStatus {
  converged,  ///< the backend's own test passed; core still judges
  iteration_limit,
  time_limit,
  interrupted,  ///< stop was asked for (Ctrl-C)
  infeasible,   ///< the backend believes that no feasible point is near
  diverged,     ///< unbounded, or iterates left every sensible range
  stalled,      ///< no further progress (rounding, tiny steps)
  not_finite,   ///< NaN or infinity where a number was needed
  unsupported,  ///< the backend cannot take this program; message says why
  failed        ///< an exception or an internal error; message says which
};
TENDRIL_API std::string_view to_string(SolveStatus status);  ///< The status as results write it.

/// What a backend can do with a program.
struct SolverCapabilities {
  bool equalities = true;            ///< takes rows with equal bounds
  bool inequalities = true;          ///< takes other rows
  bool needs_finite_bounds = false;  ///< every variable must have both bounds
  bool uses_hessian = false;         ///< it calls hessian()
  bool uses_gradient = true;         ///< it calls gradient() and jacobian()
};

/// Where to start. Multipliers are optional; with them a backend that can warm-starts primal and dual.
///
/// ONE sign convention everywhere: the Lagrangian is  f + multipliers^T c + bound_multipliers^T x.  A row at its lower
/// bound has a multiplier <= 0, at its upper bound >= 0; likewise for the bounds of variables.
struct SolverStart {
  Eigen::VectorXd x;                  ///< variable_count() entries
  Eigen::VectorXd multipliers;        ///< empty: unknown
  Eigen::VectorXd bound_multipliers;  ///< empty: unknown
};

/// Limits that hold for every backend.
struct SolveControl {
  double tolerance = 1e-9;                  ///< on feasibility and stationarity, dimensionless
  double time_limit = 10.0;                 ///< s of wall time; infinity: none
  int max_iterations = 500;                 ///< of the backend
  const std::atomic<bool>* stop = nullptr;  ///< set to true from outside (a signal handler) to end the solve cleanly
};

/// What a solve gave, judged by core and not by the backend: feasibility and stationarity are computed here, alike for
/// all.
struct OptimalityReport {
  SolveStatus status = SolveStatus::failed;  ///< how it ended, after core's judgement
  std::string native_status;                 ///< the backend's own words
  std::string message;                 ///< what went wrong, if anything; an exception's text with the failing term
  Eigen::VectorXd x;                   ///< the point found
  double cost = 0.0;                   ///< of the program at x
  Eigen::VectorXd multipliers;         ///< convention of SolverStart
  Eigen::VectorXd bound_multipliers;   ///< convention of SolverStart
  bool multipliers_recovered = false;  ///< the backend has none; core found them by least squares
  double infeasibility = 0.0;          ///< largest violation of rows and bounds
  double stationarity = 0.0;           ///< largest entry of the Lagrangian's gradient
  int iterations = 0;                  ///< of the backend
  EvaluationCounts evaluations;        ///< of the program
  double seconds = 0.0;                ///< wall time of the whole solve
  double seconds_evaluating = 0.0;     ///< of it, inside the program's callbacks
  std::map<std::string, std::string> effective_options;  ///< native names
};

/// Thrown out of Solver::Callbacks where the program gave NaN or infinity; the message names the row or the cost. A
/// backend that can shorten its step catches it and tries nearer; one that cannot lets it pass.
class TENDRIL_API NotFiniteError : public Error {
 public:
  using Error::Error;
  NotFiniteError(const NotFiniteError&) = default;  ///< As exceptions are.
  ~NotFiniteError() override;
};

/// A backend for one nonlinear program at a time.
class TENDRIL_API Solver {
 public:
  virtual ~Solver();

  /// Checks capabilities and the start, resolves limits, times, counts evaluations, catches every exception and judges
  /// the result. Never throws for anything that a program or backend does; bad sizes throw Error.
  ///
  /// A start outside the bounds is moved onto them. A claim of success is believed only where the judgement agrees: an
  /// infeasible or non-stationary point is `stalled`, a stationary point of the violation is `infeasible`.
  OptimalityReport solve(NonlinearProgram& program, const SolverStart& start, const SolveControl& control);

  virtual std::string name() const = 0;  ///< As scenes name it.
  /// What it can do with the options that it was made with.
  virtual SolverCapabilities capabilities() const = 0;

 protected:
  /// The program as a backend sees it: every call is timed, checked for finiteness, and obeys stop and time limit by
  /// throwing a private exception, which the backend lets pass (or, where its library cannot pass exceptions, catches
  /// with `record_exception` and asks its library to stop). NotFiniteError alone may be swallowed.
  class TENDRIL_API Callbacks {
   public:
    ///@{
    /// As in NonlinearProgram, checked for finiteness.
    double cost(ConstVectorRef x);
    VectorView gradient(ConstVectorRef x);
    VectorView constraints(ConstVectorRef x);
    MatrixView jacobian(ConstVectorRef x);
    MatrixView hessian(ConstVectorRef x, double sigma, ConstVectorRef multipliers);
    VectorView residuals(ConstVectorRef x);
    MatrixView residual_jacobian(ConstVectorRef x);
    double rest(ConstVectorRef x);
    VectorView rest_gradient(ConstVectorRef x);
    ///@}

    /// Sizes, bounds and names.
    const NonlinearProgram& program() const { return program_; }
    /// True when the solve must end now: stop asked for, time over, or an exception recorded.
    bool must_stop() const;
    /// Keeps the exception being handled; solve() reports the first one kept. Call inside a catch block.
    void record_exception();
    /// Whether record_exception() kept one.
    bool has_exception() const { return static_cast<bool>(exception_); }
    /// Wall time left, s; infinity without a limit.
    double seconds_left() const;
    /// The point seen so far that violates least, and among equals costs least; the start until anything is better.
    VectorView best_x() const { return {best_x_.data(), best_x_.size()}; }

    /// Violation of the first-order conditions at a point.
    struct Judgement {
      double infeasibility = infinity;  ///< largest violation of rows and bounds
      double stationarity = infinity;   ///< largest entry of the Lagrangian's gradient
      double gradient_scale = 1.0;      ///< largest entry of the cost's gradient, at least 1
    };
    /// The first-order conditions at x with recovered multipliers, for a backend that doubts its library's word. Throws
    /// like the evaluations above.
    Judgement judge(ConstVectorRef x);

    /// Newton on the first-order conditions of the active set at x (polish.hpp), for a backend that gets near but not
    /// there. Rows count as active within `active_tolerance` unless their multiplier is 0. True: x and both multipliers
    /// are replaced by the sharpened ones. What the program throws passes.
    bool polish(VectorRef x, VectorRef multipliers, VectorRef bound_multipliers, double active_tolerance);

   private:
    friend class Solver;
    Callbacks(NonlinearProgram& program, const SolveControl& control);
    void arrive(ConstVectorRef x);

    NonlinearProgram& program_;
    const SolveControl& control_;
    double start_time_;
    EvaluationCounts seen_;
    std::exception_ptr exception_;
    Eigen::VectorXd best_x_;
    Eigen::VectorXd judged_x_;  ///< where verdict_ was given; the end of most solves
    KktJudgement verdict_;
    double best_violation_ = infinity;
    double best_cost_ = infinity;
  };

  /// SolverStart as a backend sees it: inside the bounds. Views without entries: unknown.
  struct Start {
    VectorView x;                  ///< variable_count() entries
    VectorView multipliers;        ///< row_count() entries
    VectorView bound_multipliers;  ///< variable_count() entries
    /// Whether there are multipliers to start from.
    bool has_multipliers() const { return multipliers.size() + bound_multipliers.size() > 0; }
  };

  /// What a backend hands back; status is required. Without x the best point seen counts.
  struct Outcome {
    SolveStatus status = SolveStatus::failed;                ///< how it ended
    std::string native_status{};                             ///< the library's own words
    std::string message{};                                   ///< for a user, where it did not converge
    std::vector<double> x{};                                 ///< the point found; empty: the best one seen
    std::vector<double> multipliers{};                       ///< convention of SolverStart; empty: core recovers them
    std::vector<double> bound_multipliers{};                 ///< convention of SolverStart; empty: core recovers them
    int iterations = 0;                                      ///< of the library
    std::map<std::string, std::string> effective_options{};  ///< native names, for the report
  };

  /// Solves the program from `start` within `control`. Exceptions of `callbacks` may pass; core catches them.
  virtual Outcome do_solve(Callbacks& callbacks, const Start& start, const SolveControl& control) = 0;
  /// Why the backend cannot take this program, in words; empty if it can. The default checks capabilities().
  virtual std::string refusal(const NonlinearProgram& program) const;
};

}  // namespace tendril
