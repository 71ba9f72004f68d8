#include "search/friction.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "certificate/check_points.hpp"
#include "nlp/multipliers.hpp"
#include "program/worst_program.hpp"
#include "rod/self_overlap.hpp"
#include "scene/plan_report.hpp"
#include "search/completion.hpp"
#include "search/earlier_plan.hpp"
#include "search/either_way.hpp"
#include "search/limit.hpp"
#include "search/parameters.hpp"
#include "search/report.hpp"
#include "search/steps.hpp"
#include "tendril/tolerances.hpp"

namespace tendril {
namespace {

/// A state within the cones costs more than their corners if by this share.
constexpr double costs_more = 1e-9;

/// While it lives, no tangential forces are planned.
class Frictionless {
 public:
  explicit Frictionless(Task& task) : upper_{task.friction} {
    upper_.of.clear();
    if (!task.lower) return;
    lower_.emplace(Kept<std::vector<double>>{task.lower->friction});
    task.lower->friction.clear();
  }

 private:
  Kept<std::vector<double>> upper_;
  std::optional<Kept<std::vector<double>>> lower_;
};

/// The contacts of a plan in a program whose tangential ratios are variables, and the plan's own point there.
struct RubbingPoint {
  FollowedPoint from{};
  PoseProgramSpec spec{};
};

std::optional<RubbingPoint> rubbing_point(const Task& task, const Plan& plan, bool with_checks) {
  std::optional<FollowedPoint> from = followed_point(task, plan, with_checks);
  if (!from || from->mode.contacts.empty() || !task.scene.coordinates.split_at_contact) return std::nullopt;
  RubbingPoint point{std::move(*from), {}};
  point.spec = task.spec(point.from.mode, point.from.regions, task.nodes);
  point.spec.checks = point.from.checks;
  if (task.friction.empty()) {
    // The ratios come last.
    point.spec.friction = coefficients_of_friction(task);
    const Eigen::Index before = point.from.x.size();
    const auto contacts = static_cast<Eigen::Index>(point.from.mode.contacts.size());
    point.from.x.conservativeResize(before + contacts);
    point.from.x.tail(contacts).setZero();
  }
  return point;
}

/// The equilibria of such a program, all contacts touching.
struct Equilibria {
  static std::unique_ptr<PoseProgram> touching(const PoseProgramSpec& spec) {
    auto program = std::make_unique<PoseProgram>(spec);
    for (int k = 0; k < program->layout().forces; ++k) program->set_branch(k, Branch::touching);
    return program;
  }
  Equilibria(const PoseProgramSpec& spec, ConstVectorRef x) : program(touching(spec)), reduced(*program, x) {}
  static bool apply(const PoseProgramSpec& spec) { return ReducedProgram::applies(*touching(spec)); }

  Eigen::VectorXd moments() const { return reduced.start().head(reduced.variable_count() - reduced.ratio_count()); }

  std::unique_ptr<PoseProgram> program;
  ReducedProgram reduced;
};

/// Every contact that can rub about to slip either way; `share`: so far towards that.
std::vector<Eigen::VectorXd> corners(const ReducedProgram& reduced, double share) {
  const int count = reduced.ratio_count();
  std::vector<Eigen::VectorXd> all;
  for (int corner = 0; corner < 1 << count; ++corner) {
    Eigen::VectorXd ratios = share * reduced.upper().tail(count);
    for (int k = 0; k < count; ++k) ratios[k] *= (corner >> k & 1) != 0 ? 1.0 : -1.0;
    all.push_back(std::move(ratios));
  }
  return all;
}

/// Of an equilibrium at given moments: nothing was chosen there. Limits are not looked at, except that each contact is
/// on its stretch.
Certificate certify_equilibrium(Certifier& certifier, PoseProgram& program, ConstVectorRef x) {
  Certificate c;
  certifier.measure(program, x, c);
  const PoseProgram::Layout& at = program.layout();
  c.bounds = 0.0;
  for (int i = at.first_arc_length; i < at.first_force; ++i) {
    c.bounds = std::max({c.bounds, program.lower()[i] - x[i], x[i] - program.upper()[i]});
  }
  c.balance = c.stationarity = 0.0;
  c.stationarity_kind = "S";
  list_failures(c);
  return c;
}

FrictionRange record(const Task& task, PoseProgram& program, ConstVectorRef x, const Certificate& c) {
  Plan plan;
  tell_point(task, program, x, plan);
  FrictionRange r{{}, plan.tip_x, plan.tip_y, plan.tip_angle, plan.target_error, c.stability, std::move(plan.contacts)};
  for (std::size_t k = 0; k < r.contacts.size(); ++k) {
    const double side = dot(r.contacts[k].tangent, turned(r.contacts[k].normal));
    r.ratios.push_back(std::copysign(1.0, side) * program.contacts()[k].lean + 0.0);
  }
  return r;
}

/// Looks for the moments whose worst state of friction costs least, near a plan without friction.
class WorstCase {
 public:
  WorstCase(Task& task, RubbingPoint point, const PlanControl& control)
      : task_(task), point_(std::move(point)), steps_(*task.components.solver, task.scene.solver, control) {}

  /// Turns the plan without friction into this one, or says there why there is none. What it took.
  ModeRecord run(Plan& plan);

 private:
  using States = std::vector<std::unique_ptr<Equilibria>>;

  void build();
  /// The best moments for the states as they are; empty: there are none.
  Eigen::VectorXd solve(WorstProgram& program);
  Eigen::VectorXd polished(WorstProgram& program, const Eigen::VectorXd& x);
  /// Whether check points or states were missing, which are there from now on.
  bool exchange(WorstProgram& program, const Eigen::VectorXd& x);
  void report(WorstProgram& program, const Eigen::VectorXd& x, Plan& plan);
  void refuse(Plan& plan, PlanStatus status, const std::string& why) const;
  std::string named(std::size_t state);

  Task& task_;
  RubbingPoint point_;
  ProgramSearch steps_;
  Attempt attempt_;
  std::vector<Eigen::VectorXd> ratios_;
  States states_;
  double unit_ = 1.0;  ///< of the cost, in the program
  std::unique_ptr<WorstProgram> worst_;
};

void WorstCase::refuse(Plan& plan, PlanStatus status, const std::string& why) const {
  plan.status = steps_.deadline().interrupted() ? PlanStatus::interrupted
                : steps_.deadline().over()      ? PlanStatus::time_limit
                                                : status;
  plan.message = why;
}

void WorstCase::build() {
  states_.clear();
  std::vector<WorstProgram::State> all;
  if (ratios_.empty()) {
    const Equilibria own(point_.spec, point_.from.x);
    ratios_ = corners(own.reduced, 1.0);
    ratios_.insert(ratios_.begin(), Eigen::VectorXd::Zero(own.reduced.ratio_count()));
  }
  // Differences below this do not count.
  unit_ = search_parameters().beats;
  for (const Eigen::VectorXd& ratios : ratios_) {
    states_.push_back(std::make_unique<Equilibria>(point_.spec, point_.from.x));
    ReducedProgram& reduced = states_.back()->reduced;
    all.push_back({&reduced, ratios});
    Eigen::VectorXd there = reduced.start();
    there.tail(ratios.size()) = ratios;
    if (const double cost = std::abs(reduced.cost(there)); cost > unit_) unit_ = cost;
  }
  worst_ = std::make_unique<WorstProgram>(std::move(all), unit_);
}

Eigen::VectorXd WorstCase::polished(WorstProgram& program, const Eigen::VectorXd& x) {
  // Costs that lie near each other do not all bind: those do whose multipliers a fit needs.
  constexpr double active = 1e-5;
  const KktJudgement judged = judge_kkt(program, x, active);
  PolishOptions options;
  options.stop = [this] { return steps_.must_stop(); };
  const EvaluationCounts before = program.counts();
  const PolishReport p = polish(program, x, judged.multipliers, options);
  ++attempt_.record.polishes;
  steps_.tally.add_outside(program, before);
  const bool nearer = p.converged && p.infeasibility <= tolerance::equilibrium &&
                      p.x[p.x.size() - 1] <= x[x.size() - 1] + search_parameters().nearly_feasible;
  return nearer ? p.x : x;
}

Eigen::VectorXd WorstCase::solve(WorstProgram& program) {
  Eigen::VectorXd x = program.start(states_.front()->moments());
  if (!x.allFinite()) {
    attempt_.trouble = "the rod does not follow to every state of friction at the moments of the plan without";
    return {};
  }
  OptimalityReport r = steps_.solve(attempt_, program, x);
  if (!usable(r, x)) {
    const FeasibilityReport f = steps_.restore(attempt_, program, x);
    if (!f.feasible) return {};
    r = steps_.solve(attempt_, program, f.x);
    if (!usable(r, x)) r.x = f.x;
  }
  return polished(program, r.x);
}

bool WorstCase::exchange(WorstProgram& program, const Eigen::VectorXd& x) {
  double most = -infinity;
  Certifier certifier(point_.spec);
  const bool exchanges = task_.scene.contact.check_points == 0;
  bool missing = false;
  std::vector<CheckPoint> checks = point_.spec.checks;
  for (std::size_t k = 0; k < states_.size(); ++k) {
    Equilibria& state = *states_[k];
    most = std::max(most, state.reduced.cost(program.point(k, x)));
    const Eigen::VectorXd full = state.reduced.full(program.point(k, x));
    if (!full.allFinite()) return false;
    missing = (exchanges && exchange_checks(*state.program, full, certifier, checks, violation_level, true)) || missing;
    if (k == 0) point_.from.x = full;
  }
  if (missing) {
    keep_unique(checks);
    point_.spec.checks = std::move(checks);
  }
  Equilibria& first = *states_.front();
  for (const Eigen::VectorXd& half : corners(first.reduced, 0.5)) {
    Eigen::VectorXd there = program.point(0, x);
    there.tail(half.size()) = half;
    if (!(first.reduced.cost(there) > most + costs_more * (1.0 + std::abs(most)))) continue;
    const bool known = std::find(ratios_.begin(), ratios_.end(), half) != ratios_.end();
    if (!known) ratios_.push_back(half);
    missing = missing || !known;
  }
  return missing;
}

std::string WorstCase::named(std::size_t state) {
  std::string text;
  PoseProgram& program = *states_[state]->program;
  for (std::size_t k = 0; k < program.contacts().size(); ++k) {
    if (program.contacts()[k].lean == 0.0) continue;
    const int obstacle = program.spec().contacts[k].obstacle;
    text += (text.empty() ? "" : ", ") + shown(program.contacts()[k].lean) + " at '" +
            task_.obstacle_names[static_cast<std::size_t>(obstacle)] + "'";
  }
  return text.empty() ? "without friction" : "with the ratios " + text;
}

void WorstCase::report(WorstProgram& program, const Eigen::VectorXd& x, Plan& plan) {
  const double stationarity = unit_ * judge_kkt(program, x, 1e-8).stationarity;
  Certifier certifier(point_.spec);
  std::optional<Certificate> all;
  std::string why;
  std::size_t worst = 0;
  std::vector<double> costs;
  for (std::size_t k = 0; k < states_.size(); ++k) {
    Equilibria& state = *states_[k];
    const Eigen::VectorXd full = state.reduced.full(program.point(k, x));
    if (!full.allFinite()) return refuse(plan, PlanStatus::not_converged, named(k) + ": the rod does not follow");
    Certificate c;
    certifier.measure(*state.program, full, c);
    c.balance = 0.0;
    c.stationarity = stationarity;
    c.stationarity_kind = stationarity <= tolerance::stationarity ? "S" : "none";
    list_failures(c);
    costs.push_back(state.program->cost(full));
    if (costs[k] > costs[worst]) worst = k;
    if (why.empty() && !c.valid()) why = named(k) + ": " + c.failures.front();
    all = all ? worse_of(*all, c) : c;
  }
  Equilibria& shown_state = *states_[worst];
  const Eigen::VectorXd full = shown_state.reduced.full(program.point(worst, x));
  tell_point(task_, *shown_state.program, full, plan);
  plan.certificate = *all;
  plan.backbone = sampled_backbone(certifier.finer(full), task_.scale.length);
  plan.self_overlap = self_overlap(plan.backbone, task_.scene.rod.body());
  plan.minima.clear();
  if (why.empty()) return;
  refuse(plan, only_unstable(*all) ? PlanStatus::unstable : PlanStatus::not_converged, why);
}

ModeRecord WorstCase::run(Plan& plan) {
  Eigen::VectorXd x;
  for (int round = 0; round < search_parameters().most_exchanges; ++round) {
    build();
    x = solve(*worst_);
    const bool last = round + 1 == search_parameters().most_exchanges;
    if (x.size() == 0 || steps_.must_stop() || last || !exchange(*worst_, x)) break;
  }
  if (x.size() == 0) {
    refuse(plan, PlanStatus::not_converged,
           "no moments keep every limit in all states of friction: " + attempt_.trouble);
  } else {
    report(*worst_, x, plan);
    plan.solver = attempt_.last;
  }
  plan.evaluations += steps_.tally.evaluations;
  plan.evaluations += steps_.tally.outside_solver;
  return attempt_.record;
}

/// The record of the way of being in contact that a solved plan is of.
const ModeRecord& way_of(const Plan& plan) {
  return *std::min_element(plan.modes.begin(), plan.modes.end(), [&](const ModeRecord& a, const ModeRecord& b) {
    const auto apart = [&](const ModeRecord& m) {
      return m.certified ? std::abs(m.objective - plan.objective) : infinity;
    };
    return apart(a) < apart(b);
  });
}

bool rubs(const Task& task, const Plan& plan) {
  return std::any_of(plan.contacts.begin(), plan.contacts.end(), [&](const PlannedContact& c) {
    return c.force > tolerance::force * task.scale.force() && task.friction[static_cast<std::size_t>(c.obstacle)] > 0.0;
  });
}

/// From a plan without friction to the one for its worst state, touching what it touches. What it took.
ModeRecord turn_to_worst(Task& task, const PlanControl& control, Plan& plan) {
  std::optional<RubbingPoint> point = rubbing_point(task, plan, true);
  plan.scan.reset();  // of plans without friction
  if (point && Equilibria::apply(point->spec)) return WorstCase(task, std::move(*point), control).run(plan);
  plan.status = PlanStatus::not_converged;
  plan.message = "the states of friction of its contacts cannot be followed";
  return {};
}

}  // namespace

std::vector<double> coefficients_of_friction(const Task& task) {
  std::vector<double> all;
  bool any = false;
  for (std::size_t o = 0; o < task.scene.obstacles.size(); ++o) {
    all.push_back(friction_of(task.scene, o));
    any = any || all.back() > 0.0;
  }
  return any ? all : std::vector<double>{};
}

Plan plan_any(Task& task, const PlanControl& control, const std::function<Plan(const PlanControl&)>& search) {
  Limit limit(task);
  Plan without;
  {
    const Frictionless none(task);
    without = search(control);
    without.scan.reset();  // it knows nothing of plans with friction
  }
  if (without.status == PlanStatus::interrupted || without.status == PlanStatus::failed) return without;
  if (!limit.leaves_time()) {
    without.search_cut = true;
    return without;
  }
  const bool solved = without.status == PlanStatus::solved;
  PlanControl from_it = control;
  if (solved) from_it.start = &without;
  Plan plan = search(from_it);
  const bool better = plan.status == PlanStatus::solved && plan.objective <= without.objective;
  return better || !solved ? plan : without;
}

Plan plan_worst(Task& task, const PlanControl& control) {
  Limit limit(task);
  PlanControl own = control;
  Plan best;
  std::vector<ModeRecord> ways;
  for (bool first = true;; first = false) {
    Plan next;
    {
      const Frictionless none(task);
      next = plan_to_target(task, own);
    }
    const bool ended = next.status != PlanStatus::solved;
    // Whatever its worst state is, that costs no less.
    if (!first && (ended || (best.status == PlanStatus::solved && next.objective >= best.objective))) break;
    if (!ended) {
      ModeRecord way = way_of(next);
      own.without.push_back(way.mode);
      const ModeRecord more = rubs(task, next) ? turn_to_worst(task, control, next) : ModeRecord{};
      way.solves += more.solves;
      way.polishes += more.polishes;
      way.iterations += more.iterations;
      way.evaluations += more.evaluations;
      way.outcome += next.status == PlanStatus::solved ? ", in the worst state of friction " + shown(next.objective)
                                                       : "; " + next.message;
      ways.push_back(std::move(way));
    }
    const bool better =
        next.status == PlanStatus::solved && (best.status != PlanStatus::solved || next.objective < best.objective);
    if (first || better) best = std::move(next);
    if (ended || best.status == PlanStatus::interrupted) break;
    if (!limit.leaves_time()) {
      best.search_cut = true;
      break;
    }
  }
  for (ModeRecord& record : best.modes) {
    const auto known =
        std::find_if(ways.begin(), ways.end(), [&](const ModeRecord& w) { return w.mode == record.mode; });
    if (known != ways.end()) record = *known;
  }
  return best;
}

std::optional<std::vector<FrictionRange>> friction_states(const Task& task, const Plan& plan) {
  std::optional<RubbingPoint> point = rubbing_point(task, plan, false);
  if (!point || !Equilibria::apply(point->spec)) return std::nullopt;
  Equilibria own(point->spec, point->from.x);
  const int count = own.reduced.ratio_count();
  if (count > static_cast<int>(most_rubbing)) return std::nullopt;
  Certifier certifier(point->spec);
  std::vector<FrictionRange> found;
  Eigen::VectorXd at = own.reduced.start();
  const auto look = [&](const Eigen::VectorXd& ratios, bool keep) {
    at.tail(count) = ratios;
    const Eigen::VectorXd& x = own.reduced.full(at);
    if (!x.allFinite()) return false;
    const Certificate c = certify_equilibrium(certifier, *own.program, x);
    if (keep && c.valid()) found.push_back(record(task, *own.program, x, c));
    return c.valid();
  };
  if (!look(Eigen::VectorXd::Zero(count), true)) return std::nullopt;
  for (const double share : {0.5, 1.0}) {
    for (const Eigen::VectorXd& ratios : corners(own.reduced, share)) {
      if (!look(ratios, share == 1.0)) return std::nullopt;
    }
  }
  return found;
}

}  // namespace tendril
