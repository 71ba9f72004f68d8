#include <algorithm>
#include <array>
#include <cmath>
#include <deque>

#include "certificate/both_fingers.hpp"
#include "certificate/check_points.hpp"
#include "grasp/frames.hpp"
#include "rod/self_overlap.hpp"
#include "scene/plan_report.hpp"
#include "search/completion.hpp"
#include "search/earlier_plan.hpp"
#include "search/parameters.hpp"
#include "search/steps.hpp"
#include "tendril/error.hpp"
#include "tendril/grasp.hpp"

namespace tendril {
namespace {

/// Numbers that steer the search. They decide how a plan is found, never whether it is accepted.

template <class T>
using Both = std::array<T, 2>;  ///< of the upper and the lower finger

/// A grasp of two fingers: for every pair of ways of touching, a program of both. Each contact of a grasp touches and
/// presses, so that no branch has to be decided.
class GraspPlanner {
 public:
  GraspPlanner(Task& upper, const PlanControl& control)
      : fingers_{&upper, upper.lower.get()},
        control_(control),
        steps_(*upper.components.solver, upper.scene.solver, control) {}

  Plan run();

 private:
  using Best = PointOf<GraspProgram, GraspCertifier>;
  struct Pair : Way {
    Both<const Mode*> modes{};
    Best best;
    int violations_before = 0;  ///< stationary ones, before the last start
    const Judged& judged() const override { return best; }
  };
  /// What a program is made of beside its pair of modes.
  struct Assembly {
    Both<int> nodes{};
    Both<std::vector<CheckPoint>> checks;
    std::vector<FingerSeparation> separations;
  };

  const Task& upper() const { return *fingers_[0]; }
  bool must_stop() const { return steps_.must_stop(); }
  double best_objective() const { return winner_ == nullptr ? infinity : winner_->best.objective; }
  std::unique_ptr<GraspProgram> assemble(const Pair& pair, const Assembly& parts) const;
  Both<StartShape> start_shapes(const Pair& pair, int index) const;
  int starts() const { return grasp_starts + 1 + (control_.start != nullptr ? 1 : 0); }
  OptimalityReport solve(Pair& pair, GraspProgram& program, const Eigen::VectorXd& x);
  bool sharpen(Pair& pair, GraspProgram& program, Eigen::VectorXd& x, bool solver_allowed);
  /// From x to a point that violates nothing, if there is one near; remembers where there is none.
  bool restore(Pair& pair, GraspProgram& program, Eigen::VectorXd& x);
  void consider(Pair& pair, const Both<StartShape>& shapes, bool only_promising);
  struct Completing;
  /// Exchange and certificate; keeps the point if it is better than the pair's best.
  void complete(Pair& pair, Assembly parts, Eigen::VectorXd x);
  void search();
  Plan report();
  /// The shape, moments and contacts of one finger, in the world of its own scene.
  Plan finger_plan(int which, Best& best) const;

  Both<Task*> fingers_;
  const PlanControl& control_;
  ProgramSearch steps_;
  std::deque<Pair> pairs_;
  Pair* winner_ = nullptr;
};

std::unique_ptr<GraspProgram> GraspPlanner::assemble(const Pair& pair, const Assembly& parts) const {
  GraspProgramSpec spec;
  for (std::size_t which = 0; which < 2; ++which) {
    const Mode& mode = *pair.modes[which];
    spec.fingers[which] = fingers_[which]->spec(mode, {mode.contacts.front().region}, parts.nodes[which]);
    spec.fingers[which].checks = parts.checks[which];
  }
  const double unit = upper().term_units.length;
  spec.palm_minimum = upper().palm->minimum * unit;
  spec.palm_maximum = upper().palm->maximum * unit;
  const Vec2 load = load_along(upper().scene, upper().scale);
  spec.load = upper().term_units.force * load;
  spec.separations = parts.separations;
  return std::make_unique<GraspProgram>(spec);
}

Both<StartShape> GraspPlanner::start_shapes(const Pair& pair, int index) const {
  Both<StartShape> shapes;
  const Plan* earlier = control_.start;
  for (std::size_t which = 0; which < 2; ++which) {
    const Task& d = *fingers_[which];
    const Mode& mode = *pair.modes[which];
    const int own = earlier != nullptr ? index - 1 : index;
    if (earlier != nullptr && own < 0) {
      const bool apart = earlier->grasp && earlier->grasp->lower;
      const FingerName name = which == 0 ? FingerName::upper : FingerName::lower;
      // What was planned for one mirrored finger is a start of both.
      shapes[which] = shape_of(d, apart ? plan_of_finger(d.scene, *earlier, name) : *earlier, mode);
    } else if (own < grasp_starts) {
      shapes[which] = grasp_start(d, mode, own);
    } else {
      shapes[which] = constant_curvature(d.scene.start_tip_angle);
      shapes[which].forces = {std::isfinite(d.max_force) ? d.max_force : 1.0};
    }
  }
  return shapes;
}

OptimalityReport GraspPlanner::solve(Pair& pair, GraspProgram& program, const Eigen::VectorXd& x) {
  steps_.limit_patience(winner_ != nullptr);
  return steps_.solve(pair, program, x);
}

bool GraspPlanner::sharpen(Pair& pair, GraspProgram& program, Eigen::VectorXd& x, bool solver_allowed) {
  steps_.limit_patience(winner_ != nullptr);
  return steps_.sharpen(pair, program, x, solver_allowed);
}

bool GraspPlanner::restore(Pair& pair, GraspProgram& program, Eigen::VectorXd& x) {
  if (must_stop() || !x.allFinite()) return false;
  const FeasibilityReport f = steps_.restore(pair, program, x);
  if (f.feasible) x = f.x;
  return f.feasible;
}

void GraspPlanner::consider(Pair& pair, const Both<StartShape>& shapes, bool only_promising) {
  if (pair.left_out || !pair.skip.empty() || must_stop()) return;
  const double begin = now();
  // A start that was deferred is looked at twice.
  if (only_promising) pair.violations_before = pair.stationary_violations;
  pair.deferred = false;
  Assembly parts;
  for (std::size_t which = 0; which < 2; ++which) {
    const Task& d = *fingers_[which];
    const Mode& mode = *pair.modes[which];
    parts.nodes[which] = d.nodes;
    parts.checks[which] = d.first_checks(d.spec(mode, {mode.contacts.front().region}, d.nodes), shapes[which]);
  }
  const std::unique_ptr<GraspProgram> program = assemble(pair, parts);
  const Eigen::VectorXd start = program->start_from(shapes[0], shapes[1]);
  Eigen::VectorXd feasible = start;
  // From a start without a feasible point near, a solver takes far the longest, and mostly in vain. It is spent only
  // where nothing else led to a plan.
  const bool near = restore(pair, *program, feasible);
  if (!near && only_promising) {
    pair.deferred = true;
    pair.trouble = "nothing feasible is near its starts, and there is a plan without it";
  } else {
    ++pair.starts_used;
    const OptimalityReport r = solve(pair, *program, start);
    const bool arrived = usable(r, start);
    Eigen::VectorXd x = arrived ? r.x : feasible;
    if (!arrived && near) {
      const OptimalityReport again = solve(pair, *program, feasible);
      if (usable(again, start)) x = again.x;
    }
    if (arrived || near) complete(pair, parts, x);
  }
  // One start is one piece of evidence, however many programs it led to.
  pair.stationary_violations = std::min(pair.stationary_violations, pair.violations_before + 1);
  pair.record.seconds += now() - begin;
  if (pair.best.certified() && pair.best.objective < best_objective() - search_parameters().beats) winner_ = &pair;
}

/// How a program of both fingers is brought to its certificate.
struct GraspPlanner::Completing {
  GraspPlanner& planner;
  Pair& pair;
  Assembly parts;
  Best& c;

  void build() {
    c.program = planner.assemble(pair, parts);
    c.certifier = std::make_unique<GraspCertifier>(*c.program);
  }
  bool sharpen(Eigen::VectorXd& x, bool may) { return planner.sharpen(pair, *c.program, x, may); }
  bool recover(Eigen::VectorXd& x) { return planner.restore(pair, *c.program, x) && sharpen(x, true); }
  /// Moves check points to where the fingers go through something.
  bool exchange(const Eigen::VectorXd& x, int) {
    if (planner.upper().scene.contact.check_points != 0) return false;
    bool changed = false;
    for (int which = 0; which < 2; ++which) {
      const Eigen::VectorXd own = c.program->finger_point(which, x);
      // Unlike the search's program the judge's has no rows for separations: their check points come behind these.
      const bool moved = exchange_checks(c.program->finger(which), own, c.certifier->finger(which),
                                         parts.checks[static_cast<std::size_t>(which)], violation_level);
      changed = changed || moved;
    }
    const FingerClearance between = c.certifier->clearance(x);
    if (between.depth > tolerance::clearance_sharpness) {
      parts.separations.insert(parts.separations.end(), between.crossings.begin(), between.crossings.end());
      changed = changed || !between.crossings.empty();
    }
    return changed;
  }
  void certify(const Eigen::VectorXd& x, const PolishReport* /*polished*/) {
    c.certificate = c.certifier->certify(*c.program, x);
  }
  bool refine() {
    for (int& nodes : parts.nodes) nodes += nodes / 2;
    return true;
  }
  static bool only_newton() { return false; }
};

void GraspPlanner::complete(Pair& pair, Assembly parts, Eigen::VectorXd x) {
  Best c;
  Completing steps{*this, pair, std::move(parts), c};
  if (bring_to_certificate(steps_, pair, c, std::move(x), steps) != Completion::judged) return;
  if (!c.has_point) {
    pair.trouble = "an objective gives a number that is not finite";
  } else if (better(c, pair.best)) {
    pair.best = std::move(c);
  }
}

void GraspPlanner::search() {
  const int earlier = control_.start != nullptr ? 1 : 0;
  for (int round = 0; round < starts() && !must_stop(); ++round) {
    // A grasp comes in families with several valleys of the effort; what follows its own starts is no equilibrium.
    if (winner_ != nullptr && round >= earlier + grasp_starts) break;
    for (Pair& pair : pairs_) consider(pair, start_shapes(pair, round), true);
    for (Pair& pair : pairs_) {
      if (pair.deferred && winner_ == nullptr) consider(pair, start_shapes(pair, round), false);
    }
  }
}

Plan GraspPlanner::finger_plan(int which, Best& best) const {
  const Task& d = *fingers_[static_cast<std::size_t>(which)];
  GraspProgram& finer = best.certifier->finer(best.x);
  const PoseProgram& program = finer.finger(which);
  const Eigen::VectorXd x = finer.finger_point(which, best.x);
  Plan plan;
  plan.coordinates.assign(x.data(), x.data() + program.layout().coordinates);
  for (std::size_t a = 0; a < d.rod.actuators.size(); ++a) {
    const int variable = program.moment_variable(static_cast<int>(a));
    plan.moments.push_back(variable < 0 ? 0.0 : x[variable] * d.scale.moment());
    plan.turns.push_back(program.turn_along(static_cast<int>(a)));
  }
  plan.contacts = planned_contacts(program, d.obstacle_names, d.scale);
  plan.place = place_of(program, x, d.scale);
  plan.backbone = sampled_backbone(program, d.scale.length);
  plan.self_overlap = self_overlap(plan.backbone, d.scene.rod.body());
  finger_to_world(*d.scene.gripper, best.program->palm_distance(best.x) * d.scene_scale.length, plan);
  return plan;
}

Plan GraspPlanner::report() {
  const Task& d = upper();
  Plan plan;
  plan.coordinates_name = d.scene.coordinates.plugin;
  plan.order = d.model->function_count();
  plan.split_at_contact = d.scene.coordinates.split_at_contact;
  plan.left_out = d.left_out;
  plan.solver_name = d.scene.solver.plugin;
  Ways ways;
  for (Pair& pair : pairs_) ways.push_back(&pair);
  tell_outcomes(ways, d.objective_scale, "not tried: stopped before", plan);
  // Without a certified plan the nearest one is reported, for what it is worth.
  Pair* reported = winner_ != nullptr ? winner_ : static_cast<Pair*>(nearest_way(ways));
  Grounds grounds;
  grounds.search = &steps_;
  grounds.time_limit = d.scene.solver.time_limit;
  grounds.solved = winner_ != nullptr;
  grounds.grasp = true;
  grounds.chosen = reported == nullptr ? nullptr : &reported->best;
  grounds.unit = "pair of contacts";
  judge(ways, grounds, plan);
  if (reported == nullptr) return plan;

  Best& best = reported->best;
  best.program->cost(best.x);
  plan.certificate = best.certificate;
  plan.objective = best.objective * d.objective_scale;
  for (std::size_t i = 0; i < d.terms.size(); ++i) {
    const int term = static_cast<int>(i);
    const double value = best.program->finger(0).term_value(term) + best.program->finger(1).term_value(term);
    plan.terms.emplace_back(d.terms[i].name, value * d.objective_scale);
  }
  set_finger(plan, finger_state(finger_plan(0, best)));
  const FingerPlan below = lower_in_world(d.scene, finger_plan(1, best));
  plan.grasp =
      grasp_of(d.scene, best.program->palm_distance(best.x) * d.scene_scale.length, plan.contacts, below.contacts);
  GraspQuality& quality = plan.grasp->quality.emplace();
  for (int which = 0; which < 2; ++which) {
    const Task& own = *fingers_[static_cast<std::size_t>(which)];
    const FingerResponse response =
        finger_response(best.program->finger(which), best.program->finger_point(which, best.x), own.scale);
    add_finger(quality, which == 0 ? FingerName::upper : FingerName::lower, response,
               which == 0 ? plan.contacts : below.contacts, own.scene.contact.max_force);
  }
  plan.grasp->lower = below;
  return plan;
}

Plan GraspPlanner::run() {
  for (const Mode& above : fingers_[0]->modes) {
    for (const Mode& below : fingers_[1]->modes) {
      Pair pair;
      pair.modes = {&above, &below};
      pair.record.mode = pair_name(above, below);
      if (!above.skip.empty() || !below.skip.empty())
        pair.skip = above.skip.empty() ? "lower finger: " + below.skip : "upper finger: " + above.skip;
      const auto reach = [](const Task& d, const Mode& mode) {
        const ContactSetup& c = mode.contacts.front();
        const double end = c.at_tip ? 1.0 : d.rod.fixed_knots()[static_cast<std::size_t>(c.region) + 1];
        return end * d.scale.length;
      };
      if (pair.skip.empty())
        pair.skip = pair_obstruction(upper(), reach(*fingers_[0], above), reach(*fingers_[1], below));
      pairs_.push_back(std::move(pair));
    }
  }
  const auto excluded = [&](const Pair& pair) {
    return std::find(control_.without.begin(), control_.without.end(), pair.record.mode) != control_.without.end();
  };
  for (Pair& pair : pairs_) {
    pair.left_out = excluded(pair);
    if (pair.left_out) pair.record.outcome = left_out_outcome;
  }
  search();
  return report();
}

}  // namespace

Plan plan_both_fingers(Task& upper, const PlanControl& control) { return GraspPlanner(upper, control).run(); }

}  // namespace tendril
