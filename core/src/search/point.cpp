#include <algorithm>
#include <cmath>
#include <utility>

#include "certificate/check_points.hpp"
#include "nlp/complementarity.hpp"
#include "nlp/feasibility.hpp"
#include "nlp/multipliers.hpp"
#include "nlp/polish.hpp"
#include "search/earlier_plan.hpp"
#include "search/parameters.hpp"
#include "search/planner.hpp"
#include "search/task.hpp"

namespace tendril {
namespace {

/// Numbers that steer the search. They decide how a plan is found, never whether it is accepted.
constexpr int most_nodes = 600;                         ///< of a quadrature that is refined further
constexpr double swollen_radii[] = {0.02, 0.1, 0.005};  ///< ... to the first of these that works

}  // namespace

OptimalityReport Planner::solve(ModeState& state, NonlinearProgram& program, const Eigen::VectorXd& x,
                                const OptimalityReport* warm) {
  steps_.limit_patience(balanced_by_row() && have_plan_);
  return steps_.solve(state, program, x, warm);
}

bool Planner::sharpen(ModeState& state, PoseProgram& program, Eigen::VectorXd& x, bool solver_allowed) {
  steps_.limit_patience(balanced_by_row() && have_plan_);
  return steps_.sharpen(state, program, x, solver_allowed && !following_);
}

bool Planner::radius_homotopy(ModeState& state, const PoseProgramSpec& spec, const StartShape& shape, Branch forced,
                              PoseProgram& program, Eigen::VectorXd& x) {
  std::vector<std::unique_ptr<ShrunkObstacle>> grown;
  std::vector<double> radii;
  PoseProgramSpec larger = spec;
  larger.checks.clear();
  for (const ContactSetup& c : spec.contacts) {
    const Obstacle*& obstacle = larger.obstacles[static_cast<std::size_t>(c.obstacle)];
    if (obstacle != spec.obstacles[static_cast<std::size_t>(c.obstacle)]) continue;  // grown for another contact
    const double radius = obstacle->smallest_radius();
    if (!(radius < search_parameters().tiny_radius)) continue;
    grown.push_back(std::make_unique<ShrunkObstacle>(*obstacle));
    radii.push_back(radius);
    obstacle = grown.back().get();
  }
  if (grown.empty() || !search_parameters().grow_small || must_stop() || following_) return false;
  const auto grow_to = [&](double radius) {
    for (std::size_t i = 0; i < grown.size(); ++i) grown[i]->shrink(-std::max(0.0, radius - radii[i]));
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
    steps_.tally.add_outside(easier, before);
    if (p.converged && p.infeasibility <= tolerance::equilibrium) {
      at = p.x;
      radius = next;
      continue;
    }
    share = std::sqrt(share);
    if (share > search_parameters().slowest_shrinking) return false;
  }
  set_branches(program, branches_of(easier));
  x = at;
  return true;
}

bool Planner::solve_treatment(ModeState& state, PoseProgram& program, Eigen::VectorXd& x, Treatment treatment) {
  std::vector<ComplementaryPair> pairs(static_cast<std::size_t>(program.layout().forces));
  for (int k = 0; k < program.layout().forces; ++k) {
    pairs[static_cast<std::size_t>(k)] = {program.layout().first_gap + k, program.force_variable(k)};
  }
  const bool relaxes = treatment == Treatment::scholtes || treatment == Treatment::fischer_burmeister;
  const double first = relaxes ? search_parameters().relaxation_first : d_.scene.contact.beta;
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
    if (report.infeasibility > search_parameters().nearly_feasible) break;
    double undecided = 0.0;
    const VectorView c = program.constraints(full.head(program.variable_count()));
    for (const ComplementaryPair& p : pairs) undecided = std::max(undecided, std::min(c[p.row], full[p.variable]));
    if (relaxes) {
      if (parameter <= search_parameters().relaxation_last) break;
      parameter = std::max(search_parameters().relaxation_last, parameter * search_parameters().relaxation_shrink);
    } else {
      if (undecided <= tolerance::branch_decided || parameter >= search_parameters().penalty_cap) break;
      parameter = std::min(search_parameters().penalty_cap, parameter * search_parameters().penalty_growth);
    }
  }
  x = full.head(program.variable_count());
  const VectorView c = program.constraints(x);
  for (int k = 0; k < program.layout().forces; ++k) {
    const double gap = c[pairs[static_cast<std::size_t>(k)].row];
    const double force = x[pairs[static_cast<std::size_t>(k)].variable];
    program.set_branch(k, gap <= force ? Branch::touching : Branch::separated);
  }
  return report.infeasibility <= search_parameters().nearly_feasible;
}

bool Planner::find_point(ModeState& state, PoseProgram& program, Eigen::VectorXd& x, Branch forced) {
  const int contacts = program.layout().forces;
  const Eigen::VectorXd start = x;
  if (contacts == 0 || forced == Branch::touching) {
    for (int k = 0; k < contacts; ++k) program.set_branch(k, Branch::touching);
    OptimalityReport r = solve(state, program, x);
    if (!r.x.allFinite() || r.x.size() != x.size()) return false;
    x = r.x;
    if (r.infeasibility <= search_parameters().nearly_feasible) return true;
  } else {
    if (solve_treatment(state, program, x, d_.scene.contact.treatment)) return true;
    // With a plan in hand the branch that touches is tried directly; the slower treatment is for when nothing else
    // works.
    if (search_parameters().fall_back && d_.scene.contact.treatment != Treatment::scholtes && !have_plan_ &&
        !must_stop()) {
      for (int k = 0; k < contacts; ++k) program.set_branch(k, Branch::open);
      state.record.outcome += "fallback to scholtes; ";
      if (solve_treatment(state, program, x, Treatment::scholtes)) return true;
    }
  }
  if (restore(state, program, x)) return true;
  // The solver may have left the side on which the start could have come free.
  x = start;
  return restore(state, program, x);
}

bool Planner::restore(ModeState& state, PoseProgram& program, Eigen::VectorXd& x) {
  if (must_stop() || following_ || !x.allFinite()) return false;
  const double least = state.violation;
  const FeasibilityReport f = steps_.restore(state, program, x);
  if (f.feasible) {
    const OptimalityReport r = solve(state, program, f.x);
    x = usable(r, x) ? r.x : f.x;
    return true;
  }
  keep_nearest(state, program, f, least);
  return false;
}

void Planner::keep_nearest(ModeState& state, const PoseProgram& program, const FeasibilityReport& f, double least) {
  if (state.violation < least) state.nearest = program.shape_of(f.x);
}

bool Planner::nothing_near(ModeState& state, PoseProgram& program, const Eigen::VectorXd& x) {
  const FeasibilityReport f = steps_.restoration(program, x, proving_);
  if (!f.stationary_violation) return false;
  const double least = state.violation;
  ProgramSearch::record_violation(state, program, f);
  keep_nearest(state, program, f, least);
  return true;
}

bool Planner::recover(ModeState& state, PoseProgram& program, Eigen::VectorXd& x) {
  return restore(state, program, x) && sharpen(state, program, x, true);
}

bool Planner::complete(ModeState& state, const std::vector<int>& regions, std::vector<CheckPoint>& every_check,
                       Eigen::VectorXd x, const std::vector<Branch>& branches, Beginning* known) {
  Candidate c;
  if (bring_to_certificate(state, regions, every_check, std::move(x), branches, c, known) == Completion::lost)
    return false;
  // Beside a contact no check point can be: there the rod stays out if the contact does not spread to either side.
  const bool dips =
      c.has_point && !c.certified() && !following_ && !c.program->spec().least_convexity &&
      c.program->layout().arc_lengths > 0 && !must_stop() &&
      (c.certificate.penetration > tolerance::penetration || !(c.certificate.contact_convexity > tolerance::convexity));
  if (dips) {
    struct Held {
      std::optional<double>& limit;
      explicit Held(std::optional<double>& of) : limit(of) { limit = tolerance::held_convexity; }
      ~Held() { limit.reset(); }
      Held(const Held&) = delete;
      Held& operator=(const Held&) = delete;
    };
    const Held held(d_.least_convexity);
    Candidate pointed;
    bring_to_certificate(state, regions, every_check, c.x, branches, pointed);
    if (pointed.certified()) c = std::move(pointed);
  }
  if (!c.has_point) return true;
  state.over_seam = over_seam(c);
  certified_ = c.certified();
  if (certified_) keep_minimum(state, c);
  const bool unstable = !c.certified() && (!(c.certificate.stability > tolerance::stability) ||
                                           !(c.certificate.contact_convexity > tolerance::convexity));
  if (unstable && !c.program->spec().least_margin && c.objective < state.unstable_objective) {
    state.unstable = c.program->shape_of(c.x);
    state.unstable_objective = c.objective;
  }
  if (better(c, state.best)) state.best = std::move(c);
  return true;
}

std::optional<StartShape> Planner::over_seam(const Candidate& c) const {
  if (c.certified() || !(c.certificate.penetration > tolerance::penetration)) return std::nullopt;
  const std::vector<Certifier::Approach> places = c.certifier->approaches(c.x, -tolerance::penetration);
  for (int k = 0; k < c.program->layout().arc_lengths; ++k) {
    const int obstacle = c.program->spec().contacts[static_cast<std::size_t>(k)].obstacle;
    if (d_.obstacles[static_cast<std::size_t>(obstacle)]->convex()) continue;
    const int variable = c.program->arc_length_variable(k);
    const Certifier::Approach* deepest = nullptr;
    for (const Certifier::Approach& place : places) {
      const double s = place.at.arc_length;
      const bool beside = place.obstacle == obstacle && std::abs(s - c.x[variable]) < contact_neighbourhood &&
                          s > c.program->lower()[variable] && s < c.program->upper()[variable];
      if (beside && (deepest == nullptr || place.at.distance < deepest->at.distance)) deepest = &place;
    }
    if (deepest == nullptr) continue;
    StartShape shape = c.program->shape_of(c.x);
    shape.arc_lengths[static_cast<std::size_t>(k)] = deepest->at.arc_length;
    return shape;
  }
  return std::nullopt;
}

/// How a pose program is brought to its certificate.
struct Planner::Completing {
  Planner& planner;
  ModeState& state;
  const std::vector<int>& regions;
  const std::vector<Branch>& branches;
  std::vector<CheckPoint> checks;
  std::vector<CheckPoint>& every_check;
  Candidate& c;
  Beginning* known = nullptr;  ///< as long as x is its own
  int nodes = planner.d_.nodes;

  void build() {
    if (known != nullptr) {
      if (!known->certifier) known->certifier = std::make_shared<Certifier>(*known->program);
      c.program = known->program;
      c.certifier = known->certifier;
      return;
    }
    PoseProgramSpec spec = planner.d_.spec(planner.modes_[static_cast<std::size_t>(state.mode)], regions, nodes);
    spec.checks = checks;
    c.program = std::make_unique<PoseProgram>(spec);
    set_branches(*c.program, branches);
    c.certifier = std::make_unique<Certifier>(*c.program);
  }
  bool sharpen(Eigen::VectorXd& x, bool may) {
    return std::exchange(known, nullptr) != nullptr || planner.sharpen(state, *c.program, x, may);
  }
  bool recover(Eigen::VectorXd& x) { return planner.recover(state, *c.program, x); }
  bool exchange(const Eigen::VectorXd& x, int round) {
    const Task& d = planner.d_;
    if (d.scene.contact.check_points != 0 || d.obstacles.empty()) return false;
    const bool only_add = round >= search_parameters().moving_exchanges;
    if (!exchange_checks(*c.program, x, *c.certifier, checks, violation_level, only_add)) return false;
    every_check.insert(every_check.end(), checks.begin(), checks.end());
    return true;
  }
  void certify(const Eigen::VectorXd& x, const PolishReport* polished) {
    c.certifier->certify(*c.program, x, c.certificate, polished != nullptr ? &polished->multipliers : nullptr,
                         polished != nullptr ? &polished->bound_multipliers : nullptr);
  }
  bool refine() {
    if (nodes > most_nodes) return false;
    nodes += nodes / 2;
    return true;
  }
  bool only_newton() const { return planner.following_; }
};

Completion Planner::bring_to_certificate(ModeState& state, const std::vector<int>& regions,
                                         std::vector<CheckPoint>& every_check, Eigen::VectorXd x,
                                         const std::vector<Branch>& branches, Candidate& c, Beginning* known) {
  Completing steps{*this, state, regions, branches, every_check, every_check, c, known};
  const Completion completion = tendril::bring_to_certificate(steps_, state, c, std::move(x), steps);
  if (completion == Completion::lost) keep_unique(every_check);
  if (completion == Completion::judged && !c.has_point) record_unfit_term(*c.program, c.x);
  return completion;
}

bool Planner::lies_along(Candidate& c, const Eigen::VectorXd& x, int contact) {
  return x[c.program->force_variable(contact)] > tolerance::force &&
         !(c.certifier->contact_convexity(x, contact) > tolerance::convexity);
}

void Planner::look_for_spread() {
  if (d_.palm || !d_.scene.coordinates.split_at_contact) return;
  for (std::size_t i = 0; i < d_.modes.size(); ++i) {
    const Mode& mode = d_.modes[i];
    if (mode.contacts.empty() || !mode.skip.empty() || states_[i].left_out) continue;
    std::vector<int> regions;
    for (const ContactSetup& contact : mode.contacts) regions.push_back(contact.region);
    // From where the violation was least, then from ordinary starts.
    const int first = std::isfinite(states_[i].violation) ? -1 : 0;
    for (int start = first; start < search_parameters().spread_starts && !states_[i].spread.has_point && !must_stop();
         ++start) {
      const PoseProgramSpec spec = d_.spec(mode, regions, d_.nodes);
      Candidate c;
      c.program = std::make_unique<PoseProgram>(spec);
      c.certifier = std::make_unique<Certifier>(*c.program);
      close_contacts(*c.program);
      const StartShape shape = start < 0 ? states_[i].nearest : start_shape(start, mode);
      const FeasibilityReport f = steps_.restoration(*c.program, c.program->start_from(shape));
      if (!f.feasible) continue;
      c.x = f.x;
      if (!sharpen(states_[i], *c.program, c.x, false)) continue;
      bool spreads = false;
      for (int k = 0; k < c.program->layout().forces; ++k) spreads = spreads || lies_along(c, c.x, k);
      c.objective = c.program->cost(c.x);
      if (!spreads || !std::isfinite(c.objective)) continue;
      c.certificate = c.certifier->certify(*c.program, c.x);
      c.solver = states_[i].last;
      c.has_point = true;
      states_[i].spread = std::move(c);
    }
  }
}

void Planner::record_unfit_term(PoseProgram& program, const Eigen::VectorXd& x) {
  program.cost(x);
  for (std::size_t i = 0; i < d_.terms.size(); ++i) {
    if (std::isfinite(program.term_value(static_cast<int>(i)))) continue;
    unfit_ = "objective '" + d_.terms[i].name + "' gives a number that is not finite";
  }
}

}  // namespace tendril
