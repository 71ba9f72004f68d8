#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "certificate/check_points.hpp"
#include "nlp/multipliers.hpp"
#include "program/reduced_program.hpp"
#include "search/contacts.hpp"
#include "search/parameters.hpp"
#include "search/planner.hpp"
#include "search/sides.hpp"
#include "search/task.hpp"
#include "statics/loading.hpp"
#include "tendril/error.hpp"

namespace tendril {
namespace {

/// Numbers that steer the search. They decide how a plan is found, never whether it is accepted.
constexpr double shares_of_bend[] = {0.9, 0.75, 0.6, 0.5,
                                     0.4, 0.25, 0.1};  ///< of a rest that coordinates cannot follow

/// Whether the rod passes every obstacle on the same side in two shapes.
bool stays_beside(const Sides& before, const Sides& after) {
  return std::equal(before.begin(), before.end(), after.begin(), [](int a, int b) { return a * b >= 0; });
}

}  // namespace

std::optional<Rest> Planner::executed(const std::vector<double>& moments, int looks) {
  constexpr int fewest_coordinates = 48;  // of the executor
  CountedLooks allowance(steps_.tally, steps_.deadline(), looks, std::max(fewest_coordinates, d_.coordinate_count({})));
  const auto stop = [&allowance] { return allowance.spent(); };
  // A start through the middle of an obstacle leads nowhere: the rod is bent out of the way.
  for (const double bent : {0.0, 1.0, -1.0, 2.0, -2.0}) {
    Loading loading(d_.rod, d_.obstacles, d_.scene.start_tip_angle + bent, {moments, d_.rod.starts()}, stop);
    if (loading.without_side()) continue;
    const bool arrived = loading.run();
    if (!arrived && allowance.spent()) return std::nullopt;
    Settled& end = loading.tracker().current();
    if (end.statics == nullptr) return std::nullopt;
    if (arrived) loading.tracker().refine_fully();
    const State state = end.statics->state(end.z);
    const auto lying = arrived ? std::nullopt : loading.lie();
    return lying ? rest_of(d_, moments, lying->down.state) : rest_of(d_, moments, state);
  }
  return std::nullopt;
}

std::optional<Rest> Planner::come_to_rest(const std::vector<double>& moments, const StartShape& from) {
  const int looks = search_parameters().looks_at_a_rest;
  const int coordinates = d_.coordinate_count({});
  if (coordinates > search_parameters().few_values) return executed(moments, looks);
  CountedLooks allowance(steps_.tally, steps_.deadline(), looks, coordinates);
  const std::vector<double> moves = d_.rod.starts();
  const LoadPath path(d_.rod, d_.obstacles, {moments, moments, false, false, moves, moves});
  const Descent down =
      descend_in(*d_.components.coordinates, path, 1.0, from.curvature, [&allowance] { return allowance.spent(); });
  return down.converged ? settled(down, moments) : std::nullopt;
}

std::optional<Rest> Planner::settled(const Descent& down, const std::vector<double>& moments) const {
  Rest rest{down.state.curvature, moments, {}, d_.rod.starts()};
  for (PointContact c : down.state.contacts) {
    // Held between obstacles that leave no room it rests nowhere.
    if (c.force > search_parameters().deepest * down.stiffness) return std::nullopt;
    if (c.setup.at_tip) c.s = 1.0;
    c.setup.region = c.setup.at_tip ? 0 : stretch_at(d_.rod, c.s);
    rest.contacts.push_back(c);
  }
  sort_contacts(rest.contacts);
  return rest;
}

std::optional<std::vector<ContactSetup>> Planner::contacts_of_rest(const Rest& rest) const {
  if (static_cast<int>(rest.contacts.size()) > (d_.contact_planned() ? d_.scene.contact.count : 0)) return std::nullopt;
  if (rest.contacts.empty() && d_.min_force > 0.0) return std::nullopt;
  std::vector<ContactSetup> contacts;
  contacts.reserve(rest.contacts.size());
  for (const PointContact& c : rest.contacts) contacts.push_back(c.setup);
  return contacts;
}

void Planner::solve_reduced(ModeState& state, PoseProgram& program, Eigen::VectorXd& x) {
  if (must_stop() || !ReducedProgram::applies(program)) return;
  ReducedProgram reduced(program, x);
  const OptimalityReport r = solve(state, reduced, reduced.start());
  if (r.x.size() != reduced.start().size() || !r.x.allFinite()) return;
  if (const Eigen::VectorXd& reached = reduced.full(r.x); reached.allFinite()) x = reached;
}

bool Planner::solved_reduced(const Mode& mode) const {
  return search_parameters().reduce_large && !d_.palm && d_.coordinate_count(mode) > search_parameters().many_values;
}

bool Planner::come_to_point(ModeState& state, PoseProgram& program, Eigen::VectorXd& x) {
  close_contacts(program);
  const double least = state.violation;
  const FeasibilityReport f = steps_.restore(state, program, x);
  if (!f.feasible) {
    keep_nearest(state, program, f, least);
    return false;
  }
  x = f.x;
  solve_reduced(state, program, x);
  return true;
}

std::vector<int> Planner::regions_near(const Mode& mode, const StartShape& shape) const {
  std::vector<double> places = shape.arc_lengths;
  if (!d_.scene.coordinates.split_at_contact && places.empty() && !mode.contacts.empty()) {
    // With stretches for regions, only to place the contacts where the shape comes nearest.
    std::vector<int> stretches;
    for (const ContactSetup& c : mode.contacts) stretches.push_back(c.region);
    PoseProgramSpec whole = d_.spec(mode, stretches, d_.nodes);
    whole.split = true;
    const PoseProgram placer(whole);
    const Eigen::VectorXd placed = placer.start_from(shape);
    for (std::size_t k = 0; k < mode.contacts.size(); ++k) {
      const int variable = placer.arc_length_variable(static_cast<int>(k));
      places.push_back(variable >= 0 ? placed[variable] : 1.0);
    }
  }
  return d_.regions_of(mode, places);
}

FeasibilityReport Planner::feasible_near(PoseProgram& program, const StartShape& shape, const Eigen::VectorXd& start,
                                         bool rests) {
  FeasibilityReport f = steps_.restoration(program, start);
  // What few coordinates leave of a sharp bend can lie on the wrong side of all that is near: less of it may do.
  for (const double share : shares_of_bend) {
    if (f.feasible || must_stop() || !rests) break;
    StartShape less = shape;
    less.curvature = [&shape, share](double s) { return share * shape.curvature(s); };
    const FeasibilityReport again = steps_.restoration(program, program.start_from(less));
    if (again.feasible) f = again;
  }
  return f;
}

PoseProgramSpec Planner::spec_without_margins(const Mode& mode, const std::vector<int>& regions) const {
  PoseProgramSpec spec = d_.spec(mode, regions, d_.nodes);
  // Rows that hold a plan back are for the way to better moments.
  spec.least_margin.reset();
  spec.least_convexity.reset();
  return spec;
}

Beginning Planner::begin(const Mode& mode, const StartShape& shape, bool rests) {
  Beginning from;
  from.contacts = mode.contacts;
  from.regions = regions_near(mode, shape);
  PoseProgramSpec spec = spec_without_margins(mode, from.regions);
  // Check points change no variable.
  const PoseProgram bare(Equations::alone(spec));
  const Eigen::VectorXd start = bare.start_from(shape);
  from.checks = spec.checks = d_.first_checks(bare, start, shape);
  from.program = std::make_shared<PoseProgram>(spec);
  close_contacts(*from.program);
  const double before = steps_.tally.work;
  from.near = feasible_near(*from.program, shape, start, rests);
  from.work = steps_.tally.work - before;
  return from;
}

std::shared_ptr<Beginning> Planner::beginning_at(const Mode& mode, const SideStart& start) {
  // A target with tolerances has rows, and a palm changes with what is held.
  const bool kept = !d_.tolerance.any() && !d_.palm;
  for (const std::shared_ptr<Beginning>& known : d_.beginnings) {
    if (!kept || known->number != start.number || !same_contacts(known->contacts, mode.contacts)) continue;
    // Whatever else changed, as friction without which the same rod is planned first: it has to be the same program.
    PoseProgramSpec wanted = spec_without_margins(mode, known->regions);
    wanted.checks = known->checks;
    wanted.target = known->program->spec().target;
    if (!(known->program->spec() == wanted)) continue;
    known->program->set_target(d_.target);
    if (known->certifier) known->certifier->set_target(d_.target);
    steps_.tally.work += known->work;
    return known;
  }
  auto made = std::make_shared<Beginning>(begin(mode, start.shape, false));
  made->number = start.number;
  if (kept && !must_stop()) d_.beginnings.push_back(made);
  return made;
}

bool Planner::descend(ModeState& state, PoseProgram& program, Eigen::VectorXd& x) {
  if (!search_parameters().descend || d_.palm || must_stop() || !steps_.descend(state, program, x)) return false;
  if (d_.solver_works) return true;
  // One that breaks its promises is no part of any plan. What it ends at here is not used: plans would depend on which
  // of them came first.
  const double work = steps_.tally.work;
  OptimalityReport newton = state.last;
  newton.native_status = "asked once, only to see that it works: Newton's method converged from a feasible point";
  d_.solver_works = !is_useless(solve(state, program, x));
  steps_.tally.work = work;
  if (d_.solver_works) state.last = std::move(newton);
  return d_.solver_works && !must_stop();
}

double Planner::refine(ModeState& state, const StartShape& shape, bool rests) {
  Beginning from = begin(modes_[static_cast<std::size_t>(state.mode)], shape, rests);
  return refine(state, from);
}

double Planner::refine(ModeState& state, Beginning& from) {
  const Mode& mode = modes_[static_cast<std::size_t>(state.mode)];
  ++state.starts_used;
  PoseProgram& program = *from.program;
  if (!from.near.feasible) {
    const double least = state.violation;
    ProgramSearch::record_violation(state, program, from.near);
    keep_nearest(state, program, from.near, least);
    return infinity;
  }
  const std::vector<int>& regions = from.regions;
  const Eigen::VectorXd& feasible = from.near.x;
  const double cost = program.cost(feasible);
  std::vector<CheckPoint> checks = from.checks;
  // On its way a backend may pass through an obstacle, or end where it costs more. The plan that it finds then says
  // nothing about where it began.
  const auto stays = [&](PoseProgram& held, const Eigen::VectorXd& x) {
    if (!from.sides) from.sides = sides_of(d_, program.shape_of(feasible));
    const bool left = held.cost(x) > cost + search_parameters().dearer;
    if (d_.palm) return true;
    return !left && stays_beside(*from.sides, state.sides.empty() ? sides_of(d_, held.shape_of(x)) : state.sides);
  };
  const bool holds_back = d_.least_margin || d_.least_convexity;
  if (Eigen::VectorXd x = feasible; !holds_back && !solved_reduced(mode) && descend(state, program, x)) {
    state.over_seam.reset();
    if (finish(state, program, regions, checks, x, &from) && stays(program, x)) return cost;
    // Over the seams of a body that is not convex.
    for (int seams = 0; seams < search_parameters().most_seams && state.over_seam && !must_stop(); ++seams) {
      Beginning beside = begin(mode, *std::exchange(state.over_seam, {}), false);
      if (!beside.near.feasible) break;
      x = beside.near.x;
      if (!descend(state, *beside.program, x)) break;
      if (finish(state, *beside.program, beside.regions, beside.checks, x, &beside) && stays(*beside.program, x))
        return cost;
    }
  }
  PoseProgramSpec spec = d_.spec(mode, regions, d_.nodes);
  spec.checks = checks = from.checks;
  if (!solved_reduced(mode)) {
    std::optional<PoseProgram> with_margins;
    if (holds_back) close_contacts(with_margins.emplace(spec));
    PoseProgram& held = with_margins ? *with_margins : program;
    FeasibilityReport f;
    if (spec.least_margin) f = steps_.restoration(held, feasible);
    const OptimalityReport r = solve(state, held, f.feasible ? f.x : feasible);
    // What breaks its promises is no part of any plan.
    if (is_useless(r) || r.x.size() != feasible.size()) return cost;
    const bool done = usable(r, feasible) && finish(state, held, regions, checks, r.x);
    if (done && stays(held, r.x)) return cost;
  }
  // What the backend cannot do with all variables it may do with the moments alone.
  Eigen::VectorXd x = feasible;
  for (int round = 0; round <= search_parameters().exchanges_along && !must_stop(); ++round) {
    // All rounds before have added theirs, and every one is a row.
    spec.checks = checks;
    keep_unique(spec.checks);
    PoseProgram along(spec);
    if (!come_to_point(state, along, x)) return cost;
    // Where the way to better moments went through an obstacle, it is watched there, and begins anew.
    Certifier certifier(along);
    std::vector<CheckPoint> more = checks;
    const bool through = !d_.obstacles.empty() && d_.scene.contact.check_points == 0 &&
                         round < search_parameters().exchanges_along &&
                         exchange_checks(along, x, certifier, more, violation_level, true);
    if (!through) {
      const double reached = along.cost(x);
      if (!finish(state, along, regions, checks, x) && std::isfinite(state.unstable_objective) && !spec.least_margin) {
        // Equilibria were stable up to here: a plan that is held at the limit is near.
        state.unstable = along.shape_of(x);
        state.unstable_objective = reached;
      }
      return cost;
    }
    checks = std::move(more);
  }
  return cost;
}

bool Planner::finish(ModeState& state, PoseProgram& program, const std::vector<int>& regions,
                     std::vector<CheckPoint>& checks, const Eigen::VectorXd& x, Beginning* known) {
  state.sides.clear();
  // Clearance that is still to be added makes nothing cheaper.
  const double cost = program.cost(x);
  if (have_plan_ && d_.enumerated && cost > best_objective() + search_parameters().dearer &&
      infeasibility(program, x) <= restored) {
    state.dearer = std::min(state.dearer, cost);
    return true;
  }
  certified_ = false;
  complete(state, regions, checks, x, branches_of(program), known);
  return certified_;
}

double Planner::consider_rest(const Rest& rest) {
  const auto contacts = contacts_of_rest(rest);
  if (!contacts) return infinity;
  const std::size_t i = state_of(*contacts);
  double feasible = infinity;
  const auto refined = [&] { feasible = std::min(feasible, refine(states_[i], shape_of(rest, modes_[i]), true)); };
  // From a stable shape the plan is wanted that is still stable, and the way there ends where stability does.
  // Eigenvalues of many coordinates take long: there they are looked at only where the way led too far.
  if (d_.coordinate_count({}) > search_parameters().many_values) {
    consider(states_[i], refined);
    if (states_[i].best.certified() || must_stop()) return feasible;
  }
  const HeldStable held(d_);
  consider(states_[i], refined);
  return feasible;
}

bool Planner::rest_is_due(const Mode& mode) {
  if (!search_parameters().ask_rests || rested_ || d_.palm || have_plan_ || following_ || must_stop() ||
      !mode.skip.empty())
    return false;
  values_tried_ += d_.coordinate_count({});
  return values_tried_ > search_parameters().many_values;
}

const Backbone& Planner::backbone_of_best() const {
  const Candidate& best = states_[static_cast<std::size_t>(winner_)].best;
  best.program->constraints(best.x);
  return best.program->backbone();
}

bool Planner::misses_among_sides() const {
  const bool sided = std::find(d_.pocketed.begin(), d_.pocketed.end(), true) != d_.pocketed.end();
  if (!sided || d_.palm || winner_ < 0 || !d_.target.has_position || !(d_.least_cost(1.0) > d_.least_cost()))
    return false;
  const double out_of_reach = std::max(0.0, norm(d_.target.position - d_.rod.base) - 1.0);
  return norm(backbone_of_best().tip() - d_.target.position) > out_of_reach + search_parameters().missed;
}

void Planner::start_from_rests() {
  rested_ = true;
  const bool missed = misses_among_sides();
  std::vector<StartShape> from{d_.scene_start()};
  if (loaded()) from.insert(from.end(), {hanging(false), hanging(true)});
  const std::vector<std::vector<double>> samples = sampled_moments();
  // Where there is a plan, no more than sides are worth.
  const double worth = missed ? search_parameters().side_work : search_parameters().sampling_work;
  const double most_work = steps_.tally.work + generosity() * worth;
  std::size_t enough = samples.size();
  int useless = 0;
  bool has_plan = have_plan_;
  for (std::size_t i = 0; i < enough; ++i) {
    for (const StartShape& shape : from) {
      if (must_stop() || steps_.tally.work > most_work) return;
      const std::optional<Rest> rest = come_to_rest(samples[i], shape);
      // No contact where one is asked for, or more of them than there may be: such rests say little.
      useless = rest && contacts_of_rest(*rest) ? 0 : useless + 1;
      if (useless > search_parameters().useless_rests) return;
      if (rest) consider_rest(*rest);
      if (missed && !misses_among_sides()) return;
      // The first plan is seldom the best: as many samples as led to it may follow.
      if (have_plan_ && !has_plan && !thorough()) enough = std::min(enough, 2 * (i + 1));
      has_plan = have_plan_;
      if (i > 0) break;
    }
  }
}

}  // namespace tendril
