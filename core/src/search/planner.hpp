#pragma once

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "certificate/certifier.hpp"
#include "nlp/feasibility.hpp"
#include "obstacle/shrunk.hpp"
#include "search/beginning.hpp"
#include "search/completion.hpp"
#include "search/parameters.hpp"
#include "search/rest.hpp"
#include "search/steps.hpp"
#include "search/task.hpp"
#include "search/verdict.hpp"
#include "tendril/tolerances.hpp"

namespace tendril {

struct Descent;

/// A point of a pose program, judged.
using Candidate = PointOf<PoseProgram, Certifier>;

/// While it lives, programs have rows that keep equilibria stable and contacts points.
class HeldStable {
 public:
  explicit HeldStable(Task& data)
      : data_(data), margin_before_(data.least_margin), convexity_before_(data.least_convexity) {
    data_.least_margin = tolerance::held_margin;
    data_.least_convexity = tolerance::held_convexity;
  }
  ~HeldStable() {
    data_.least_margin = margin_before_;
    data_.least_convexity = convexity_before_;
  }
  HeldStable(const HeldStable&) = delete;
  HeldStable& operator=(const HeldStable&) = delete;

 private:
  Task& data_;
  std::optional<double> margin_before_, convexity_before_;
};

/// All branches of a program, and how to set them.
inline std::vector<Branch> branches_of(const PoseProgram& program) {
  std::vector<Branch> branches(static_cast<std::size_t>(program.layout().forces));
  for (std::size_t k = 0; k < branches.size(); ++k) branches[k] = program.branch(static_cast<int>(k));
  return branches;
}
inline void set_branches(PoseProgram& program, const std::vector<Branch>& branches) {
  for (int k = 0; k < program.layout().forces; ++k) program.set_branch(k, branches[static_cast<std::size_t>(k)]);
}
inline void close_contacts(PoseProgram& program) {
  for (int k = 0; k < program.layout().forces; ++k) program.set_branch(k, Branch::touching);
}

class Planner {
 public:
  Planner(Task& data, const PlanControl& control)
      : d_(data), control_(control), modes_(data.modes), steps_(*data.components.solver, data.scene.solver, control) {}

  Plan run();

 private:
  struct ModeState : Way {
    int mode = 0;
    Candidate best;
    Candidate spread;     ///< a point that fails because its contact spreads
    StartShape nearest;   ///< where the violation of the rows was least, as long as there is no point
    StartShape unstable;  ///< of the cheapest point that is unstable, or whose contact spreads
    double unstable_objective = infinity;
    bool sided = false;  ///< it was started from every side
    Sides sides;         ///< of the point that finish() completed last; empty: it did not
    /// Where the last point fails: beside a contact the rod runs into the same body, and touches it there here.
    std::optional<StartShape> over_seam;
    const Judged& judged() const override { return best; }
  };

  bool must_stop() const { return steps_.must_stop(); }
  bool fast() const { return d_.scene.effort == SearchEffort::fast; }
  bool thorough() const { return d_.scene.effort == SearchEffort::thorough; }
  /// Limits of what is tried are so many times as high.
  int generosity() const { return thorough() ? search_parameters().thorough : 1; }
  /// So much went without a plan that what follows has to be enough for all that was not tried.
  bool hurried() const {
    const bool looked = rested_ && round_ > 0;  // every mode had its start, and the rod was asked
    return search_parameters().hurry && !have_plan_ && (looked || steps_.tally.work > search_parameters().much_work);
  }

  /// Whether there is a moment to choose.
  bool chooses() const;
  StartShape start_shape(int index, const Mode& mode) const;
  /// Loads decide how the rod hangs.
  bool loaded() const;
  double load_size() const;  ///< of all that pulls at the rod, EI/L^2
  /// The rod without moments as its loads pull it: along them but for a bend next to the clamp.
  StartShape hanging(bool long_way) const;
  /// Where one or two moments can be chosen: all equilibria over the box of their limits are looked for, and those that
  /// cost less than the plan are starts.
  void scan();
  /// Where the plan is off its target: where arcs come to rest are starts.
  void start_from_relaxed_arcs();
  const Backbone& backbone_of_best() const;  ///< of the best plan, of which there is one
  bool is_off_target() const;                ///< so far that arcs are let go, or by what that costs
  std::vector<Rest> rests_of_arcs();         ///< where arcs of every turn come to rest under sampled moments
  std::vector<StartShape> scanned_shapes() const;
  Rest rest_at(const ModeState& state) const;  ///< of a plan
  /// What the plan costs that a rest is, as far as the coordinates can show it; infinity: a plan may not be so.
  double cost_of(const Rest& rest) const;
  /// Where no plan was found: more starts, then every assignment of contacts if there are not too many.
  void search_further(int starts, const std::vector<std::size_t>& order);
  /// Every mode that could be had ended where its violation is stationary.
  bool all_infeasible() const;
  /// Where equilibria were found, but no stable one: looks for one from every start, until the violation of the rows,
  /// with stability and point contact among them, is known to be stationary from enough of them.
  void look_for_stable(const std::vector<std::size_t>& order);
  /// Where every search ended at an equilibrium that is not stable, or at none: what the rod would do under the moments
  /// found, or under the least ones, shows stable shapes to start from. If that is not enough, programs that keep a
  /// margin of stability are solved from there.
  void settle(const std::vector<std::size_t>& order);
  /// The best point that fails because it is unstable, or null.
  const Candidate* best_unstable() const;
  /// The plan's moments of a point, or the least ones that the limits allow; EI/L.
  std::vector<double> moments_of(const Candidate* point) const;
  /// Moments over the range of the limits, EI/L: the least ones, then single actuators at and towards their limits,
  /// then two of them.
  std::vector<std::vector<double>> sampled_moments() const;
  /// What the rod does under these moments (EI/L), in the executor's own coordinates. Nothing: it cannot be told in so
  /// many looks.
  std::optional<Rest> executed(const std::vector<double>& moments, int looks);
  /// Downhill from a shape in the coordinates of the plan, which are few, or the same as executed() where they are
  /// many: these bend as the executor's do.
  std::optional<Rest> come_to_rest(const std::vector<double>& moments, const StartShape& from);
  /// Of the floor of a valley. Nothing where the rod is held between obstacles that leave no room.
  std::optional<Rest> settled(const Descent& down, const std::vector<double>& moments) const;
  /// The contacts that press, in order along the rod; nothing where a plan may not have so many, or none.
  std::optional<std::vector<ContactSetup>> contacts_of_rest(const Rest& rest) const;
  /// A plan from a rest, touching what it touches: the moments are chosen along stable equilibria.
  /// Returns what the feasible point costs that lies near, if there is one.
  double consider_rest(const Rest& rest);
  /// Along the equilibria that x belongs to, to the best moments near: the solver sees these alone.
  void solve_reduced(ModeState& state, PoseProgram& program, Eigen::VectorXd& x);
  /// Whether the programs of a mode are so large that they are solved along equilibria alone.
  bool solved_reduced(const Mode& mode) const;
  /// From x, with every contact closed, to an equilibrium near that the rows allow, and along equilibria from there.
  /// False: there is none near.
  bool come_to_point(ModeState& state, PoseProgram& program, Eigen::VectorXd& x);
  /// Whether so much was tried without a plan that the rod itself is asked for one; once.
  bool rest_is_due(const Mode& mode);
  /// Plans from where the rod rests under sampled moments.
  void start_from_rests();
  /// Whether the plan misses a target among bodies that are not convex: from another side of one it may be reached, and
  /// which side of it is touched is no way of its own.
  bool misses_among_sides() const;
  /// The objective may fall along stable equilibria up to their end: the plan is then held at the limit of stability.
  void hold_stable(const std::vector<Rest>& rests, const std::vector<std::size_t>& order);
  /// A start of a grasp. Without a force the row of the balance says nothing about where the contact should be.
  StartShape held(double tip_angle, const Mode& mode) const;
  /// Looks for plans from every start that there is for the modes in `order`.
  void search(const std::vector<std::size_t>& order);
  /// From shapes on further sides of obstacles than those that the first starts led to.
  /// Starts on sides for ways with one contact or none, then for those with more.
  void search_all_sides(const std::vector<std::size_t>& order);
  void search_sides(const std::vector<std::size_t>& order);
  /// Where the plan is off its target: from shapes that contacts bend in two.
  void search_bent(const std::vector<std::size_t>& order);
  /// Where there is a plan: starts on sides have shown already what an ordinary one can lead to.
  bool looked_at(const ModeState& state) const;
  /// From a shape to a feasible point near, where every contact touches, and from there to the best one near: with
  /// all variables, else along equilibria with the moments alone. `rests`: the rod rests in this shape, as far as the
  /// coordinates can show it.
  /// Returns what the feasible point costs; infinity: there is none.
  double refine(ModeState& state, const StartShape& shape, bool rests = false);
  double refine(ModeState& state, Beginning& from);
  /// The point with its contact where the rod is deepest in the same body, beside the contact, where no check point can
  /// be: on another piece of a body that is not convex. Nothing: it is not.
  std::optional<StartShape> over_seam(const Candidate& c) const;
  /// Of a program without rows that hold a plan back and without check points.
  PoseProgramSpec spec_without_margins(const Mode& mode, const std::vector<int>& regions) const;
  Beginning begin(const Mode& mode, const StartShape& shape, bool rests);
  /// The same of a shape that is known by its number, kept for the next target.
  std::shared_ptr<Beginning> beginning_at(const Mode& mode, const SideStart& start);
  /// By Newton's method from a beginning to a minimum near; false: the backend has to find one.
  bool descend(ModeState& state, PoseProgram& program, Eigen::VectorXd& x);
  /// The regions of contacts where the shape has them, or comes nearest to their obstacles.
  std::vector<int> regions_near(const Mode& mode, const StartShape& shape) const;
  /// `start`: the program's, from the shape.
  FeasibilityReport feasible_near(PoseProgram& program, const StartShape& shape, const Eigen::VectorXd& start,
                                  bool rests);
  /// complete(), unless x costs more than the plan. False: x led to nothing. `known`: the program is its own.
  bool finish(ModeState& state, PoseProgram& program, const std::vector<int>& regions, std::vector<CheckPoint>& checks,
              const Eigen::VectorXd& x, Beginning* known = nullptr);
  /// Points that cost less than the plan and fail because they are unstable, or their contact spreads: held at that
  /// limit they may still be better.
  void hold_cheaper();
  /// A grasp whose balance is left to an objective: the plan with the balance as a row is the first start. Without
  /// that row the objective has valleys where the object is pushed along the axis, and ordinary starts end in them.
  void start_from_balance(const std::vector<std::size_t>& order);
  bool balanced_by_row() const { return d_.palm && d_.palm->balance; }
  /// Whether the rows alone lead from the start of a grasp to a feasible point.
  bool promising(PoseProgramSpec spec, const std::vector<CheckPoint>& checks, const Eigen::VectorXd& start);
  void try_start(ModeState& state, const StartShape& shape);
  void attempt(ModeState& state, const StartShape& shape, const std::vector<int>& regions);
  /// Remembers which term is not finite at x, for the report.
  void record_unfit_term(PoseProgram& program, const Eigen::VectorXd& x);
  /// From x (any quality) to a decided branch and a point on it. False: no feasible point was found.
  bool find_point(ModeState& state, PoseProgram& program, Eigen::VectorXd& x, Branch forced);
  bool solve_treatment(ModeState& state, PoseProgram& program, Eigen::VectorXd& x, Treatment treatment);
  /// The same for contacts with obstacles so small that a step of any solver passes over
  /// them: they are grown to a size that can be found, and shrink back in steps that Newton follows. False: none is
  /// so small, or it was lost.
  bool radius_homotopy(ModeState& state, const PoseProgramSpec& spec, const StartShape& shape, Branch forced,
                       PoseProgram& program, Eigen::VectorXd& x);
  OptimalityReport solve(ModeState& state, NonlinearProgram& program, const Eigen::VectorXd& x,
                         const OptimalityReport* warm = nullptr);
  bool sharpen(ModeState& state, PoseProgram& program, Eigen::VectorXd& x, bool solver_allowed);
  /// From a point that violates rows to one that does not, if there is one near; counts those where there is none.
  bool restore(ModeState& state, PoseProgram& program, Eigen::VectorXd& x);
  /// A quick look where time is short: the violation has a stationary point near x, and no solver is asked.
  bool nothing_near(ModeState& state, PoseProgram& program, const Eigen::VectorXd& x);
  /// Keeps the shape where the violation is least, if it was larger than this before.
  void keep_nearest(ModeState& state, const PoseProgram& program, const FeasibilityReport& f, double least);
  /// After a check point moved and neither polish nor solver followed: reduces the violation alone, then tries both
  /// again.
  bool recover(ModeState& state, PoseProgram& program, Eigen::VectorXd& x);
  /// Exchange loop and certificate; keeps the candidate if it is better than the mode's best.
  /// False: the exchange ended where the rod cannot leave an obstacle; `checks` then holds every point that was
  /// checked.
  /// `known`: x is where Newton's method converged in its program.
  bool complete(ModeState& state, const std::vector<int>& regions, std::vector<CheckPoint>& checks, Eigen::VectorXd x,
                const std::vector<Branch>& branches, Beginning* known = nullptr);
  struct Completing;
  /// The same without keeping it: into `c`.
  Completion bring_to_certificate(ModeState& state, const std::vector<int>& regions, std::vector<CheckPoint>& checks,
                                  Eigen::VectorXd x, const std::vector<Branch>& branches, Candidate& c,
                                  Beginning* known = nullptr);
  /// Newton from the earlier plan's own point, touching what it touched: no solver is called. The mode that is
  /// certified so, or -1: there is none, or a contact may be about to come or go, which other modes know more about.
  int follow();
  /// Whether a plan from this start could still win; then it is looked for.
  void consider(ModeState& state, const StartShape& shape);
  void consider(ModeState& state, const std::function<void()>& trial);
  /// Whether no plan of a mode can cost less than the one found; says so in its record.
  bool cannot_win(ModeState& state);
  /// As Task::least_distance(), counted; 0 where ways are not bounded.
  double least_distance(std::size_t mode, const std::function<bool(double)>& enough);
  /// Adds contacts to the best modes of each size.
  void grow();
  std::size_t state_of(const std::vector<ContactSetup>& contacts);
  void name_state(std::size_t i);
  std::vector<std::size_t> parents(int contacts) const;
  /// Remembers a certified plan, if none like it is known.
  void keep_minimum(ModeState& state, const Candidate& c);
  /// Rounds of search().
  int starts() const {
    if (fast()) return 1 + (control_.start != nullptr ? 1 : 0);
    return search_parameters().most_starts + (control_.start != nullptr ? 1 : 0) + (d_.palm ? 1 : 0);
  }
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
  Plan report();
  /// What a reader should know first: where the start runs, and how far the plan is from what was asked for.
  void add_notes(Plan& plan) const;

  Task& d_;
  const PlanControl& control_;
  std::vector<Mode> modes_;  ///< those of the problem, then what the search adds
  ProgramSearch steps_;
  std::deque<ModeState> states_;  ///< one per mode; stay where they are as modes are added
  std::vector<PlanMinimum> minima_;
  std::optional<PlanScan> scan_;
  int winner_ = -1;
  bool certified_ = false;                ///< the point that complete() judged last
  bool have_plan_ = false;                ///< some mode is certified
  bool following_ = false;                ///< only Newton may move points
  double balanced_objective_ = infinity;  ///< scaled, of start_from_balance()
  bool bent_ = false;                     ///< starts on sides are shapes that contacts bend in two
  bool deferring_ = false;                ///< starts of a grasp that do not look promising wait for the others
  bool proving_ = false;                  ///< a look at the violation comes before every search
  bool rested_ = false;                   ///< start_from_rests() was done
  int round_ = 0;                         ///< of search(): each has one start per mode
  int values_tried_ = 0;                  ///< coordinates of all programs that led to no plan
  std::string unfit_;                     ///< a term that gave no number, in words
  bool every_assignment_tried_ = false;   ///< although they are too many to begin with
};

}  // namespace tendril
