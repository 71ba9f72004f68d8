#include "tendril/problem.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "base/clock.hpp"
#include "grasp/force_limit.hpp"
#include "grasp/frames.hpp"
#include "grasp/hold.hpp"
#include "problem/calibrated_range.hpp"
#include "problem/friction.hpp"
#include "problem/uncertainties.hpp"
#include "scene/make_rod.hpp"
#include "scene/plan_report.hpp"
#include "search/blame.hpp"
#include "search/contacts.hpp"
#include "search/either_way.hpp"
#include "search/follower.hpp"
#include "search/friction.hpp"
#include "search/limit.hpp"
#include "search/parameters.hpp"
#include "search/report.hpp"
#include "search/rubbing.hpp"
#include "search/sides.hpp"
#include "search/task.hpp"
#include "tendril/grasp.hpp"

namespace tendril {
namespace {

void take_obstacles(Task& d, const Scene& scene) {
  if (d.components.obstacles.size() != scene.obstacles.size()) throw Error("one shape per obstacle is needed");
  for (const std::unique_ptr<Obstacle>& obstacle : d.components.obstacles) {
    d.obstacles.push_back(obstacle.get());
    d.pocketed.push_back(has_pockets(*obstacle, d.rod.base));
  }
  require_free_base(scene, d.rod, d.obstacles, d.scale);
}

/// An objective reads nothing that the scene has not; finds what is only asked for here.
void require_quantities(Task& d, const Scene& scene, std::size_t i) {
  const std::string path = "objective[" + std::to_string(i) + "].plugin";
  const std::string name = "objective '" + scene.objectives[i].plugin + "' needs ";
  const Reads reads = d.components.terms[i]->reads();
  if (reads.target && !d.target.has_position && !d.target.has_angle) {
    throw SceneError(path, name + "a [target], but the scene has none");
  }
  if (reads.any_contact() && !d.contact_planned()) {
    throw SceneError(path, name + "a contact, but this scene plans none (contact mode \"" +
                               std::string(to_string(scene.contact.mode)) + "\", " +
                               std::to_string(scene.obstacles.size()) + " obstacles)");
  }
  if (d.rod.draws() && std::any_of(reads.samples.begin(), reads.samples.end(),
                                   [&](double s) { return s <= d.rod.moves.back().maximum; })) {
    throw SceneError(path, name + "a place along the rod that may be inside its port, expected a larger arc length");
  }
  if (reads.palm_distance && !d.palm) throw SceneError(path, name + "a palm, but a pose has none");
  if (reads.tip_deviations && !d.uncertainties) d.uncertainties = uncertainties_of(d, path, name);
  const auto is_tendon = [](const Rod::Actuator& a) { return a.offset != 0.0; };
  if ((reads.tensions || reads.shortenings) &&
      std::none_of(d.rod.actuators.begin(), d.rod.actuators.end(), is_tendon)) {
    throw SceneError(path, name + "a tendon, but the rod has none (kind = \"tendon\" in [[rod.actuator]])");
  }
  const std::vector<ActuatorSpec>& specs = scene.rod.actuators;
  if (reads.tensions && std::any_of(specs.begin(), specs.end(), [](const ActuatorSpec& a) {
        return a.kind == ActuatorKind::tendon && a.has_law();
      })) {
    throw SceneError(path,
                     name + "tensions, but a tendon has 'moment_per_tension', expected a term that reads moments");
  }
}

void take_terms(Task& d, const Scene& scene) {
  std::map<std::string, int> seen;
  bool reads_moments = false;
  double largest_weight = 0.0;
  for (std::size_t i = 0; i < scene.objectives.size(); ++i) {
    const ObjectiveSpec& objective = scene.objectives[i];
    if (!needs_term(objective)) {
      d.left_out.push_back({"objective " + objective.plugin, "its weight is 0"});
      continue;
    }
    if (!d.components.terms[i]) throw Error("the term of objective '" + objective.plugin + "' is missing");
    require_quantities(d, scene, i);
    const int count = ++seen[objective.plugin];
    PoseProgramTerm term{d.components.terms[i].get(), objective.weight, objective.plugin,
                         std::make_shared<std::string>()};
    if (count > 1) term.name += "#" + std::to_string(count);
    const Reads reads = term.term->reads();
    reads_moments = reads_moments || reads.moments || reads.tensions;
    largest_weight = std::max(largest_weight, objective.weight);
    d.terms.push_back(term);
  }
  if (d.palm && !reads_moments) {
    throw SceneError("objective",
                     "a grasp needs an objective that weighs the moments: with the contact "
                     "force at its limit and no force along the axis there is still a whole family of grasps");
  }
  // Only ratios of weights mean anything: the largest is 1, however small or large all of them are.
  if (largest_weight > 0.0) d.objective_scale = largest_weight;
  for (PoseProgramTerm& t : d.terms) t.weight /= d.objective_scale;
}

/// What no program of this task has, with the reason.
void tell_left_out(Task& d, const Scene& scene) {
  const auto leave = [&d](const std::string& what, const std::string& why) { d.left_out.push_back({what, why}); };
  if (!scene.gravity) {
    leave("gravity term", "the scene has no gravity");
  } else if (!d.rod.has_gravity()) {
    leave("gravity term", "neither the rod nor the tip has mass, or gravity is zero");
  }
  if (d.rod.payload == 0.0) leave("payload", "no tip mass is given");
  if (!d.rod.has_tip_force()) leave("tip force", "none is given");
  for (std::size_t a = 0; a < d.rod.actuators.size(); ++a) {
    if (d.rod.actuators[a].fixed_at_zero()) leave("moment of actuator " + std::to_string(a + 1), "its limit is 0");
  }
  if (d.rod.actuators.empty()) leave("moments", "the rod has no actuator");
  const bool ignored = scene.contact.mode == ContactModeName::ignore;
  if (d.scene.obstacles.empty() || ignored) {
    const char* why = d.scene.obstacles.empty() ? "the scene has no obstacle" : "contact mode \"ignore\"";
    leave("check points", why);
    leave("contact variables and rows", why);
  } else if (!d.contact_planned()) {
    leave("contact variables and rows",
          scene.contact.mode == ContactModeName::avoid ? "contact mode \"avoid\"" : "max_force is 0");
  }
  if (scene.contact.min_force > 0.0 && scene.contact.mode != ContactModeName::require) {
    leave("least contact force", "only contact mode \"require\" asks for it");
  }
  if (!d.palm) {
    leave("palm distance", "a pose has no palm");
    return;
  }
  if (d.palm->minimum == d.palm->maximum) leave("palm distance", "it is fixed");
  if (!d.palm->balance) leave("force balance as a row", "the scene leaves it to an objective");
  if (!plans_both_fingers(scene)) leave("the lower finger", "it is the mirror image of the upper one");
  leave("complementarity of the contacts", "a grasp holds its object: every contact touches");
}

/// The small programs, one per way of being in contact.
void make_modes(Task& d) {
  if (d.scene.contact.mode != ContactModeName::require || !d.contact_planned()) {
    Mode none{(d.obstacles.empty() ? "free" : "no contact") + d.port_name(), {}, ""};
    for (const PoseProgramTerm& t : d.terms) {
      const Reads reads = t.term->reads();
      if (!(reads.contact_point || reads.contact_gap || reads.contact_normal || reads.contact_arc_length)) continue;
      none.skip = "objective '" + t.name + "' reads the contact point, which this mode has not";
    }
    d.modes.push_back(std::move(none));
  }
  if (!d.contact_planned()) return;
  const int count = d.scene.contact.count;
  const auto stretches = static_cast<int>(d.rod.fixed_knots().size()) - 1;
  const std::vector<ContactSetup> slots = contact_slots(stretches, d.contact_obstacles);
  const auto few = every_assignment(d, slots, count, search_parameters().most_enumerated);
  d.enumerated = few.has_value() || count == 1;
  for (const std::vector<ContactSetup>& contacts : few ? *few : *every_assignment(d, slots, 1, slots.size())) {
    d.modes.push_back(d.mode(contacts));
  }
  if (!d.enumerated) d.left_out.push_back(search_note(d));
  const auto convex = [](const Obstacle* o) { return o->convex(); };
  if (count > 1 && std::any_of(d.obstacles.begin(), d.obstacles.end(), convex)) {
    d.left_out.push_back(
        {"two contacts inside the rod with one convex obstacle",
         "within one segment only one is planned; a second one may be at the tip or on another segment"});
  }
}

/// The window that holds a port, or the one nearest to it.
const Rod& window_of(const Task& d, double port) {
  const auto away = [port](const Rod& window) {
    const Rod::Move& draw = window.moves.back();
    return std::max({draw.minimum - port, port - draw.maximum, 0.0});
  };
  return *std::min_element(d.windows.begin(), d.windows.end(),
                           [&](const Rod& a, const Rod& b) { return away(a) < away(b); });
}

/// The same of a plan; where it says nothing, of where searches begin.
const Rod& window_of(const Task& d, const Plan* plan) {
  const bool told = plan != nullptr && plan->place.insertion;
  return window_of(d, told ? 1.0 - *plan->place.insertion / d.scale.length
                           : d.scale.to_dimensionless(d.scene.rod.drawn_in, dimension::length));
}

/// Makes the task that of a rod whose port is in this stretch.
void enter(Task& d, const Rod& window) {
  if (window.hidden == d.rod.hidden) return;
  d.take_rod(window);
  const std::vector<LeftOut> told = d.left_out;
  make_modes(d);
  d.left_out = told;
}

/// Whether the port of a plan is where its window ends and the next one begins.
bool at_next_window(const Task& d, const Plan& plan) {
  if (d.windows.size() < 2 || !plan.place.insertion) return false;
  const double port = 1.0 - *plan.place.insertion / d.scale.length;
  const Rod::Move& own = d.rod.moves.back();
  const auto ends = [&](double end, double last) { return end != last && std::abs(port - end) <= before_knot; };
  return ends(own.minimum, d.windows.front().moves.back().minimum) ||
         ends(own.maximum, d.windows.back().moves.back().maximum);
}

Plan plan_pose(Task& task, const PlanControl& control) {
  const auto search = [&task](const PlanControl& own) { return plan_to_target(task, own); };
  if (task.friction.empty()) return search(control);
  const bool worst = task.scene.contact.friction_state == FrictionState::worst;
  return worst ? plan_worst(task, control, search) : plan_any(task, control, search);
}

/// A search for each stretch of the rod that the port may be in.
Plan plan_windows(Task& d, const PlanControl& control) {
  if (d.windows.size() < 2) return plan_pose(d, control);
  Limit limit(d);
  std::vector<const Rod*> order{&window_of(d, control.start)};
  for (const Rod& window : d.windows) {
    if (&window != order.front()) order.push_back(&window);
  }
  Plan best;
  const Rod* chosen = order.front();
  std::vector<ModeRecord> modes;
  for (const Rod* window : order) {
    if (window != order.front() && !limit.leaves_time()) {
      best.search_cut = true;
      break;
    }
    enter(d, *window);
    Plan next = plan_pose(d, control);
    modes.insert(modes.end(), next.modes.begin(), next.modes.end());
    // What is proven of one stretch is not of all.
    const bool solved = next.status == PlanStatus::solved;
    const bool better = best.status == PlanStatus::solved ? solved && next.objective < best.objective
                                                          : solved || best.status == PlanStatus::infeasible;
    if (window == order.front() || better) {
      std::swap(best, next);
      chosen = window;
    }
    if (window != order.front()) {
      best.evaluations += next.evaluations;
      best.seconds_certify += next.seconds_certify;
      best.search_cut = best.search_cut || next.search_cut;
    }
    if (best.status == PlanStatus::interrupted || next.status == PlanStatus::interrupted) break;
  }
  enter(d, *chosen);
  best.modes = std::move(modes);
  return best;
}

/// What is known of a plan beside itself: what friction has to do with it, and whether its rod was calibrated with
/// that.
void tell_more(const Task& task, Plan& plan, const std::atomic<bool>* stop) {
  const FingerPlan* lower = task.lower && plan.grasp && plan.grasp->lower ? &*plan.grasp->lower : nullptr;
  const auto base_angle = [](const Scene& scene, const RodPlace& place) {
    return place.base ? place_on_palm(scene, place).base->angle : scene.rod.base_angle;
  };
  tell_beyond_calibration(task.scene, plan.moments, plan.turns, base_angle(task.scene, plan.place),
                          lower != nullptr ? "upper finger: " : "", plan.notes);
  if (lower != nullptr) {
    const RodPlace own = plan_of_finger(task.lower->scene, plan, FingerName::lower).place;
    tell_beyond_calibration(task.lower->scene, lower->moments, lower->turns, base_angle(task.lower->scene, own),
                            "lower finger: ", plan.notes);
  }
  judge_cones(task.scene, task.scale.force(), plan);
  find_friction_range(task, plan, stop);
  if (task.palm) tell_hold(task, plan);
}

}  // namespace

Problem::Problem(Problem&&) noexcept = default;
Problem& Problem::operator=(Problem&&) noexcept = default;
Problem::~Problem() = default;
void Problem::set_target(const TargetSpec& target) {
  Task& d = *task_;
  const bool read =
      std::any_of(d.terms.begin(), d.terms.end(), [](const PoseProgramTerm& t) { return t.term->reads().target; });
  if (read && !target.position && !target.angle) throw SceneError("target", "an objective needs a target");
  d.take_target(target);
}

Problem::Problem(const Scene& scene, Components components) : task_(std::make_unique<Task>()) {
  const double begin = now();
  Task& d = *task_;
  validate(scene);
  const bool grasp = scene.problem == ProblemKind::grasp;
  if (scene.problem != ProblemKind::pose && scene.problem != ProblemKind::trajectory && !grasp) {
    throw SceneError("problem", "problem \"" + std::string(to_string(scene.problem)) +
                                    "\" cannot be planned here, expected \"pose\", \"trajectory\" or \"grasp\"" +
                                    (scene.problem == ProblemKind::execute ? ", or the command 'execute'" : ""));
  }
  const bool both = grasp && plans_both_fingers(scene);
  d.scene = !grasp ? scene : finger_in_palm_frame(both ? finger_of(scene, FingerName::upper) : scene);
  d.components = std::move(components);
  d.model = d.components.coordinates.get();
  d.scale = scale_of(d.scene);
  d.scene_scale = scale_of(scene);
  d.term_units = {d.scale.length / d.scene_scale.length, d.scale.force() / d.scene_scale.force()};
  d.rod = make_rod(d.scene, d.scale);
  if (!d.components.coordinates) throw Error("a problem needs a coordinate model");
  if (!d.components.solver) throw Error("a problem needs a solver");
  if (d.components.terms.size() != scene.objectives.size()) throw Error("one term per objective is needed");
  d.obstacle_names = obstacle_names(d.scene);
  if (needs_obstacles(scene)) take_obstacles(d, scene);
  d.contact_obstacles = static_cast<int>(d.obstacles.size());
  d.max_force = d.scale.to_dimensionless(d.scene.contact.max_force, dimension::force);
  d.min_force = scene.contact.mode == ContactModeName::require
                    ? d.scale.to_dimensionless(scene.contact.min_force, dimension::force)
                    : 0.0;
  if (grasp) set_up_grasp(d);
  const FrictionState state = d.scene.contact.friction_state;
  if (!grasp && (state == FrictionState::any || state == FrictionState::worst))
    d.friction = coefficients_of_friction(d);
  d.take_start();
  d.take_target(scene.problem == ProblemKind::trajectory ? scene.trajectory.targets.front() : scene.target);
  d.tolerance = {d.scale.to_dimensionless(scene.target.position_tolerance, dimension::length),
                 scene.target.angle_tolerance};
  take_terms(d, scene);
  tell_left_out(d, scene);
  d.windows = port_windows(d.rod);
  if (d.rod.draws()) d.rod = window_of(d, nullptr);
  if (d.windows.size() > 1) {
    d.left_out.push_back({"programs of a port in another segment",
                          "not described, but tried by a plan: one for each stretch that the port may be in"});
  }
  make_modes(d);
  require_independent_functions(d);
  d.nodes = d.first_nodes();
  if (both) add_lower_finger(d, scene);
  d.seconds_assemble = now() - begin;
}

Description Problem::describe() const {
  const Task& d = *task_;
  Description out;
  out.left_out = d.left_out;
  out.energies.push_back("bending");
  if (d.rod.stretches()) out.energies.push_back("stretch");
  if (d.rod.has_gravity()) out.energies.push_back("gravity");
  if (d.rod.has_tip_force()) out.energies.push_back("tip force");
  if (d.rod.has_dead_loads()) out.energies.push_back("loads along the rod");
  for (const PoseProgramTerm& t : d.terms) out.terms.push_back(t.name);
  out.length_unit = d.scale.length;
  out.force_unit = d.scale.force();
  std::size_t largest = 0;
  int most = -1;
  std::vector<Mode> shown(
      d.modes.begin(),
      d.modes.begin() + static_cast<std::ptrdiff_t>(std::min(d.modes.size(), search_parameters().most_enumerated + 1)));
  if (shown.size() < d.modes.size()) {
    out.left_out.push_back(
        {"programs of " + std::to_string(d.modes.size() - shown.size()) + " ways of being in contact",
         "not described, but tried by a plan"});
  }
  if (!d.enumerated) shown.push_back(d.largest_mode());
  if (d.lower) return describe_both_fingers(d, std::move(out));
  for (const Mode& mode : shown) {
    std::vector<int> regions;
    for (const ContactSetup& c : mode.contacts) {
      regions.push_back(c.at_tip || d.scene.coordinates.split_at_contact ? c.region
                                                                         : d.pieces_of_stretch(c.region).front());
    }
    PoseProgramSpec spec = d.spec(mode, regions, d.nodes);
    if (d.scene.contact.friction_state == FrictionState::worst) spec.friction.clear();
    spec.checks = d.first_checks(spec, d.scene_start());
    const PoseProgram program(spec);
    const PoseProgram::Layout& at = program.layout();
    Description::Mode m;
    m.name = mode.name;
    const auto add = [](std::vector<Description::Count>& to, const char* name, int count, const char* kind = "") {
      if (count > 0) to.push_back({name, count, kind});
    };
    add(m.variables, "coordinates", at.coordinates);
    add(m.variables, "moments", at.moments);
    const int drawn = d.rod.draws() ? 1 : 0;
    add(m.variables, "base", at.moves - drawn);
    add(m.variables, "insertion", drawn);
    add(m.variables, "contact_arc_length", at.arc_lengths);
    add(m.variables, "contact_force", at.forces);
    add(m.variables, "tangential_ratio", at.leans);
    add(m.variables, "palm_distance", at.palm >= 0 ? 1 : 0);
    const bool rows_for_complementarity =
        at.forces > 0 && d.scene.contact.treatment != Treatment::penalty && d.min_force == 0.0;
    if (rows_for_complementarity && d.scene.contact.treatment == Treatment::slack) add(m.variables, "slack", at.forces);
    add(m.rows, "equilibrium", at.coordinates, "equality");
    add(m.rows, "contact_gap", at.forces, d.min_force > 0.0 ? "equality" : "inequality");
    add(m.rows, "closest_point", at.arc_lengths, "equality");
    add(m.rows, "closest_point", at.forces - at.arc_lengths, "inequality");
    add(m.rows, "non_penetration", at.checks, "inequality");
    if (rows_for_complementarity) {
      add(m.rows, "complementarity", at.forces,
          d.scene.contact.treatment == Treatment::scholtes ? "inequality" : "equality");
    }
    add(m.rows, "contact_order", at.orders, "inequality");
    add(m.rows, "force_balance", at.balances, "equality");
    add(m.rows, "target", at.targets, "inequality");
    add(m.rows, "shortening", at.shortenings, "inequality");
    if (program.variable_count() > most) {
      most = program.variable_count();
      largest = out.modes.size();
    }
    out.modes.push_back(std::move(m));
  }
  if (!out.modes.empty()) {
    out.variables = out.modes[largest].variables;
    out.rows = out.modes[largest].rows;
  }
  return out;
}

bool Problem::follow_without_solver(Plan& plan, bool contacts_may_change) {
  Task& d = *task_;
  // The worst state of friction changes from one to another on the way.
  const bool worst = d.scene.contact.friction_state == FrictionState::worst && !d.friction.empty();
  if (d.lower || worst) return false;
  if (d.windows.size() > 1) enter(d, window_of(d, &plan));
  d.face(plan.tip_angle);
  if (!d.follower || !d.follower->stands_at(plan)) d.follower = Follower::from(d, plan);
  if (d.follower && !d.follower->step(plan))
    d.follower = contacts_may_change ? d.follower->step_with_other_contacts(plan) : nullptr;
  if (!d.follower || at_next_window(d, plan)) return false;
  // What a search said of the plan before does not hold of this one.
  plan.scan.reset();
  plan.minima.clear();
  plan.notes.clear();
  return true;
}

bool Problem::step(const TargetSpec& target, Plan& plan, const std::atomic<bool>* stop) {
  set_target(target);
  if (!follow_without_solver(plan, true)) return false;
  tell_more(*task_, plan, stop);
  return true;
}

void Problem::follow(const TargetSpec& target, Plan& plan, const std::atomic<bool>* stop) {
  if (step(target, plan, stop)) return;
  PlanControl control;
  control.stop = stop;
  control.start = &plan;
  Plan next = this->plan(control);
  plan = std::move(next);
}

Plan Problem::plan(const PlanControl& control) {
  const double begin = now();
  const bool follows = control.follow && control.start != nullptr && control.start->status == PlanStatus::solved;
  if (follows && control.without.empty()) {
    Plan followed = *control.start;
    if (follow_without_solver(followed, false)) {
      tell_target(*task_, followed);
      tell_more(*task_, followed, control.stop);
      return followed;
    }
  }
  for (const PoseProgramTerm& term : task_->terms) term.fault->clear();
  Plan plan = task_->palm ? plan_grasp(*task_, control) : plan_windows(*task_, control);
  blame_terms(*task_, plan);
  tell_more(*task_, plan, control.stop);
  plan.seconds_assemble = task_->seconds_assemble;
  plan.seconds_solve = now() - begin - plan.seconds_certify;
  if (!task_->palm) plan.start_backbone = outline(task_->scene_start(), task_->rod, task_->scale.length);
  return plan;
}

}  // namespace tendril
