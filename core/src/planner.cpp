#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <tuple>

#include "check_points.hpp"
#include "contact_search.hpp"
#include "earlier_plan.hpp"
#include "follower.hpp"
#include "grasp.hpp"
#include "load_path.hpp"
#include "plan_report.hpp"
#include "problem_data.hpp"
#include "tendril/certificate.hpp"
#include "tendril/complementarity.hpp"
#include "tendril/error.hpp"
#include "tendril/execute.hpp"
#include "tendril/feasibility.hpp"
#include "tendril/polish.hpp"
#include "tendril/self_overlap.hpp"
#include "tendril/tolerances.hpp"

namespace tendril {
namespace {

/// Numbers that steer the outer loops. They decide how a plan is found, never whether it is accepted.
constexpr double penalty_growth = 10.0;     ///< of beta, until the branch is decided (model.md section 4)
constexpr double penalty_cap = 1e4;         ///< largest beta
constexpr double relaxation_first = 1e-1;   ///< eps of Scholtes and Fischer-Burmeister ...
constexpr double relaxation_last = 1e-8;    ///< ... ends here ...
constexpr double relaxation_shrink = 1e-2;  ///< ... in these steps
constexpr double tiny_radius = 1e-3;  ///< (L) an obstacle below it is swollen before a contact with it is searched
constexpr double swollen_radii[] = {0.02, 0.1, 0.005};  ///< ... to the first of these that works
constexpr double slowest_shrinking = 0.95;              ///< per step on the way back, before it is given up
constexpr int most_exchanges = 25;
constexpr int most_retries = 3;  ///< of a start whose check points let the rod slip to the wrong side of an obstacle
constexpr int most_pieces_away = 3;   ///< of an unsplit rod, from where the start comes nearest to the obstacle
constexpr int least_iterations = 10;  ///< that a solve of a grasp is thought to take
constexpr int patience = 8;  ///< of a grasp with a plan: iterations of a solve, in those of the slowest that converged
constexpr int most_starts = 5;            ///< per mode, before a program may be called infeasible
constexpr int further_starts = 2;         ///< per mode, where all of these led to no plan
constexpr double most_of_time = 0.4;      ///< of what is left, for one solve: there are other ways if it gets stuck
constexpr double little_time = 0.7;       ///< of the time limit: with less left and no plan, the search hurries
constexpr int most_restorations = 200;    ///< steps
constexpr int most_settlings = 3;         ///< executions of unstable plans, for a stable shape to start from
constexpr double nearly_feasible = 1e-3;  ///< violation below which a solver's point is worth sharpening
constexpr double restored = 1e-8;         ///< violation below which a point counts as feasible
constexpr double bends = 1.0;             ///< a load (EI/L^2) above this decides how the rod hangs
constexpr double beats = 1e-12;           ///< an objective must be lower by this to win
constexpr double at_limit = 1e-9;         ///< a variable this near to its limit stands at it, in reports

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

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

void add_counts(EvaluationCounts& to, const EvaluationCounts& more) {
  to.values += more.values;
  to.first_derivatives += more.first_derivatives;
  to.hessians += more.hessians;
  to.seconds += more.seconds;
}

void add_difference(EvaluationCounts& to, const EvaluationCounts& after, const EvaluationCounts& before) {
  to.values += after.values - before.values;
  to.first_derivatives += after.first_derivatives - before.first_derivatives;
  to.hessians += after.hessians - before.hessians;
  to.seconds += after.seconds - before.seconds;
}

void keep_unique(std::vector<CheckPoint>& checks) {
  const auto key = [](const CheckPoint& c) { return std::tuple(c.obstacle, c.piece, c.sigma); };
  std::sort(checks.begin(), checks.end(), [&](const CheckPoint& a, const CheckPoint& b) { return key(a) < key(b); });
  checks.erase(std::unique(checks.begin(), checks.end(),
                           [&](const CheckPoint& a, const CheckPoint& b) { return key(a) == key(b); }),
               checks.end());
}

std::vector<Branch> branches_of(const PoseProgram& program) {
  std::vector<Branch> branches(static_cast<std::size_t>(program.layout().forces));
  for (std::size_t k = 0; k < branches.size(); ++k) branches[k] = program.branch(static_cast<int>(k));
  return branches;
}

void set_branches(PoseProgram& program, const std::vector<Branch>& branches) {
  for (int k = 0; k < program.layout().forces; ++k) program.set_branch(k, branches[static_cast<std::size_t>(k)]);
}

/// All that pulls at the rod.
Vec2 load_of(const Rod& rod) {
  double weight = rod.payload;
  for (const Rod::Segment& s : rod.segments) weight += s.weight * (s.to - s.from);
  return weight * rod.gravity + rod.tip_force;
}

StartShape Planner::start_shape(int index, const Mode& mode) const {
  // An earlier plan comes first, then the scene's own start, then shapes that bend to either side.
  if (control_.start != nullptr && !control_.start->backbone.empty()) {
    if (index == 0) return shape_of(d_, *control_.start, mode);
    --index;
  }
  if (d_.palm && mode.contacts.size() == 1) {
    if (index < grasp_starts) return grasp_start(d_, mode, index);
    index -= grasp_starts;
  }
  if (index == 0) return d_.palm ? held(d_.scene.start_tip_angle, mode) : d_.scene_start();
  if (loaded() && index > 0) {
    if (index <= 2) return hanging(index == 2);
    index -= 2;
  }
  const double own = d_.scene.start_tip_angle;
  const double spread = std::max(0.8, std::abs(own));
  const double angles[most_starts + further_starts] = {own,
                                                       -own - (own == 0.0 ? 0.4 : 0.0),
                                                       own + spread,
                                                       own - spread,
                                                       0.25 * own + 0.1,
                                                       own + 2.0 * spread,
                                                       own - 2.0 * spread};
  const double angle = angles[std::min(index, most_starts + further_starts - 1)];
  return d_.palm ? held(angle, mode) : constant_curvature(angle);
}

bool Planner::loaded() const { return !d_.palm && norm(load_of(d_.rod)) > bends; }

StartShape Planner::hanging(bool long_way) const {
  const Vec2 load = load_of(d_.rod);
  const Vec2 along{std::cos(d_.rod.base_angle), std::sin(d_.rod.base_angle)};
  double turn = std::atan2(cross(along, load), dot(along, load));
  if (long_way) turn -= std::copysign(2.0 * std::numbers::pi, turn);
  // Next to the clamp a rod under tension bends within 1/sqrt(tension).
  const double width = 1.0 / std::sqrt(std::max(norm(load), bends));
  const double peak = turn / (width * (1.0 - std::exp(-1.0 / width)));
  StartShape shape;
  shape.curvature = [peak, width](double s) { return peak * std::exp(-s / width); };
  shape.moments.assign(d_.rod.actuators.size(), 0.0);
  for (std::size_t a = 0; a < shape.moments.size(); ++a) {
    shape.moments[a] = std::clamp(0.0, d_.rod.actuators[a].minimum, d_.rod.actuators[a].maximum);
  }
  return shape;
}

StartShape Planner::held(double tip_angle, const Mode& mode) const {
  StartShape shape = constant_curvature(tip_angle);
  shape.forces.assign(mode.contacts.size(), std::isfinite(d_.max_force) ? d_.max_force : 1.0);
  return shape;
}

OptimalityReport Planner::solve(ModeState& state, NonlinearProgram& program, const Eigen::VectorXd& x,
                                const OptimalityReport* warm) {
  SolverStart start;
  start.x = x;
  if (warm != nullptr) {
    start.multipliers = warm->multipliers;
    start.bound_multipliers = warm->bound_multipliers;
  }
  OptimalityReport report = d_.components.solver->solve(program, start, limits());
  ++state.record.solves;
  state.record.iterations += report.iterations;
  state.record.evaluations += report.evaluations.values;
  state.record.seconds_evaluating += report.seconds_evaluating;
  state.last = report;
  if (report.status == SolveStatus::converged) slowest_converged_ = std::max(slowest_converged_, report.iterations);
  tally_.iterations += report.iterations;
  tally_.seconds += report.seconds;
  tally_.seconds_evaluating += report.seconds_evaluating;
  add_counts(tally_.evaluations, report.evaluations);
  return report;
}

bool Planner::swell(ModeState& state, const PoseProgramSpec& spec, const StartShape& shape, Branch forced,
                    PoseProgram& program, Eigen::VectorXd& x) {
  std::vector<std::unique_ptr<ShrunkObstacle>> swollen;
  std::vector<double> radii;
  PoseProgramSpec larger = spec;
  larger.checks.clear();
  for (const ContactSetup& c : spec.contacts) {
    const Obstacle*& obstacle = larger.obstacles[static_cast<std::size_t>(c.obstacle)];
    const double radius = obstacle->smallest_radius();
    if (!(radius < tiny_radius)) continue;
    swollen.push_back(std::make_unique<ShrunkObstacle>(*obstacle));
    radii.push_back(radius);
    obstacle = swollen.back().get();
  }
  if (swollen.empty() || must_stop() || following_) return false;
  const auto grow_to = [&](double radius) {
    for (std::size_t i = 0; i < swollen.size(); ++i) swollen[i]->shrink(-std::max(0.0, radius - radii[i]));
  };
  const double least = *std::min_element(radii.begin(), radii.end());
  grow_to(swollen_radii[0]);
  PoseProgram easier(larger);
  Eigen::VectorXd at;
  double swollen_radius = 0.0;
  for (const double radius : swollen_radii) {
    grow_to(radius);
    easier.invalidate();
    at = easier.start_from(shape);
    if (!find_point(state, easier, at, forced)) continue;
    swollen_radius = radius;
    break;
  }
  if (swollen_radius == 0.0) return false;
  double share = 0.5;
  for (double radius = swollen_radius; radius > least && !must_stop();) {
    const double next = std::max(least, share * radius);
    grow_to(next);
    easier.invalidate();
    ++state.record.polishes;
    const EvaluationCounts before = easier.counts();
    const PolishReport p = polish(easier, at, {});
    add_difference(tally_.outside_solver, easier.counts(), before);
    if (p.converged && p.infeasibility <= tolerance::equilibrium) {
      at = p.x;
      radius = next;
      continue;
    }
    share = std::sqrt(share);
    if (share > slowest_shrinking) return false;
  }
  set_branches(program, branches_of(easier));
  x = at;
  return true;
}

bool Planner::treat(ModeState& state, PoseProgram& program, Eigen::VectorXd& x, Treatment treatment) {
  std::vector<ComplementaryPair> pairs(static_cast<std::size_t>(program.layout().forces));
  for (int k = 0; k < program.layout().forces; ++k) {
    pairs[static_cast<std::size_t>(k)] = {program.layout().first_gap + k, program.force_variable(k)};
  }
  const bool relaxes = treatment == Treatment::scholtes || treatment == Treatment::fischer_burmeister;
  const double first = relaxes ? relaxation_first : d_.scene.contact.beta;
  ComplementarityProgram treated(program, pairs, treatment, first);
  Eigen::VectorXd full = treated.extend(x);
  OptimalityReport report;
  bool first_solve = true;
  for (double parameter = first;;) {
    treated.set_parameter(parameter);
    report = solve(state, treated, full, first_solve ? nullptr : &report);
    first_solve = false;
    if (!report.x.allFinite() || report.x.size() != full.size()) return false;
    full = report.x;
    if (must_stop() || report.status == SolveStatus::unsupported || report.status == SolveStatus::failed) break;
    // A larger beta moves no row, and a smaller eps only tightens them: what is infeasible now stays so.
    if (report.infeasibility > nearly_feasible) break;
    double undecided = 0.0;
    const VectorView c = program.constraints(full.head(program.variable_count()));
    for (const ComplementaryPair& p : pairs) undecided = std::max(undecided, std::min(c[p.row], full[p.variable]));
    if (relaxes) {
      if (parameter <= relaxation_last) break;
      parameter = std::max(relaxation_last, parameter * relaxation_shrink);
    } else {
      if (undecided <= tolerance::branch_decided || parameter >= penalty_cap) break;
      parameter = std::min(penalty_cap, parameter * penalty_growth);
    }
  }
  x = full.head(program.variable_count());
  const VectorView c = program.constraints(x);
  for (int k = 0; k < program.layout().forces; ++k) {
    const double gap = c[pairs[static_cast<std::size_t>(k)].row];
    const double force = x[pairs[static_cast<std::size_t>(k)].variable];
    program.set_branch(k, gap <= force ? Branch::touching : Branch::separated);
  }
  return report.infeasibility <= nearly_feasible;
}

bool Planner::sharpen(ModeState& state, PoseProgram& program, Eigen::VectorXd& x, bool solver_allowed) {
  const auto counted_polish = [&](const Eigen::VectorXd& from) {
    ++state.record.polishes;
    const EvaluationCounts before = program.counts();
    PolishOptions options;
    options.stop = [this] { return must_stop(); };
    PolishReport report = polish(program, from, {}, options);
    add_difference(tally_.outside_solver, program.counts(), before);
    return report;
  };
  PolishReport p = counted_polish(x);
  if (p.converged && p.infeasibility <= tolerance::equilibrium) {
    x = p.x;
    return true;
  }
  if (!solver_allowed || following_ || must_stop()) return false;
  // On a decided branch the program is an ordinary one.
  const OptimalityReport r = solve(state, program, x);
  if (!r.x.allFinite() || r.x.size() != x.size()) return false;
  p = counted_polish(r.x);
  if (p.converged && p.infeasibility <= tolerance::equilibrium) {
    x = p.x;
    return true;
  }
  // The solver's own point may already be good enough for the certificate.
  if (r.infeasibility <= 1e-8) x = r.x;
  state.trouble = "the polish did not converge (" + std::string(p.reason) +
                  "); solver: " + std::string(to_string(r.status)) + (r.message.empty() ? "" : ", " + r.message);
  return r.infeasibility <= 1e-8;
}

bool Planner::find_point(ModeState& state, PoseProgram& program, Eigen::VectorXd& x, Branch forced) {
  const int contacts = program.layout().forces;
  const Eigen::VectorXd start = x;
  if (contacts == 0 || forced == Branch::touching) {
    for (int k = 0; k < contacts; ++k) program.set_branch(k, Branch::touching);
    OptimalityReport r = solve(state, program, x);
    if (!r.x.allFinite() || r.x.size() != x.size()) return false;
    x = r.x;
    if (r.infeasibility <= nearly_feasible) return true;
  } else {
    if (treat(state, program, x, d_.scene.contact.treatment)) return true;
    // With a plan in hand the branch that touches is tried directly; the slower treatment is for when nothing else
    // works.
    if (d_.scene.contact.treatment != Treatment::scholtes && !have_plan_ && !must_stop()) {
      for (int k = 0; k < contacts; ++k) program.set_branch(k, Branch::open);
      state.record.outcome += "fallback to scholtes; ";
      if (treat(state, program, x, Treatment::scholtes)) return true;
    }
  }
  if (restore(state, program, x)) return true;
  // The solver may have left the side on which the start could have come free.
  x = start;
  return restore(state, program, x);
}

bool Planner::restore(ModeState& state, PoseProgram& program, Eigen::VectorXd& x) {
  if (must_stop() || following_ || !x.allFinite()) return false;
  const EvaluationCounts before = program.counts();
  const FeasibilityReport f =
      restore_feasibility(program, x, restored, most_restorations, [this] { return must_stop(); });
  add_difference(tally_.outside_solver, program.counts(), before);
  if (f.feasible) {
    const OptimalityReport r = solve(state, program, f.x);
    x = r.x.allFinite() && r.x.size() == x.size() && r.infeasibility <= nearly_feasible ? r.x : f.x;
    return true;
  }
  if (f.stationary_violation) ++state.stationary_violations;
  if (f.x.allFinite() && f.infeasibility < state.violation) {
    // Only the search over assignments goes on from there.
    if (!d_.enumerated) state.nearest = program.shape_of(f.x);
    state.violation = f.infeasibility;
    state.limits = limits_at(program, f.x);
  }
  char text[96];
  std::snprintf(text, sizeof text, "no feasible point near: violation %.2e%s", f.infeasibility,
                f.stationary_violation ? ", stationary" : "");
  state.trouble = text;
  return false;
}

bool Planner::nothing_near(ModeState& state, PoseProgram& program, const Eigen::VectorXd& x) {
  const EvaluationCounts before = program.counts();
  const FeasibilityReport f =
      restore_feasibility(program, x, restored, most_restorations, [this] { return must_stop(); });
  add_difference(tally_.outside_solver, program.counts(), before);
  if (!f.stationary_violation) return false;
  ++state.stationary_violations;
  return true;
}

bool Planner::recover(ModeState& state, PoseProgram& program, Eigen::VectorXd& x) {
  return restore(state, program, x) && sharpen(state, program, x, true);
}

bool Planner::complete(ModeState& state, const std::vector<int>& regions, std::vector<CheckPoint>& every_check,
                       Eigen::VectorXd x, const std::vector<Branch>& branches) {
  const Mode& mode = modes_[static_cast<std::size_t>(state.mode)];
  const bool exchanges = d_.scene.contact.check_points == 0 && !d_.obstacles.empty();
  int nodes = d_.nodes;
  std::vector<CheckPoint> checks = every_check;
  Candidate c;
  const auto build = [&] {
    PoseProgramSpec spec = d_.spec(mode, regions, nodes);
    spec.checks = checks;
    c.program = std::make_unique<PoseProgram>(spec);
    set_branches(*c.program, branches);
    c.certifier = std::make_unique<Certifier>(spec);
  };
  build();
  bool sharp = sharpen(state, *c.program, x, true);
  if (!sharp && following_) return false;
  // What is only nearly feasible is feasible, or a place where the violation is stationary: then there is no point.
  if (!sharp && x.allFinite() && infeasibility(*c.program, x) > restored) {
    sharp = recover(state, *c.program, x);
    if (!sharp && infeasibility(*c.program, x) > restored) return true;
  }
  for (int round = 0; exchanges && round < most_exchanges && !must_stop(); ++round) {
    if (!x.allFinite() || !exchange_checks(*c.program, x, *c.certifier, checks, violation_level)) break;
    every_check.insert(every_check.end(), checks.begin(), checks.end());
    build();
    sharp = sharpen(state, *c.program, x, true) || recover(state, *c.program, x);
    if (!sharp) {
      keep_unique(every_check);
      return false;
    }
  }
  for (int refinement = 0; refinement < 5; ++refinement) {
    const double begin = now();
    c.certificate = c.certifier->certify(*c.program, x);
    tally_.seconds_certifying += now() - begin;
    if (!(c.certificate.quadrature > tolerance::quadrature) || !sharp || must_stop() || nodes > 600) break;
    nodes = nodes + nodes / 2;
    build();
    sharp = sharpen(state, *c.program, x, false);
  }
  if (!x.allFinite()) return true;
  c.x = x;
  c.solver = state.last;
  c.objective = c.program->cost(x);
  if (!std::isfinite(c.objective)) {
    note_unfit_term(*c.program, x);
    return true;
  }
  c.has_point = true;
  const bool better = !state.best.has_point || (c.certified() && !state.best.certified()) ||
                      (c.certified() == state.best.certified() && c.objective < state.best.objective - beats);
  if (better) state.best = std::move(c);
  return true;
}

void Planner::note_unfit_term(PoseProgram& program, const Eigen::VectorXd& x) {
  program.cost(x);
  for (std::size_t i = 0; i < d_.terms.size(); ++i) {
    if (std::isfinite(program.term_value(static_cast<int>(i)))) continue;
    unfit_ = "objective '" + d_.terms[i].name + "' gives a number that is not finite";
  }
}

void Planner::attempt(ModeState& state, const StartShape& shape, const std::vector<int>& regions) {
  const Mode& mode = modes_[static_cast<std::size_t>(state.mode)];
  PoseProgramSpec spec = d_.spec(mode, regions, d_.nodes);
  std::vector<CheckPoint> checks = d_.first_checks(spec, shape);
  const bool required = d_.min_force > 0.0;
  // From a start without a feasible point near, a solver takes far the longest, and mostly in vain: the contact is on
  // a part of the finger that cannot hold the object. It is spent only where nothing else led to a plan.
  if (balanced_by_row() && (deferring_ || have_plan_) && !promising(spec, checks, shape)) {
    state.deferred = true;
    if (!state.best.has_point) state.trouble = "nothing feasible is near its starts, and there is a plan without it";
    return;
  }
  // From the same start, with every place checked where the rod went through an obstacle before.
  const auto search = [&](Branch branch) {
    bool touching = false;
    for (int retry = 0; retry <= most_retries && !must_stop(); ++retry) {
      spec.checks = checks;
      PoseProgram program(spec);
      Eigen::VectorXd x = program.start_from(shape);
      if (hurried() && state.starts_used > 1 && nothing_near(state, program, x)) break;
      if (!swell(state, spec, shape, branch, program, x) && !find_point(state, program, x, branch)) {
        if (state.last.status == SolveStatus::not_finite) note_unfit_term(program, x);
        break;
      }
      const std::vector<Branch> branches = branches_of(program);
      touching = std::all_of(branches.begin(), branches.end(), [](Branch b) { return b == Branch::touching; });
      if (complete(state, regions, checks, x, branches)) break;
      touching = false;
    }
    return touching;
  };
  const int stationary_before = state.stationary_violations;
  const bool touching = search(required ? Branch::touching : Branch::open);
  // A contact that the treatment let go, or could not decide: the branch that touches is a program of its own. It is
  // part of the one just searched, so where that has nothing feasible and a plan is at hand, it is not searched again.
  const bool hopeless = have_plan_ && !state.best.has_point && state.stationary_violations > stationary_before;
  const bool out_of_time = hurried() && state.starts_used > 1 && state.stationary_violations > stationary_before;
  const bool missing =
      !mode.contacts.empty() && !required && !hopeless && !out_of_time && (!touching || !state.best.certified());
  if (missing && !must_stop()) search(Branch::touching);
}

bool Planner::promising(PoseProgramSpec spec, const std::vector<CheckPoint>& checks, const StartShape& shape) {
  spec.checks = checks;
  PoseProgram program(spec);
  set_branches(program, std::vector<Branch>(spec.contacts.size(), Branch::touching));
  const bool feasible = restore_feasibility(program, program.start_from(shape), restored).feasible;
  add_difference(tally_.outside_solver, program.counts(), {});
  return feasible;
}

void Planner::try_start(ModeState& state, const StartShape& shape) {
  const Mode& mode = modes_[static_cast<std::size_t>(state.mode)];
  ++state.starts_used;
  std::vector<int> regions;
  for (const ContactSetup& c : mode.contacts) regions.push_back(c.region);
  if (d_.scene.coordinates.split_at_contact || mode.contacts.empty()) {
    attempt(state, shape, regions);
    return;
  }
  // Not split: the contact lies inside one piece. Begin with the one where the shape comes nearest, then follow the
  // contact into the neighbouring piece as long as it leans against a piece's end and that helps.
  PoseProgramSpec whole = d_.spec(mode, regions, d_.nodes);
  whole.split = true;  // with stretches for regions, only to place the contacts
  const PoseProgram placer(whole);
  const Eigen::VectorXd placed = placer.start_from(shape);
  const Chain chain(d_.rod, *d_.components.coordinates, {}, 1);
  std::vector<std::vector<int>> tried;
  std::vector<int> pieces(regions.size(), 0);
  for (std::size_t k = 0; k < regions.size(); ++k) {
    if (!mode.contacts[k].at_tip)
      pieces[k] = chain.piece_at(placed[placer.layout().first_arc_length + static_cast<int>(k)], {});
  }
  const auto same_stretch = [&](std::size_t k, int j) {
    return j >= 0 && j < chain.piece_count() && chain.piece(j).stretch == mode.contacts[k].region;
  };
  std::vector<std::vector<int>> outward;
  for (int distance = 1; distance <= most_pieces_away; ++distance) {
    for (const int side : {1, -1}) {
      for (std::size_t k = 0; k < pieces.size(); ++k) {
        std::vector<int> candidate = pieces;
        candidate[k] += side * distance;
        if (!mode.contacts[k].at_tip && same_stretch(k, candidate[k])) outward.push_back(candidate);
      }
    }
  }
  StartShape next_shape = shape;
  for (int hop = 0; hop < 2 * chain.piece_count() + 2 && !must_stop(); ++hop) {
    if (std::find(tried.begin(), tried.end(), pieces) != tried.end()) break;
    tried.push_back(pieces);
    attempt(state, next_shape, pieces);
    if (!state.best.has_point) {
      // No point with the contact in this piece: look into the others, nearest first.
      const auto next = std::find_if(outward.begin(), outward.end(), [&](const std::vector<int>& candidate) {
        return std::find(tried.begin(), tried.end(), candidate) == tried.end();
      });
      if (next == outward.end()) break;
      pieces = *next;
      continue;
    }
    const PoseProgram& program = *state.best.program;
    bool hopped = false;
    for (std::size_t k = 0; k < pieces.size() && !hopped; ++k) {
      if (mode.contacts[k].at_tip) continue;
      const int variable = program.layout().first_arc_length + static_cast<int>(k);
      const int piece = program.spec().contacts[k].region;
      const double s = state.best.x[variable];
      for (const auto& [active, neighbour] : {std::pair(s <= program.lower()[variable] + at_knot, piece - 1),
                                              std::pair(s >= program.upper()[variable] - at_knot, piece + 1)}) {
        if (!active || !same_stretch(k, neighbour)) continue;
        std::vector<int> candidate(pieces.size(), 0);
        for (std::size_t i = 0; i < pieces.size(); ++i)
          candidate[i] = mode.contacts[i].at_tip ? 0 : program.spec().contacts[i].region;
        candidate[k] = neighbour;
        if (std::find(tried.begin(), tried.end(), candidate) != tried.end()) continue;
        pieces = candidate;
        hopped = true;
        break;
      }
    }
    if (!hopped) break;
    next_shape = program.shape_of(state.best.x);
  }
}

void Planner::consider(ModeState& state, const StartShape& shape) {
  if (!modes_[static_cast<std::size_t>(state.mode)].skip.empty() || must_stop()) return;
  if (best_objective() <= d_.objective_bound + beats) {
    if (state.starts_used == 0) state.record.outcome = "skipped: no plan can cost less than the one found";
    return;
  }
  const int before = state.stationary_violations;
  const double begin = now();
  try_start(state, shape);
  // Where nothing presses, a plan of another mode nearly belongs to this one too: what costs more lies on another side
  // of an obstacle, and the better side is worth a start. The contacts of a grasp always press, but where its
  // balance is left to an objective, that has as many sides.
  if (!balanced_by_row() && winner_ >= 0 && winner_ != state.mode && state.best.certified() && !must_stop() &&
      state.best.objective > best_objective() + beats) {
    const Candidate& better = states_[static_cast<std::size_t>(winner_)].best;
    StartShape from = better.program->shape_of(better.x);
    from.arc_lengths.clear();
    from.forces.clear();
    try_start(state, from);
  }
  state.record.seconds += now() - begin;
  // One start is one piece of evidence, however many programs it led to.
  state.stationary_violations = std::min(state.stationary_violations, before + 1);
  // A grown mode whose new contact does not press is the smaller one with one more knot: no better a plan.
  const bool grown = static_cast<std::size_t>(state.mode) >= d_.modes.size();
  const bool repeats = grown && winner_ >= 0 && state.best.has_point && !all_press(state);
  if (state.best.certified() && !repeats && state.best.objective < best_objective() - beats) winner_ = state.mode;
  have_plan_ = winner_ >= 0;
}

std::size_t Planner::state_of(const std::vector<ContactSetup>& contacts) {
  const auto same = [](const ContactSetup& a, const ContactSetup& b) {
    return a.obstacle == b.obstacle && a.at_tip == b.at_tip && a.region == b.region;
  };
  for (std::size_t i = 0; i < modes_.size(); ++i) {
    const std::vector<ContactSetup>& own = modes_[i].contacts;
    if (std::equal(own.begin(), own.end(), contacts.begin(), contacts.end(), same)) return i;
  }
  modes_.push_back(d_.mode(contacts));
  ModeState state;
  state.mode = static_cast<int>(modes_.size()) - 1;
  state.record.mode = modes_.back().name;
  states_.push_back(std::move(state));
  return modes_.size() - 1;
}

std::vector<std::size_t> Planner::parents(int contacts) const {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < states_.size(); ++i) {
    const ModeState& state = states_[i];
    if (static_cast<int>(modes_[i].contacts.size()) != contacts) continue;
    if (!state.best.has_point && !std::isfinite(state.violation)) continue;
    // With a contact that does not press the mode is the smaller one without it, which was grown already.
    if (state.best.has_point && !all_press(state)) continue;
    found.push_back(i);
  }
  const auto rank = [&](std::size_t i) {
    const Candidate& best = states_[i].best;
    const double value = best.has_point ? best.objective : states_[i].violation;
    return std::tuple(best.certified() ? 0 : best.has_point ? 1 : 2, value);
  };
  std::stable_sort(found.begin(), found.end(), [&](std::size_t a, std::size_t b) { return rank(a) < rank(b); });
  if (found.size() > beam_width) found.resize(beam_width);
  return found;
}

void Planner::grow() {
  for (int size = 1; size < d_.scene.contact.count && !must_stop(); ++size) {
    for (const std::size_t parent : parents(size)) {
      const ModeState& from = states_[parent];
      const StartShape shape = from.best.has_point ? from.best.program->shape_of(from.best.x) : from.nearest;
      std::size_t added = 0;
      for (const Extension& extension : extensions(d_, modes_[parent].contacts, shape)) {
        if (added == most_extensions || must_stop()) break;
        if (!d_.mode(extension.contacts).skip.empty()) continue;
        ++added;
        const std::size_t known = states_.size();
        const std::size_t i = state_of(extension.contacts);
        // Another parent led here before; it is tried again only while there is no plan at all.
        if (i < known && (have_plan_ || states_[i].best.certified())) continue;
        consider(states_[i], extension.start);
      }
    }
  }
}

int Planner::follow() {
  const std::optional<FollowedPoint> from = followed_point(d_, *control_.start);
  if (!from) return -1;
  ModeState& state = states_[state_of(from->mode.contacts)];
  if (!modes_[static_cast<std::size_t>(state.mode)].skip.empty()) return -1;
  std::vector<CheckPoint> checks = from->checks;
  following_ = true;
  complete(state, from->regions, checks, from->x, std::vector<Branch>(from->mode.contacts.size(), Branch::touching));
  following_ = false;
  if (state.best.certified() && contacts_unchanged(d_, *state.best.program, state.best.x)) {
    state.record.outcome = followed_outcome;
    return state.mode;
  }
  state.best = {};
  return -1;
}

void Planner::settle() {
  if (d_.palm) return;  // a palm moves with the finger's loads; what a finger does with its palm held says nothing here
  const std::size_t modes = modes_.size();
  for (int attempt = 0; attempt < most_settlings && winner_ < 0 && !must_stop(); ++attempt) {
    const Candidate* unstable = nullptr;
    for (const ModeState& state : states_) {
      const bool usable = state.best.has_point && !(state.best.certificate.stability > tolerance::stability);
      if (usable && (unstable == nullptr || state.best.objective < unstable->objective)) unstable = &state.best;
    }
    const bool nothing =
        std::none_of(states_.begin(), states_.end(), [](const ModeState& s) { return s.best.has_point; });
    // Where no search came to any point at all, what the rod does under the least moments shows one.
    if (unstable == nullptr && !(nothing && attempt == 0)) return;
    std::vector<double> moments;
    for (std::size_t a = 0; a < d_.rod.actuators.size(); ++a) {
      if (unstable == nullptr) {
        const Rod::Actuator& actuator = d_.rod.actuators[a];
        moments.push_back(std::clamp(0.0, actuator.minimum, actuator.maximum) * d_.scale.moment());
        continue;
      }
      const int variable = unstable->program->moment_variable(static_cast<int>(a));
      moments.push_back(variable < 0 ? 0.0 : unstable->x[variable] * d_.scale.moment());
    }
    ExecuteControl control;
    control.stop = control_.stop;
    control.time_limit = std::max(1e-3, deadline_ - now());
    control.with_obstacles = !d_.obstacles.empty();
    Plan settled;
    try {
      settled = execute(d_.scene, d_.components.obstacles, moments, control).result;
    } catch (const SceneError&) {
      return;  // a start through the middle of an obstacle leads nowhere
    }
    if (settled.backbone.empty()) return;
    for (std::size_t i = 0; i < modes; ++i) consider(states_[i], shape_of(d_, settled, modes_[i]));
  }
}

Plan Planner::run() {
  states_.resize(modes_.size());
  for (std::size_t i = 0; i < states_.size(); ++i) {
    states_[i].mode = static_cast<int>(i);
    states_[i].record.mode = modes_[i].name;
  }
  std::vector<std::size_t> order;
  if (control_.start != nullptr) {
    // With an earlier plan the mode that won there comes first.
    const auto won = contacts_of(d_, *control_.start);
    if (won && (won->empty() ? d_.min_force == 0.0 : d_.contact_planned())) order.push_back(state_of(*won));
  }
  const std::size_t modes = modes_.size();
  for (std::size_t i = 0; i < modes; ++i) {
    if (order.empty() || order.front() != i) order.push_back(i);
  }
  const auto excluded = [&](std::size_t i) {
    const bool out =
        std::find(control_.without.begin(), control_.without.end(), modes_[i].name) != control_.without.end();
    if (out) states_[i].record.outcome = "not tried: left out on request";
    return out;
  };
  order.erase(std::remove_if(order.begin(), order.end(), excluded), order.end());
  if (control_.follow && control_.start != nullptr) winner_ = follow();
  if (winner_ >= 0) return report(states_, winner_);
  if (d_.palm && !d_.palm->balance) start_from_balance(order);
  search(order);
  search_further(starts(), order);
  settle();
  return report(states_, winner_);
}

void Planner::search(const std::vector<std::size_t>& order) {
  const int earlier = control_.start != nullptr ? 1 : 0;
  for (int round = 0; round < starts() && !must_stop(); ++round) {
    // One start per mode finds most plans; only if no mode is certified are more starts spent. A grasp comes in
    // families with several valleys of the effort; what follows its own starts is no equilibrium.
    if (winner_ >= 0 && (balanced_by_row() ? round >= earlier + grasp_starts : round > 0 && !d_.palm)) break;
    deferring_ = balanced_by_row();
    for (const std::size_t i : order) {
      states_[i].deferred = false;
      consider(states_[i], start_shape(round, modes_[i]));
    }
    deferring_ = false;
    for (const std::size_t i : order) {
      if (states_[i].deferred && winner_ < 0) consider(states_[i], start_shape(round, modes_[i]));
    }
    if (!d_.enumerated) grow();
  }
}

void Planner::start_from_balance(const std::vector<std::size_t>& order) {
  {
    struct WithBalance {
      PalmSetup& palm;
      explicit WithBalance(PalmSetup& of) : palm(of) { palm.balance = true; }
      ~WithBalance() { palm.balance = false; }
      WithBalance(const WithBalance&) = delete;
      WithBalance& operator=(const WithBalance&) = delete;
    } with(*d_.palm);
    search(order);
  }
  if (winner_ < 0) return;
  const Candidate& balanced = states_[static_cast<std::size_t>(winner_)].best;
  const StartShape shape = balanced.program->shape_of(balanced.x);
  const int mode = winner_;
  balanced_objective_ = balanced.objective;
  // What was found with the row is a start for what follows and nothing else.
  for (ModeState& state : states_) {
    state.best = {};
    state.starts_used = state.stationary_violations = 0;
    state.violation = infinity;
    state.trouble.clear();
    state.limits.clear();
  }
  winner_ = -1;
  have_plan_ = false;
  consider(states_[static_cast<std::size_t>(mode)], shape);
}

bool Planner::all_infeasible() const {
  return std::all_of(states_.begin(), states_.end(), [&](const ModeState& state) {
    return !modes_[static_cast<std::size_t>(state.mode)].skip.empty() ||
           (!state.best.has_point && state.stationary_violations >= most_starts);
  });
}

void Planner::search_further(int starts, const std::vector<std::size_t>& order) {
  if (d_.palm) return;
  for (int round = starts; round < starts + further_starts && winner_ < 0 && !all_infeasible(); ++round) {
    for (const std::size_t i : order) consider(states_[i], start_shape(round, modes_[i]));
    if (!d_.enumerated) grow();
  }
  if (d_.enumerated || winner_ >= 0) return;
  const std::vector<ContactSetup> slots =
      contact_slots(static_cast<int>(d_.rod.fixed_knots().size()) - 1, d_.contact_obstacles);
  const auto every = every_assignment(slots, d_.scene.contact.count, most_enumerated_at_last);
  if (!every) return;
  for (int round = 0; round < most_starts && winner_ < 0 && !must_stop(); ++round) {
    for (const std::vector<ContactSetup>& contacts : *every) {
      ModeState& state = states_[state_of(contacts)];
      if (state.starts_used <= round) consider(state, start_shape(round, modes_[static_cast<std::size_t>(state.mode)]));
    }
  }
  every_assignment_tried_ = !must_stop();
}

/// Where the violation was least, and which limits stood in the way.
std::string Planner::nearest_failure(const std::vector<ModeState>& states) const {
  const auto least = std::min_element(states.begin(), states.end(),
                                      [](const ModeState& a, const ModeState& b) { return a.violation < b.violation; });
  if (least == states.end() || !std::isfinite(least->violation)) return "";
  char text[48];
  std::snprintf(text, sizeof text, "%.2e", least->violation);
  return "; the nearest (" + least->record.mode + ") violates them by " + text +
         (least->limits.empty() ? ", with no variable at a limit" : ", with " + least->limits);
}

/// The variables that are at a limit at x.
std::string Planner::limits_at(const PoseProgram& program, ConstVectorRef x) {
  std::string text;
  for (int i = 0; i < program.variable_count(); ++i) {
    if (program.lower()[i] == program.upper()[i]) continue;
    const bool low = x[i] <= program.lower()[i] + at_limit;
    if (!low && x[i] < program.upper()[i] - at_limit) continue;
    text += (text.empty() ? "" : ", ") + program.variable_name(i) + (low ? " at its smallest" : " at its largest");
  }
  return text;
}

Plan Planner::report(std::vector<ModeState>& states, int winner) {
  Plan plan;
  plan.coordinates_name = d_.scene.coordinates.plugin;
  plan.order = d_.components.coordinates->function_count();
  plan.split_at_contact = d_.scene.coordinates.split_at_contact;
  plan.left_out = d_.left_out;
  plan.solver_name = d_.scene.solver.plugin;
  if (winner >= 0 && balanced_objective_ < best_objective() - beats) {
    char text[160];
    std::snprintf(
        text, sizeof text,
        "it costs less (%.6g), but is no minimum of this objective, which falls from there to where no plan is "
        "certified",
        balanced_objective_ * d_.objective_scale);
    plan.left_out.push_back({"the grasp with the balance as a row", text});
  }
  const bool followed = winner >= 0 && states[static_cast<std::size_t>(winner)].starts_used == 0;
  for (ModeState& state : states) {
    const Mode& mode = modes_[static_cast<std::size_t>(state.mode)];
    if (!mode.skip.empty()) {
      state.record.outcome = "skipped: " + mode.skip;
    } else if (state.best.has_point) {
      state.record.certified = state.best.certified();
      state.record.objective = state.best.objective * d_.objective_scale;
      char text[80];
      std::snprintf(text, sizeof text, "%s, objective %.6g", state.best.certified() ? "certified" : "not certified",
                    state.best.objective * d_.objective_scale);
      state.record.outcome += text;
      if (!state.best.certified()) {
        state.record.outcome += ": " + state.best.certificate.failures.front();
        if (!state.trouble.empty()) state.record.outcome += "; " + state.trouble;
      }
    } else if (state.starts_used > 0) {
      state.record.outcome +=
          "not solved: " + (state.trouble.empty() ? std::string(to_string(state.last.status)) : state.trouble);
    } else if (state.record.outcome.empty()) {
      state.record.outcome = followed ? not_tried_outcome : "not tried: stopped before";
    }
    plan.modes.push_back(state.record);
  }

  // Without a certified plan the nearest one is shown, for what it is worth.
  int shown = winner;
  if (shown < 0) {
    std::size_t fewest = std::numeric_limits<std::size_t>::max();
    for (const ModeState& state : states) {
      if (!state.best.has_point) continue;
      const std::size_t failures = state.best.certificate.failures.size();
      const bool better =
          failures < fewest || (failures == fewest && shown >= 0 &&
                                state.best.objective < states[static_cast<std::size_t>(shown)].best.objective);
      if (!better) continue;
      fewest = failures;
      shown = state.mode;
    }
  }

  plan.solver = (shown >= 0 ? states[static_cast<std::size_t>(shown)].best.solver : states.back().last);
  plan.solver.iterations = tally_.iterations;
  plan.solver.evaluations = tally_.evaluations;
  plan.evaluations = tally_.evaluations;
  add_counts(plan.evaluations, tally_.outside_solver);
  plan.solver.seconds = tally_.seconds;
  plan.solver.seconds_evaluating = tally_.seconds_evaluating;

  // The verdict.
  const bool stopped = control_.stop != nullptr && control_.stop->load();
  if (winner >= 0) {
    plan.status = PlanStatus::solved;
  } else if (stopped) {
    plan.status = PlanStatus::interrupted;
    plan.message = "interrupted before a plan was certified";
  } else if (now() > deadline_) {
    plan.status = PlanStatus::time_limit;
    plan.message = "the time limit of " + std::to_string(d_.scene.solver.time_limit) +
                   " s was reached before a plan was certified";
  } else {
    const bool by_bound = std::all_of(states.begin(), states.end(), [&](const ModeState& state) {
      return !modes_[static_cast<std::size_t>(state.mode)].skip.empty();
    });
    // A search that is no enumeration proves nothing; but a contact out of reach stays out of reach beside others.
    if (all_infeasible() && (d_.enumerated || every_assignment_tried_ || by_bound)) {
      plan.status = PlanStatus::infeasible;
      plan.message = by_bound
                         ? "infeasible by a bound: " + (d_.palm ? modes_.back() : modes_.front()).skip
                         : "infeasible: from " + std::to_string(most_starts) +
                               " starts per mode every search ended where no change of the plan reduces the violation "
                               "of its constraints" +
                               nearest_failure(states);
    } else if (shown >= 0) {
      const Certificate& c = states[static_cast<std::size_t>(shown)].best.certificate;
      const bool only_unstable =
          c.failures.size() == 1 && c.contact_convexity > tolerance::convexity && !(c.stability > tolerance::stability);
      plan.status = only_unstable ? PlanStatus::unstable : PlanStatus::not_converged;
      plan.message = c.failures.empty() ? "no plan" : c.failures.front();
    } else {
      const SolveStatus last = plan.solver.status;
      const bool diverged = last == SolveStatus::diverged;
      const bool refused =
          last == SolveStatus::unsupported || last == SolveStatus::failed || last == SolveStatus::not_finite;
      plan.status = diverged ? PlanStatus::diverged : refused ? PlanStatus::failed : PlanStatus::not_converged;
      plan.message = !unfit_.empty()                ? unfit_
                     : !plan.solver.message.empty() ? plan.solver.message
                                                    : "no mode led to a plan";
      if (!refused) {
        for (const ModeState& state : states) {
          if (!state.trouble.empty()) plan.message = state.record.mode + ": " + state.trouble;
        }
        if (!d_.enumerated && !every_assignment_tried_) {
          plan.message = "no plan in the " + std::to_string(states.size()) +
                         " assignments of contacts that were tried; others may have one; the last: " + plan.message;
        }
      }
    }
  }
  if (shown < 0) return plan;

  ModeState& chosen = states[static_cast<std::size_t>(shown)];
  PoseProgram& program = *chosen.best.program;
  const Eigen::VectorXd& x = chosen.best.x;
  program.cost(x);
  plan.certificate = chosen.best.certificate;
  plan.objective = chosen.best.objective * d_.objective_scale;
  for (std::size_t i = 0; i < d_.terms.size(); ++i) {
    plan.terms.emplace_back(d_.terms[i].name, program.term_value(static_cast<int>(i)) * d_.objective_scale);
  }
  const double length = d_.scale.length;
  plan.coordinates.assign(x.data(), x.data() + program.layout().coordinates);
  for (std::size_t a = 0; a < d_.rod.actuators.size(); ++a) {
    const int variable = program.moment_variable(static_cast<int>(a));
    plan.moments.push_back(variable < 0 ? 0.0 : x[variable] * d_.scale.moment());
  }
  const Vec2 tip = program.backbone().tip();
  plan.tip_x = tip.x * length;
  plan.tip_y = tip.y * length;
  plan.tip_angle = program.backbone().tip_angle();
  if (d_.target.has_position) plan.target_error = norm(tip - d_.target.position) * length;
  plan.contacts = planned_contacts(program, d_.obstacle_names, d_.scale);
  plan.backbone = sampled_backbone(chosen.best.certifier->finer(x), length);
  plan.self_overlap = self_overlap(plan.backbone);
  if (d_.palm) finish_grasp(d_, program, x, plan);
  plan.seconds_certify = tally_.seconds_certifying;
  return plan;
}

}  // namespace

bool Problem::follow_without_solver(Plan& plan) {
  Data& d = *data_;
  if (!d.follower || !d.follower->stands_at(plan)) d.follower = Follower::from(d, plan);
  if (d.follower && d.follower->step(plan)) return true;
  d.follower.reset();
  return false;
}

void Problem::follow(const TargetSpec& target, Plan& plan, const std::atomic<bool>* stop) {
  set_target(target);
  if (follow_without_solver(plan)) return;
  PlanControl control;
  control.stop = stop;
  control.start = &plan;
  Plan next = this->plan(control);
  plan = std::move(next);
}

Plan Problem::plan(const PlanControl& control) {
  const double begin = now();
  if (control.follow && control.start != nullptr && control.start->status == PlanStatus::solved) {
    Plan followed = *control.start;
    if (follow_without_solver(followed)) return followed;
  }
  Planner planner(*data_, control);
  Plan plan = planner.run();
  plan.seconds_assemble = data_->seconds_assemble;
  plan.seconds_solve = now() - begin - plan.seconds_certify;
  if (!data_->palm) plan.start_backbone = outline(data_->scene_start(), data_->rod, data_->scale.length);
  return plan;
}

}  // namespace tendril
