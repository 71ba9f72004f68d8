#pragma once

#include <functional>
#include <string>

#include "base/deadline.hpp"
#include "nlp/feasibility.hpp"
#include "nlp/polish.hpp"
#include "tendril/plan.hpp"
#include "tendril/scene.hpp"
#include "tendril/solver.hpp"

namespace tendril {

inline constexpr double restored = 1e-8;  ///< violation below which a point counts as feasible

/// Whether a solver broke its promises: what it ended at is no part of any plan.
inline bool is_useless(const OptimalityReport& r) {
  return r.status == SolveStatus::failed || r.status == SolveStatus::unsupported || r.status == SolveStatus::not_finite;
}

/// How the record of a way of being in contact reads that the caller did not want tried.
inline constexpr const char* left_out_outcome = "not tried: left out on request";

/// What is known of the programs of one way of being in contact, for the report.
struct Attempt {
  ModeRecord record;
  int starts_used = 0;
  int stationary_violations = 0;  ///< starts that ended where no direction reduces the violation
  std::string trouble;            ///< how the last attempt failed
  OptimalityReport last;          ///< of the last solve
  double violation = infinity;    ///< least one of the rows that was found, as long as there is no point
  std::string limits;             ///< that bind there
};

struct Tally {
  int solves = 0;
  int useless_solves = 0;           ///< that the solver refused, or broke down in
  EvaluationCounts evaluations;     ///< that solvers asked for
  EvaluationCounts outside_solver;  ///< that polish and restoration asked for
  int iterations = 0;
  double seconds = 0.0, seconds_evaluating = 0.0, seconds_certifying = 0.0;
  double work =
      0.0;  ///< of evaluations and the algebra between them: grows as the time does, and is the same on any machine
  /// Counts what a program was asked by a solver.
  void add_inside(const NonlinearProgram& program, const EvaluationCounts& asked);
  /// Counts what a program was asked otherwise since `before`.
  void add_outside(const NonlinearProgram& program, const EvaluationCounts& before);
  /// Counts steps of a rod of so many coordinates, each with its derivatives.
  void add_looks(int looks, int coordinates);
  /// A solver that did nothing is no part of any plan, whatever restoration and Newton's method make of the start
  /// alone.
  bool solver_did_nothing() const { return solves > 0 && useless_solves == solves; }
};

/// So many looks, each a step downhill or along a path of loads in so many coordinates; their work counts in the end.
class CountedLooks : public Allowance {
 public:
  /// `tally` must outlive this.
  CountedLooks(Tally& tally, const Deadline& deadline, int looks, int coordinates)
      : Allowance(deadline, looks), tally_(tally), coordinates_(coordinates) {}
  ~CountedLooks() { tally_.add_looks(taken(), coordinates_); }
  CountedLooks(const CountedLooks&) = delete;
  CountedLooks& operator=(const CountedLooks&) = delete;

 private:
  Tally& tally_;
  int coordinates_;
};

/// What a plan says of a solver that did nothing.
std::string refusal_message(const std::string& solver, const OptimalityReport& last);

/// Puts a tally into a plan: sums over all programs.
void report_tally(const Tally& tally, Plan& plan);

/// The steps from a point of a program to a better one, whatever the program is of: counted, and within one time limit.
class ProgramSearch {
 public:
  /// All three must outlive this.
  ProgramSearch(Solver& solver, const SolverSpec& spec, const PlanControl& control)
      : solver_(solver), spec_(spec), progress_(control.progress), deadline_(control.stop, spec.time_limit) {}

  bool must_stop() const { return deadline_.over(); }
  const Deadline& deadline() const { return deadline_; }
  /// From now on a solve may take no more than many times what others took. Programs of a grasp differ little: a search
  /// that takes longer ends nowhere.
  void limit_patience(bool limited) { limited_ = limited; }

  OptimalityReport solve(Attempt& attempt, NonlinearProgram& program, const Eigen::VectorXd& x,
                         const OptimalityReport* warm = nullptr);
  /// What Newton's method came to, if x of the last sharpen() or descend() is its point, else null.
  const PolishReport* polished() const { return polished_; }
  /// Newton on the active set, after a solve if it needs one and may have it. False: x is no point to judge.
  bool sharpen(Attempt& attempt, NonlinearProgram& program, Eigen::VectorXd& x, bool solver_allowed);
  /// Newton from a feasible point to a minimum near that costs no more, without the solver. False: x is as it was.
  bool descend(Attempt& attempt, NonlinearProgram& program, Eigen::VectorXd& x);
  /// Reduces the violation alone, and remembers where there is nothing feasible near.
  FeasibilityReport restore(Attempt& attempt, NonlinearProgram& program, const Eigen::VectorXd& x);
  /// The same as a look that leaves no trace but its counts; `patiently`: however slowly the violation falls.
  FeasibilityReport restoration(NonlinearProgram& program, const Eigen::VectorXd& x, bool patiently = false);

  /// Remembers what such a look came to, where it ended at no feasible point.
  static void record_violation(Attempt& attempt, const NonlinearProgram& program, const FeasibilityReport& f);

  Tally tally;

 private:
  Solver& solver_;
  const SolverSpec& spec_;
  const std::function<void()>& progress_;
  Deadline deadline_;
  Polisher polisher_;
  const PolishReport* polished_ = nullptr;
  bool limited_ = false;
  int slowest_converged_ =
      10;  ///< most iterations of a solve that converged; one of a grasp is thought to take so many
};

}  // namespace tendril
