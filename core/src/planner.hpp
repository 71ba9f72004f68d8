#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "clock.hpp"
#include "load_path.hpp"
#include "problem_data.hpp"
#include "tendril/certificate.hpp"
#include "tendril/tolerances.hpp"

namespace tendril {

/// Numbers that steer the search. They decide how a plan is found, never whether it is accepted.
inline constexpr int least_iterations = 10;  ///< that a solve of a grasp is thought to take
/// Iterations of a solve of a grasp with a plan, over those of the slowest solve that converged.
inline constexpr int patience = 8;
inline constexpr int most_starts = 5;        ///< per mode, before a program may be called infeasible
inline constexpr int further_starts = 2;     ///< per mode, where all of these led to no plan
inline constexpr int spread_starts = 5;      ///< per mode, to see whether a contact spreads
inline constexpr double most_of_time = 0.4;  ///< of what is left, for one solve: there are other ways if it gets stuck
inline constexpr double little_time = 0.7;   ///< of the time limit: with less left and no plan, the search hurries
inline constexpr double beats = 1e-12;       ///< an objective must be lower by this to win

/// A mode's best point so far and what is known about it.
struct Candidate {
  std::unique_ptr<PoseProgram> program;
  std::unique_ptr<Certifier> certifier;
  Eigen::VectorXd x;
  Certificate certificate;
  double objective = infinity;  ///< scaled
  OptimalityReport solver;      ///< of the solve that led here
  bool has_point = false;
  bool certified() const { return has_point && certificate.valid(); }
};

struct Tally {
  int solves = 0;
  int useless_solves = 0;           ///< that the solver refused, or broke down in
  EvaluationCounts evaluations;     ///< that solvers asked for
  EvaluationCounts outside_solver;  ///< that polish and restoration asked for
  int iterations = 0;
  double seconds = 0.0, seconds_evaluating = 0.0, seconds_certifying = 0.0;
};

class Planner {
 public:
  Planner(Problem::Data& data, const PlanControl& control)
      : d_(data), control_(control), modes_(data.modes), deadline_(now() + data.scene.solver.time_limit) {}

  Plan run();

 private:
  struct ModeState {
    int mode = 0;
    ModeRecord record;
    Candidate best;
    Candidate spread;  ///< a point that fails because its contact spreads
    int starts_used = 0;
    int stationary_violations = 0;  ///< starts that ended where no direction reduces the violation
    std::string trouble;            ///< how the last attempt failed
    OptimalityReport last;          ///< of the last solve
    StartShape nearest;             ///< where the violation of the rows was least, as long as there is no point
    double violation = infinity;    ///< there
    std::string limits;             ///< that bind there
    bool deferred = false;          ///< the last start was left to times without any plan
  };

  bool must_stop() const { return (control_.stop != nullptr && control_.stop->load()) || now() > deadline_; }
  /// So much time has gone without a plan that what is left has to be enough for all that was not tried.
  bool hurried() const { return !have_plan_ && deadline_ - now() < little_time * d_.scene.solver.time_limit; }
  SolveControl limits() const {
    SolveControl c;
    c.tolerance = d_.scene.solver.tolerance;
    c.max_iterations = d_.scene.solver.max_iterations;
    // Programs of a grasp differ little: a search that takes many times as long as others took ends nowhere.
    if (balanced_by_row() && have_plan_) c.max_iterations = std::min(c.max_iterations, patience * slowest_converged_);
    c.time_limit = std::max(1e-3, most_of_time * (deadline_ - now()));
    c.stop = control_.stop;
    return c;
  }

  StartShape start_shape(int index, const Mode& mode) const;
  /// Loads decide how the rod hangs.
  bool loaded() const;
  /// The rod without moments as its loads pull it: along them but for a bend next to the clamp.
  StartShape hanging(bool long_way) const;
  /// Where no plan was found: more starts, then every assignment of contacts if there are not too many.
  void search_further(int starts, const std::vector<std::size_t>& order);
  /// Every mode that could be had ended where its violation is stationary.
  bool all_infeasible() const;
  /// Where every search ended at an equilibrium that is not stable, or at none: what the rod would do under the moments
  /// found, or under the least ones.
  void settle();
  /// A start of a grasp. Without a force the row of the balance says nothing about where the contact should be.
  StartShape held(double tip_angle, const Mode& mode) const;
  /// Looks for plans from every start that there is for the modes in `order`.
  void search(const std::vector<std::size_t>& order);
  /// A grasp whose balance is left to an objective: the plan with the balance as a row is the first start. Without
  /// that row the objective has valleys where the object is pushed along the axis, and ordinary starts end in them.
  void start_from_balance(const std::vector<std::size_t>& order);
  bool balanced_by_row() const { return d_.palm && d_.palm->balance; }
  /// Whether the rows alone lead from the start of a grasp to a feasible point.
  bool promising(PoseProgramSpec spec, const std::vector<CheckPoint>& checks, const StartShape& shape);
  void try_start(ModeState& state, const StartShape& shape);
  void attempt(ModeState& state, const StartShape& shape, const std::vector<int>& regions);
  /// Remembers which term is not finite at x, for the report.
  void note_unfit_term(PoseProgram& program, const Eigen::VectorXd& x);
  /// From x (any quality) to a decided branch and a point on it. False: no feasible point was found.
  bool find_point(ModeState& state, PoseProgram& program, Eigen::VectorXd& x, Branch forced);
  bool treat(ModeState& state, PoseProgram& program, Eigen::VectorXd& x, Treatment treatment);
  /// The same for contacts with obstacles so small that a step of any solver passes over them: they are swollen to a
  /// size that can be found, and shrink back in steps that Newton follows. False: none is so small, or it was lost.
  bool swell(ModeState& state, const PoseProgramSpec& spec, const StartShape& shape, Branch forced,
             PoseProgram& program, Eigen::VectorXd& x);
  OptimalityReport solve(ModeState& state, NonlinearProgram& program, const Eigen::VectorXd& x,
                         const OptimalityReport* warm = nullptr);
  bool sharpen(ModeState& state, PoseProgram& program, Eigen::VectorXd& x, bool solver_allowed);
  /// From a point that violates rows to one that does not, if there is one near; counts those where there is none.
  bool restore(ModeState& state, PoseProgram& program, Eigen::VectorXd& x);
  /// A quick look where time is short: the violation has a stationary point near x, and no solver is asked.
  bool nothing_near(ModeState& state, PoseProgram& program, const Eigen::VectorXd& x);
  /// After a check point moved and neither polish nor solver followed: reduces the violation alone, then tries both
  /// again.
  bool recover(ModeState& state, PoseProgram& program, Eigen::VectorXd& x);
  /// Exchange loop and certificate; keeps the candidate if it is better than the mode's best.
  /// False: the exchange ended where the rod cannot leave an obstacle; `checks` then holds every point that was
  /// checked.
  bool complete(ModeState& state, const std::vector<int>& regions, std::vector<CheckPoint>& checks, Eigen::VectorXd x,
                const std::vector<Branch>& branches);
  /// Newton from the earlier plan's own point, touching what it touched: no solver is called. The mode that is
  /// certified so, or -1: there is none, or a contact may be about to come or go, which other modes know more about.
  int follow();
  /// Whether a plan from this start could still win; then it is looked for.
  void consider(ModeState& state, const StartShape& shape);
  /// Adds contacts to the best modes of each size.
  void grow();
  std::size_t state_of(const std::vector<ContactSetup>& contacts);
  std::vector<std::size_t> parents(int contacts) const;
  /// Rounds of search().
  int starts() const { return most_starts + (control_.start != nullptr ? 1 : 0) + (d_.palm ? 1 : 0); }
  static bool all_press(const ModeState& state) {
    const PoseProgram::Layout& at = state.best.program->layout();
    return at.forces == 0 || state.best.x.segment(at.first_force, at.forces).minCoeff() > tolerance::force;
  }
  double best_objective() const {
    return winner_ < 0 ? infinity : states_[static_cast<std::size_t>(winner_)].best.objective;
  }
  /// Whether the rod lies along an obstacle where a contact presses at x: no point contact is there.
  static bool lies_along(Candidate& c, const Eigen::VectorXd& x, int contact);
  /// Where no plan was found: whether contacts hold the rod where it may run into obstacles elsewhere, and spread
  /// there. Then it lies along an obstacle, which is why no point of contact keeps it outside.
  void look_for_spread();
  Plan report(std::vector<ModeState>& states, int winner);
  std::string nearest_failure(const std::vector<ModeState>& states) const;
  static std::string limits_at(const PoseProgram& program, ConstVectorRef x);

  Problem::Data& d_;
  const PlanControl& control_;
  std::vector<Mode> modes_;  ///< those of the problem, then what the search adds
  double deadline_;
  Tally tally_;
  std::vector<ModeState> states_;
  int winner_ = -1;
  bool have_plan_ = false;                    ///< some mode is certified
  int slowest_converged_ = least_iterations;  ///< most iterations of a solve that converged
  bool following_ = false;                    ///< only Newton may move points
  double balanced_objective_ = infinity;      ///< scaled, of start_from_balance()
  bool deferring_ = false;                    ///< starts of a grasp that do not look promising wait for the others
  std::string unfit_;                         ///< a term that gave no number, in words
  bool every_assignment_tried_ = false;       ///< although they are too many to begin with
};

inline void add_counts(EvaluationCounts& to, const EvaluationCounts& more) {
  to.values += more.values;
  to.first_derivatives += more.first_derivatives;
  to.hessians += more.hessians;
  to.seconds += more.seconds;
}

inline void add_difference(EvaluationCounts& to, const EvaluationCounts& after, const EvaluationCounts& before) {
  to.values += after.values - before.values;
  to.first_derivatives += after.first_derivatives - before.first_derivatives;
  to.hessians += after.hessians - before.hessians;
  to.seconds += after.seconds - before.seconds;
}

}  // namespace tendril
