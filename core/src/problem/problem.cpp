#include "tendril/problem.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "base/clock.hpp"
#include "grasp/frames.hpp"
#include "scene/make_rod.hpp"
#include "scene/plan_report.hpp"
#include "search/contacts.hpp"
#include "search/follower.hpp"
#include "search/parameters.hpp"
#include "search/planner.hpp"
#include "search/task.hpp"
#include "tendril/grasp.hpp"
#include "tendril/tolerances.hpp"

namespace tendril {
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

  // Obstacles.
  d.obstacle_names = obstacle_names(d.scene);
  if (needs_obstacles(scene)) {
    if (d.components.obstacles.size() != scene.obstacles.size()) throw Error("one shape per obstacle is needed");
    for (std::size_t i = 0; i < scene.obstacles.size(); ++i) {
      const Obstacle& o = *d.components.obstacles[i];
      d.obstacles.push_back(&o);
      if (const double distance = o.at(d.rod.base).distance; !(distance >= 0.0)) {
        throw SceneError("obstacle[" + std::to_string(i) + "]", d.obstacle_names[i] + " lies around the rod's base (" +
                                                                    shown(-d.scale.to_si(distance, dimension::length)) +
                                                                    " m deep): no shape is free of it");
      }
    }
  }
  d.contact_obstacles = static_cast<int>(d.obstacles.size());
  d.max_force = d.scale.to_dimensionless(d.scene.contact.max_force, dimension::force);
  d.min_force = scene.contact.mode == ContactModeName::require
                    ? d.scale.to_dimensionless(scene.contact.min_force, dimension::force)
                    : 0.0;
  if (grasp) set_up_grasp(d);

  // Target and terms.
  d.take_target(scene.problem == ProblemKind::trajectory ? scene.trajectory.targets.front() : scene.target);
  std::map<std::string, int> seen;
  bool reads_contact_place = false;
  std::string place_reader;
  bool reads_moments = false;
  double largest_weight = 0.0;
  for (std::size_t i = 0; i < scene.objectives.size(); ++i) {
    const ObjectiveSpec& objective = scene.objectives[i];
    if (!needs_term(objective)) {
      d.left_out.push_back({"objective " + objective.plugin, "its weight is 0"});
      continue;
    }
    if (!d.components.terms[i]) throw Error("the term of objective '" + objective.plugin + "' is missing");
    const int count = ++seen[objective.plugin];
    PoseProgramTerm term{d.components.terms[i].get(), objective.weight, objective.plugin};
    if (count > 1) term.name += "#" + std::to_string(count);
    const Reads reads = term.term->reads();
    const std::string path = "objective[" + std::to_string(i) + "].plugin";
    if (reads.target && !d.target.has_position && !d.target.has_angle) {
      throw SceneError(path, "objective '" + objective.plugin + "' needs a [target], but the scene has none");
    }
    if (reads.any_contact() && !d.contact_planned()) {
      throw SceneError(path, "objective '" + objective.plugin +
                                 "' needs a contact, but this scene plans none (contact mode \"" +
                                 std::string(to_string(scene.contact.mode)) + "\", " +
                                 std::to_string(scene.obstacles.size()) + " obstacles)");
    }
    reads_moments = reads_moments || reads.moments;
    if (reads.palm_distance && !grasp) {
      throw SceneError(path, "objective '" + objective.plugin + "' needs a palm, but a pose has none");
    }
    if (reads.contact_point || reads.contact_gap || reads.contact_normal || reads.contact_arc_length) {
      reads_contact_place = true;
      place_reader = term.name;
    }
    largest_weight = std::max(largest_weight, objective.weight);
    d.terms.push_back(term);
  }
  if (grasp && !reads_moments) {
    throw SceneError("objective",
                     "a grasp needs an objective that weighs the moments: with the contact "
                     "force at its limit and no force along the axis there is still a whole family of grasps");
  }
  // Only ratios of weights mean anything: the largest is 1, however small or large all of them are.
  if (largest_weight > 0.0) d.objective_scale = largest_weight;
  for (PoseProgramTerm& t : d.terms) {
    t.weight /= d.objective_scale;
    d.objective_bound += t.weight * t.term->lower_bound();
  }

  // What is left out, with the reason.
  if (!scene.gravity) {
    d.left_out.push_back({"gravity term", "the scene has no gravity"});
  } else if (!d.rod.has_gravity()) {
    d.left_out.push_back({"gravity term", "neither the rod nor the tip has mass, or gravity is zero"});
  }
  if (d.rod.payload == 0.0) d.left_out.push_back({"payload", "no tip mass is given"});
  if (!d.rod.has_tip_force()) d.left_out.push_back({"tip force", "none is given"});
  for (std::size_t a = 0; a < d.rod.actuators.size(); ++a) {
    if (d.rod.actuators[a].fixed_at_zero()) {
      d.left_out.push_back({"moment of actuator " + std::to_string(a + 1), "its limit is 0"});
    }
  }
  if (d.rod.actuators.empty()) d.left_out.push_back({"moments", "the rod has no actuator"});
  std::string no_contact;
  if (d.scene.obstacles.empty()) {
    no_contact = "the scene has no obstacle";
  } else if (scene.contact.mode == ContactModeName::ignore) {
    no_contact = "contact mode \"ignore\"";
  }
  if (!no_contact.empty()) {
    d.left_out.push_back({"check points", no_contact});
    d.left_out.push_back({"contact variables and rows", no_contact});
  } else if (!d.contact_planned()) {
    d.left_out.push_back({"contact variables and rows",
                          scene.contact.mode == ContactModeName::avoid ? "contact mode \"avoid\"" : "max_force is 0"});
  }
  if (!grasp) {
    d.left_out.push_back({"palm distance", "a pose has no palm"});
  } else {
    if (d.palm->minimum == d.palm->maximum) d.left_out.push_back({"palm distance", "it is fixed"});
    if (!d.palm->balance) d.left_out.push_back({"force balance as a row", "the scene leaves it to an objective"});
    if (!both) d.left_out.push_back({"the lower finger", "it is the mirror image of the upper one"});
    d.left_out.push_back({"complementarity of the contacts", "a grasp holds its object: every contact touches"});
  }

  // Modes: the small programs.
  const std::vector<double> knots = d.rod.fixed_knots();
  const std::size_t stretches = knots.size() - 1;
  const bool require = d.scene.contact.mode == ContactModeName::require && d.contact_planned();
  if (!require) {
    Mode none{d.obstacles.empty() ? "free" : "no contact", {}, ""};
    if (reads_contact_place)
      none.skip = "objective '" + place_reader + "' reads the contact point, which this mode has not";
    d.modes.push_back(std::move(none));
  }
  if (d.contact_planned()) {
    const int obstacles = d.contact_obstacles;
    const int count = scene.contact.count;
    const std::vector<ContactSetup> slots = contact_slots(static_cast<int>(stretches), obstacles);
    const auto few = every_assignment(slots, count, search_parameters().most_enumerated);
    d.enumerated = few.has_value() || count == 1;
    for (const std::vector<ContactSetup>& contacts : few ? *few : *every_assignment(slots, 1, slots.size())) {
      d.modes.push_back(d.mode(contacts));
    }
    if (!d.enumerated) d.left_out.push_back(search_note(d));
    if (count > 1) {
      d.left_out.push_back(
          {"two contacts inside the rod with one obstacle",
           "within one segment only one is planned; a second one may be at the tip or on another segment"});
    }
  }

  d.nodes = d.first_nodes();
  if (both) add_lower_finger(d, scene);
  d.seconds_assemble = now() - begin;
}

Description Problem::describe() const {
  const Task& d = *task_;
  Description out;
  out.left_out = d.left_out;
  out.energies.push_back("bending");
  if (d.rod.has_gravity()) out.energies.push_back("gravity");
  if (d.rod.has_tip_force()) out.energies.push_back("tip force");
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
    add(m.variables, "contact_arc_length", at.arc_lengths);
    add(m.variables, "contact_force", at.forces);
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

bool Problem::follow_without_solver(Plan& plan) {
  Task& d = *task_;
  if (d.lower) return false;
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

namespace {

Plan search(Task& task, const PlanControl& control) {
  return task.lower ? plan_both_fingers(task, control) : Planner(task, control).run();
}

/// The finger of a grasp whose limit bounds the force of both.
Task& weaker_finger(Task& task) {
  if (!task.lower) return task;
  const double from_lower = task.lower->term_units.force / task.term_units.force;
  return task.lower->max_force * from_lower < task.max_force ? *task.lower : task;
}

/// A grasp whose objectives leave the force open presses as hard as it may. Where no such grasp is certified it presses
/// as the objectives have it, and the plan says so.
Plan plan_grasp(Task& task, const PlanControl& control) {
  Task& weaker = weaker_finger(task);
  if (!std::isfinite(weaker.max_force)) return search(task, control);
  const std::string limit =
      "each contact at its limit of " + shown(weaker.scale.to_si(weaker.max_force, dimension::force)) + " N";
  const bool asked_for = std::any_of(task.terms.begin(), task.terms.end(),
                                     [](const PoseProgramTerm& t) { return t.term->reads().contact_force; });
  std::string why = "an objective weighs the force against something else";
  Plan plan;
  if (asked_for) {
    plan = search(task, control);
  } else {
    struct Kept {
      Task& task;
      Task& weaker;
      double least = weaker.min_force;
      double time_limit = task.scene.solver.time_limit;
      ~Kept() {
        weaker.min_force = least;
        task.scene.solver.time_limit = time_limit;
      }
    } kept{task, weaker};
    const double begin = now();
    weaker.min_force = weaker.max_force;
    plan = search(task, control);
    const double left = kept.time_limit - (now() - begin);
    const bool ended = plan.status == PlanStatus::solved || plan.status == PlanStatus::interrupted ||
                       plan.status == PlanStatus::failed || !(left > 0.0);
    if (ended) return plan;
    why = "no such grasp was certified (" + plan.message + ")";
    weaker.min_force = kept.least;
    task.scene.solver.time_limit = left;
    plan = search(task, control);
  }
  const bool below = std::any_of(plan.contacts.begin(), plan.contacts.end(), [&](const PlannedContact& c) {
    return c.force < (1.0 - tolerance::branch_decided) * weaker.scale.to_si(weaker.max_force, dimension::force);
  });
  if (below && plan.status == PlanStatus::solved) plan.left_out.push_back({limit, why});
  return plan;
}

}  // namespace

Plan Problem::plan(const PlanControl& control) {
  const double begin = now();
  const bool follows = control.follow && control.start != nullptr && control.start->status == PlanStatus::solved;
  if (follows && control.without.empty()) {
    Plan followed = *control.start;
    if (follow_without_solver(followed)) return followed;
  }
  Plan plan = task_->palm ? plan_grasp(*task_, control) : search(*task_, control);
  plan.seconds_assemble = task_->seconds_assemble;
  plan.seconds_solve = now() - begin - plan.seconds_certify;
  if (!task_->palm) plan.start_backbone = outline(task_->scene_start(), task_->rod, task_->scale.length);
  return plan;
}

}  // namespace tendril
