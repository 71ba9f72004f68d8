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
#include "search/rubbing.hpp"
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

/// The equilibria of a program whose contacts rub, all touching.
struct Equilibria {
  Equilibria(const PoseProgramSpec& spec, ConstVectorRef x) : program(touching(spec)), reduced(*program, x) {}
  static bool apply(const PoseProgramSpec& spec) { return ReducedProgram::applies(*touching(spec)); }

  Eigen::VectorXd moments() const { return reduced.start().head(reduced.variable_count() - reduced.ratio_count()); }

  std::unique_ptr<PoseProgram> program;
  ReducedProgram reduced;
};

Eigen::VectorXd limits_of(const ReducedProgram& reduced) { return reduced.upper().tail(reduced.ratio_count()); }

/// A grasp whose one contact presses as hard as it may in the state where it presses hardest: no objective weighs its
/// force.
bool presses_as_hard_as_it_may(const Task& task) {
  return task.palm && task.scene.contact.count == 1 && std::isfinite(task.max_force) &&
         std::none_of(task.terms.begin(), task.terms.end(),
                      [](const PoseProgramTerm& t) { return t.term->reads().contact_force; });
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
  /// The states that the search begins with.
  void begin();
  /// Of more contacts than most_rubbing: the corner that is left where turning any one contact round costs less.
  Eigen::VectorXd climbed(WorstProgram& program, const Eigen::VectorXd& x, Eigen::VectorXd ratios);
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
  Eigen::VectorXd limits_;
  std::optional<std::size_t> pressing_;  ///< the state of a grasp whose force is at its limit
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

void WorstCase::begin() {
  Equilibria own(point_.spec, point_.from.x);
  limits_ = limits_of(own.reduced);
  Eigen::VectorXd there = own.reduced.start();
  const auto at = [&](const Eigen::VectorXd& ratios) -> ReducedProgram& {
    there.tail(ratios.size()) = ratios;
    return own.reduced;
  };
  if (limits_.size() <= most_rubbing) {
    ratios_ = corners(limits_);
  } else {
    // Each contact alone says which way it makes the plan cost more.
    Eigen::VectorXd corner = limits_;
    for (Eigen::Index i = 0; i < limits_.size(); ++i) {
      const Eigen::VectorXd alone = limits_[i] * Eigen::VectorXd::Unit(limits_.size(), i);
      const double above = at(alone).cost(there);
      if (at(-alone).cost(there) > above) corner[i] = -corner[i];
    }
    ratios_ = {corner, -corner};
  }
  ratios_.insert(ratios_.begin(), Eigen::VectorXd::Zero(limits_.size()));
  if (!presses_as_hard_as_it_may(task_)) return;
  double most = 0.0;
  for (std::size_t k = 0; k < ratios_.size(); ++k) {
    const Eigen::VectorXd& x = at(ratios_[k]).full(there);
    const double force = x[own.program->force_variable(0)];
    if (force > most) pressing_ = k;
    most = std::max(most, force);
  }
}

Eigen::VectorXd WorstCase::climbed(WorstProgram& program, const Eigen::VectorXd& x, Eigen::VectorXd ratios) {
  ReducedProgram& reduced = states_.front()->reduced;
  Eigen::VectorXd there = program.point(0, x);
  const auto cost = [&](const Eigen::VectorXd& at) {
    there.tail(at.size()) = at;
    return reduced.cost(there);
  };
  double most = cost(ratios);
  for (bool turned = true; turned;) {
    turned = false;
    for (Eigen::Index i = 0; i < ratios.size(); ++i) {
      Eigen::VectorXd other = ratios;
      other[i] = -other[i];
      const double value = cost(other);
      if (!(value > most)) continue;
      most = value;
      ratios = std::move(other);
      turned = true;
    }
  }
  return ratios;
}

void WorstCase::build() {
  states_.clear();
  std::vector<WorstProgram::State> all;
  if (ratios_.empty()) begin();
  // Differences below this do not count.
  unit_ = search_parameters().beats;
  for (const Eigen::VectorXd& ratios : ratios_) {
    PoseProgramSpec spec = point_.spec;
    if (pressing_ == states_.size()) spec.min_force = spec.max_force;
    // No force is left on the object of the plan; in other states of friction something else holds it where it is.
    if (spec.palm && !ratios.isZero(0.0)) spec.palm->balance = false;
    states_.push_back(std::make_unique<Equilibria>(spec, point_.from.x));
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
  std::size_t worst = 0;
  const bool exchanges = task_.scene.contact.check_points == 0;
  bool missing = false;
  std::vector<CheckPoint> checks = point_.spec.checks;
  for (std::size_t k = 0; k < states_.size(); ++k) {
    Equilibria& state = *states_[k];
    if (const double cost = state.reduced.cost(program.point(k, x)); cost > most) {
      most = cost;
      worst = k;
    }
    const Eigen::VectorXd full = state.reduced.full(program.point(k, x));
    if (!full.allFinite()) return false;
    Certifier certifier(state.program->spec());
    missing = (exchanges && exchange_checks(*state.program, full, certifier, checks, violation_level, true)) || missing;
    if (k == 0) point_.from.x = full;
  }
  if (missing) {
    keep_unique(checks);
    point_.spec.checks = std::move(checks);
  }
  Equilibria& first = *states_.front();
  std::vector<Eigen::VectorXd> others;
  if (limits_.size() <= most_rubbing) {
    others = corners(0.5 * limits_);
  } else {
    const Eigen::VectorXd corner = climbed(program, x, ratios_[worst].isZero(0.0) ? limits_ : ratios_[worst]);
    others = {corner, 0.5 * corner};
  }
  for (const Eigen::VectorXd& other : others) {
    Eigen::VectorXd there = program.point(0, x);
    there.tail(other.size()) = other;
    if (!(first.reduced.cost(there) > most + costs_more * (1.0 + std::abs(most)))) continue;
    const bool known = std::find(ratios_.begin(), ratios_.end(), other) != ratios_.end();
    if (!known) ratios_.push_back(other);
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
  std::optional<Certificate> all;
  std::string why;
  std::size_t worst = 0;
  std::vector<double> costs;
  for (std::size_t k = 0; k < states_.size(); ++k) {
    Equilibria& state = *states_[k];
    const Eigen::VectorXd full = state.reduced.full(program.point(k, x));
    if (!full.allFinite()) return refuse(plan, PlanStatus::not_converged, named(k) + ": the rod does not follow");
    Certificate c;
    Certifier(state.program->spec()).measure(*state.program, full, c);
    c.balance = state.program->layout().balances > 0 ? std::abs(axial_force(*state.program)) : 0.0;
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
  plan.backbone = sampled_backbone(Certifier(shown_state.program->spec()).finer(full), task_.scale.length);
  plan.self_overlap = self_overlap(plan.backbone, task_.scene.rod.body());
  if (task_.grip) task_.grip->finish(task_, *shown_state.program, full, plan);
  plan.minima.clear();
  if (limits_.size() > most_rubbing) {
    plan.notes.push_back("friction at " + std::to_string(limits_.size()) +
                         " contacts: its worst state is one that costs more than with any one contact turned round; "
                         "others of the corners were not looked at");
  }
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

Plan plan_worst(Task& task, const PlanControl& control, const std::function<Plan(const PlanControl&)>& search) {
  Limit limit(task);
  PlanControl own = control;
  Plan best;
  std::vector<ModeRecord> ways;
  for (bool first = true;; first = false) {
    Plan next;
    {
      const Frictionless none(task);
      next = search(own);
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

}  // namespace tendril
