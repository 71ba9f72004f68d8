#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <tuple>

#include "contact_search.hpp"
#include "grasp.hpp"
#include "plan_report.hpp"
#include "problem_data.hpp"
#include "tendril/certificate.hpp"
#include "tendril/complementarity.hpp"
#include "tendril/error.hpp"
#include "tendril/execute.hpp"
#include "tendril/feasibility.hpp"
#include "tendril/polish.hpp"
#include "tendril/tolerances.hpp"

namespace tendril {
namespace {

/// Numbers that steer the outer loops. They decide how a plan is found, never whether it is accepted.
constexpr double penalty_growth = 10.0;     ///< of beta, until the branch is decided (model.md section 4)
constexpr double penalty_cap = 1e4;         ///< largest beta
constexpr double relaxation_first = 1e-1;   ///< eps of Scholtes and Fischer-Burmeister ...
constexpr double relaxation_last = 1e-8;    ///< ... ends here ...
constexpr double relaxation_shrink = 1e-2;  ///< ... in these steps
constexpr double violation_level = -5e-10;  ///< half of the depth that is allowed: a valley below it gets a check point
constexpr double grazing_level = 1e-6;      ///< a plan this near to an obstacle (in L) leans on a clearance row
constexpr double contact_neighbourhood =
    0.02;  ///< no check point this near (in L) to a touching contact's own obstacle
constexpr int most_exchanges = 25;
constexpr int most_retries = 3;  ///< of a start whose check points let the rod slip to the wrong side of an obstacle
constexpr int most_pieces_away = 3;       ///< of an unsplit rod, from where the start comes nearest to the obstacle
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
constexpr double at_knot = 1e-7;          ///< (in L) a contact this near to the end of its stretch leans against it

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
  };

  bool must_stop() const { return (control_.stop != nullptr && control_.stop->load()) || now() > deadline_; }
  /// So much time has gone without a plan that what is left has to be enough for all that was not tried.
  bool hurried() const { return !have_plan_ && deadline_ - now() < little_time * d_.scene.solver.time_limit; }
  SolveControl limits() const {
    SolveControl c;
    c.tolerance = d_.scene.solver.tolerance;
    c.max_iterations = d_.scene.solver.max_iterations;
    c.time_limit = std::max(1e-3, most_of_time * (deadline_ - now()));
    c.stop = control_.stop;
    return c;
  }

  StartShape shape_of(const Plan& plan, const Mode& mode) const;
  StartShape start_shape(int index, const Mode& mode) const;
  /// Loads decide how the rod hangs.
  bool loaded() const;
  /// The rod without moments as its loads pull it: along them but for a bend next to the clamp.
  StartShape hanging(bool long_way) const;
  /// Where no plan was found: more starts, then every assignment of contacts if there are not too many.
  void search_further(int starts, const std::vector<std::size_t>& order);
  /// Every mode that could be had ended where its violation is stationary.
  bool all_infeasible() const;
  /// Where every search ended at an equilibrium that is not stable: what the rod would do under the moments found.
  void settle();
  /// A start of a grasp. Without a force the row of the balance says nothing about where the contact should be.
  StartShape held(double tip_angle, const Mode& mode) const;
  void try_start(ModeState& state, const StartShape& shape);
  void attempt(ModeState& state, const StartShape& shape, const std::vector<int>& regions);
  /// Remembers which term is not finite at x, for the report.
  void note_unfit_term(PoseProgram& program, const Eigen::VectorXd& x);
  /// From x (any quality) to a decided branch and a point on it. False: no feasible point was found.
  bool find_point(ModeState& state, PoseProgram& program, Eigen::VectorXd& x, Branch forced);
  bool treat(ModeState& state, PoseProgram& program, Eigen::VectorXd& x, Treatment treatment);
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
  bool contacts_unchanged(const Candidate& candidate) const;
  bool exchange(const PoseProgram& program, ConstVectorRef x, Certifier& certifier, std::vector<CheckPoint>& checks,
                double level) const;
  /// Whether a plan from this start could still win; then it is looked for.
  void consider(ModeState& state, const StartShape& shape);
  /// Adds contacts to the best modes of each size.
  void grow();
  std::size_t state_of(const std::vector<ContactSetup>& contacts);
  /// The contacts that hold the earlier plan, if this scene can have them.
  std::optional<std::vector<ContactSetup>> contacts_of_start() const;
  std::vector<std::size_t> parents(int contacts) const;
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
  bool have_plan_ = false;               ///< some mode is certified
  std::string unfit_;                    ///< a term that gave no number, in words
  bool following_ = false;               ///< only Newton may move points
  bool every_assignment_tried_ = false;  ///< although they are too many to begin with
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

/// Shape, moments and contacts of an earlier result, as far as `mode` has them.
StartShape Planner::shape_of(const Plan& plan, const Mode& mode) const {
  const double length = d_.scale.length;
  StartShape shape;
  shape.curvature = curvature_of(plan, length);
  if (plan.moments.size() == d_.rod.actuators.size()) {
    for (const double u : plan.moments) shape.moments.push_back(u / d_.scale.moment());
  }
  for (const ContactSetup& c : mode.contacts) {
    double s = std::numeric_limits<double>::quiet_NaN();
    double f = 0.0;
    for (const PlannedContact& planned : plan.contacts) {
      if (planned.obstacle_name != d_.obstacle_names[static_cast<std::size_t>(c.obstacle)] ||
          planned.at_tip != c.at_tip)
        continue;
      s = planned.arc_length / length;
      f = planned.force / d_.scale.force();
    }
    shape.arc_lengths.push_back(s);
    shape.forces.push_back(f);
  }
  if (plan.grasp) shape.palm_distance = plan.grasp->palm_distance / length;
  return shape;
}

StartShape Planner::start_shape(int index, const Mode& mode) const {
  // An earlier plan comes first, then the scene's own start, then shapes that bend to either side.
  if (control_.start != nullptr && !control_.start->backbone.empty()) {
    if (index == 0) return shape_of(*control_.start, mode);
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
  tally_.iterations += report.iterations;
  tally_.seconds += report.seconds;
  tally_.seconds_evaluating += report.seconds_evaluating;
  add_counts(tally_.evaluations, report.evaluations);
  return report;
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

bool Planner::exchange(const PoseProgram& program, ConstVectorRef x, Certifier& certifier,
                       std::vector<CheckPoint>& checks, double level) const {
  const Chain& chain = program.chain();
  const PoseProgram::Layout& at = program.layout();
  const std::span<const double> knots(x.data() + at.first_arc_length, static_cast<std::size_t>(chain.knot_count()));
  bool changed = false;
  std::vector<bool> moved(checks.size(), false);
  for (const Certifier::Approach& valley : certifier.approaches(x, level)) {
    const double s = valley.at.arc_length;
    bool own_contact = false;
    for (int k = 0; k < at.forces; ++k) {
      const ContactSetup& c = program.spec().contacts[static_cast<std::size_t>(k)];
      if (c.obstacle != valley.obstacle || program.branch(k) != Branch::touching) continue;
      const double contact = c.at_tip ? 1.0 : x[at.first_arc_length + k];
      own_contact = own_contact || std::abs(contact - s) < contact_neighbourhood;
    }
    if (own_contact) continue;
    CheckPoint wanted{valley.at.piece, valley.at.sigma, valley.obstacle};
    if (wanted.sigma < 1e-6) {
      // The start of a piece is the end of the one before; the base itself cannot move.
      if (wanted.piece == 0) continue;
      wanted = {wanted.piece - 1, 1.0, wanted.obstacle};
    }
    // The nearest check point of the same valley moves: between it and the valley's floor the distance does not rise
    // above what it is at the check point. A neighbourhood of a tenth of the rod stands for that.
    int nearest = -1;
    double best = 0.1;
    for (std::size_t i = 0; i < checks.size(); ++i) {
      if (checks[i].obstacle != valley.obstacle || (i < moved.size() && moved[i])) continue;
      const double own = chain.start(checks[i].piece, knots) + checks[i].sigma * chain.length(checks[i].piece, knots);
      if (std::abs(own - s) >= best) continue;
      best = std::abs(own - s);
      nearest = static_cast<int>(i);
    }
    if (nearest >= 0) {
      checks[static_cast<std::size_t>(nearest)] = wanted;
      moved[static_cast<std::size_t>(nearest)] = true;
    } else {
      checks.push_back(wanted);
      moved.push_back(true);
    }
    changed = true;
  }
  return changed;
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
  // What is only nearly feasible is feasible, or a place where the violation is stationary.
  if (!sharp && infeasibility(*c.program, x) > restored) {
    sharp = recover(state, *c.program, x);
    if (!sharp && infeasibility(*c.program, x) > restored) return true;
  }
  for (int round = 0; exchanges && round < most_exchanges && !must_stop(); ++round) {
    if (!x.allFinite() || !exchange(*c.program, x, *c.certifier, checks, violation_level)) break;
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
  // From the same start, with every place checked where the rod went through an obstacle before.
  const auto search = [&](Branch branch) {
    bool touching = false;
    for (int retry = 0; retry <= most_retries && !must_stop(); ++retry) {
      spec.checks = checks;
      PoseProgram program(spec);
      Eigen::VectorXd x = program.start_from(shape);
      if (hurried() && state.starts_used > 1 && nothing_near(state, program, x)) break;
      if (!find_point(state, program, x, branch)) {
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
  // of an obstacle, and the better side is worth a start.
  if (winner_ >= 0 && winner_ != state.mode && state.best.certified() && !must_stop() &&
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

std::optional<std::vector<ContactSetup>> Planner::contacts_of_start() const {
  std::vector<std::pair<double, ContactSetup>> holding;
  for (const PlannedContact& c : control_.start->contacts) {
    if (!(c.force > 0.0)) continue;
    const auto name = std::find(d_.obstacle_names.begin(), d_.obstacle_names.end(), c.obstacle_name);
    if (name == d_.obstacle_names.end()) return std::nullopt;
    const double s = c.at_tip ? 1.0 : c.arc_length / d_.scale.length;
    const int obstacle = static_cast<int>(name - d_.obstacle_names.begin());
    holding.push_back({s, {obstacle, c.at_tip, c.at_tip ? 0 : stretch_at(d_.rod, s)}});
  }
  if (static_cast<int>(holding.size()) > d_.scene.contact.count) return std::nullopt;
  std::stable_sort(holding.begin(), holding.end(), [](const auto& a, const auto& b) {
    return std::pair(a.second.at_tip, a.first) < std::pair(b.second.at_tip, b.first);
  });
  std::vector<ContactSetup> contacts;
  contacts.reserve(holding.size());
  for (const auto& [s, contact] : holding) contacts.push_back(contact);
  return contacts;
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

bool Planner::contacts_unchanged(const Candidate& candidate) const {
  if (!d_.contact_planned()) return true;
  PoseProgram& program = *candidate.program;
  const PoseProgram::Layout& at = program.layout();
  for (int k = 0; k < at.forces; ++k) {
    if (candidate.x[program.force_variable(k)] <= std::max(tolerance::force, d_.min_force)) return false;
  }
  for (int v = at.first_arc_length; v < at.first_arc_length + at.arc_lengths; ++v) {
    if (candidate.x[v] <= program.lower()[v] + at_knot || candidate.x[v] >= program.upper()[v] - at_knot) return false;
  }
  // A rod held off by a mere clearance row could press there.
  const VectorView c = program.constraints(candidate.x);
  return at.checks == 0 || c.segment(at.first_check, at.checks).minCoeff() > tolerance::branch_decided;
}

int Planner::follow() {
  const Plan& earlier = *control_.start;
  const bool same_coordinates = earlier.status == PlanStatus::solved &&
                                earlier.coordinates_name == d_.scene.coordinates.plugin &&
                                earlier.order == d_.components.coordinates->function_count() &&
                                earlier.split_at_contact == d_.scene.coordinates.split_at_contact &&
                                earlier.moments.size() == d_.rod.actuators.size();
  if (!same_coordinates) return -1;
  const std::optional<std::vector<ContactSetup>> contacts = contacts_of_start();
  // A contact that did not press, or another order of them: other modes know more about it.
  const auto same_place = [&](const ContactSetup& c, const PlannedContact& p) {
    return p.at_tip == c.at_tip && p.obstacle_name == d_.obstacle_names[static_cast<std::size_t>(c.obstacle)];
  };
  if (!contacts ||
      !std::equal(contacts->begin(), contacts->end(), earlier.contacts.begin(), earlier.contacts.end(), same_place)) {
    return -1;
  }
  if (contacts->empty() ? d_.min_force > 0.0 : !d_.contact_planned()) return -1;
  ModeState& state = states_[state_of(*contacts)];
  const Mode mode = modes_[static_cast<std::size_t>(state.mode)];
  if (!mode.skip.empty()) return -1;

  const Chain chain(d_.rod, *d_.components.coordinates, {}, 1);
  std::vector<int> regions;
  for (std::size_t k = 0; k < mode.contacts.size(); ++k) {
    const ContactSetup& c = mode.contacts[k];
    const bool in_piece = !c.at_tip && !d_.scene.coordinates.split_at_contact;
    regions.push_back(in_piece ? chain.piece_at(earlier.contacts[k].arc_length / d_.scale.length, {}) : c.region);
  }
  PoseProgramSpec spec = d_.spec(mode, regions, d_.nodes);
  PoseProgram program(spec);
  const PoseProgram::Layout& at = program.layout();
  if (at.coordinates != static_cast<int>(earlier.coordinates.size())) return -1;
  const StartShape shape = start_shape(0, mode);
  Eigen::VectorXd x = program.start_from(shape);
  x.head(at.coordinates) = Eigen::Map<const Eigen::VectorXd>(earlier.coordinates.data(), at.coordinates);
  std::vector<CheckPoint> checks = d_.first_checks(spec, shape);
  const std::vector<Branch> branches(mode.contacts.size(), Branch::touching);
  set_branches(program, branches);
  // Where the earlier plan grazes an obstacle, Newton has to know.
  Certifier certifier(spec);
  exchange(program, x, certifier, checks, grazing_level);

  following_ = true;
  complete(state, regions, checks, x, branches);
  following_ = false;
  if (state.best.certified() && contacts_unchanged(state.best)) {
    state.record.outcome = "followed from the earlier plan; ";
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
    if (unstable == nullptr) return;
    std::vector<double> moments;
    for (std::size_t a = 0; a < d_.rod.actuators.size(); ++a) {
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
    for (std::size_t i = 0; i < modes; ++i) consider(states_[i], shape_of(settled, modes_[i]));
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
    const auto won = contacts_of_start();
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
  const int starts = most_starts + (control_.start != nullptr ? 1 : 0) + (d_.palm ? 1 : 0);
  if (control_.follow && control_.start != nullptr) winner_ = follow();
  if (winner_ >= 0) return report(states_, winner_);
  for (int round = 0; round < starts && !must_stop(); ++round) {
    // One start per mode finds most plans; only if no mode is certified are more starts spent. A grasp comes in
    // families with several valleys of the effort.
    if (round > 0 && winner_ >= 0 && !d_.palm) break;
    for (const std::size_t i : order) consider(states_[i], start_shape(round, modes_[i]));
    if (!d_.enumerated) grow();
  }
  search_further(starts, order);
  settle();
  return report(states_, winner_);
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
      state.record.outcome = followed ? "not tried: the earlier plan could be followed" : "not tried: stopped before";
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
  // Between nodes the samples stand on an interpolating polynomial: a finer rule than the rows need.
  PoseProgramSpec finer = program.spec();
  finer.nodes *= 2;
  PoseProgram sampler(finer);
  sampler.constraints(x);
  plan.backbone = sampled_backbone(sampler, length);
  if (d_.palm) finish_grasp(d_, program, x, plan);
  plan.seconds_certify = tally_.seconds_certifying;
  return plan;
}

}  // namespace

Plan Problem::plan(const PlanControl& control) {
  const double begin = now();
  Planner planner(*data_, control);
  Plan plan = planner.run();
  plan.seconds_assemble = data_->seconds_assemble;
  plan.seconds_solve = now() - begin - plan.seconds_certify;
  if (!data_->palm) plan.start_backbone = outline(data_->scene_start(), data_->rod, data_->scale.length);
  return plan;
}

}  // namespace tendril
