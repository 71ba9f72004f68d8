#include <algorithm>
#include <cmath>
#include <numeric>

#include "clock.hpp"
#include "contact_search.hpp"
#include "follower.hpp"
#include "grasp.hpp"
#include "plan_report.hpp"
#include "problem_data.hpp"
#include "tendril/chain.hpp"
#include "tendril/grasp.hpp"

namespace tendril {
namespace {

std::string contact_name(const ContactSetup& c, const std::vector<std::string>& obstacles, std::size_t stretches) {
  const std::string on = "'" + obstacles[static_cast<std::size_t>(c.obstacle)] + "'";
  if (c.at_tip) return "tip contact with " + on;
  std::string name = "interior contact with " + on;
  if (stretches > 1) name += " on segment " + std::to_string(c.region + 1);
  return name;
}

}  // namespace

Problem::Problem(Problem&&) noexcept = default;
Problem& Problem::operator=(Problem&&) noexcept = default;
Problem::~Problem() = default;
Problem::Data::Data() = default;
Problem::Data::~Data() = default;

void Problem::Data::take_target(const TargetSpec& wanted) {
  target = {};
  if (wanted.position) {
    target.position = {scale.to_dimensionless(wanted.position->x, dimension::length),
                       scale.to_dimensionless(wanted.position->y, dimension::length)};
    target.has_position = true;
  }
  if (wanted.angle) {
    target.angle = round_to_12_digits(*wanted.angle);
    target.has_angle = true;
  }
}

void Problem::set_target(const TargetSpec& target) {
  Data& d = *data_;
  const bool read =
      std::any_of(d.terms.begin(), d.terms.end(), [](const PoseProgramTerm& t) { return t.term->reads().target; });
  if (read && !target.position && !target.angle) throw SceneError("target", "an objective needs a target");
  d.take_target(target);
}

bool Problem::Data::contact_planned() const {
  return needs_obstacles(scene) && max_force > 0.0 &&
         (scene.contact.mode == ContactModeName::allow || scene.contact.mode == ContactModeName::require);
}

Problem::Problem(const Scene& scene, Components components) : data_(std::make_unique<Data>()) {
  const double begin = now();
  Data& d = *data_;
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
        char text[64];
        std::snprintf(text, sizeof text, "%.6g m", -d.scale.to_si(distance, dimension::length));
        throw SceneError("obstacle[" + std::to_string(i) + "]", d.obstacle_names[i] + " lies around the rod's base (" +
                                                                    text + " deep): no shape is free of it");
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
    const auto few = every_assignment(slots, count, most_enumerated);
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

int Problem::Data::first_nodes() const {
  double angle = std::max(1.0, std::abs(scene.start_tip_angle));
  for (const Rod::Actuator& a : rod.actuators) {
    const double largest = std::max(std::abs(a.minimum), std::abs(a.maximum));
    if (std::isfinite(largest)) angle = std::max(angle, largest * (a.to - a.from));
  }
  return suggested_nodes(model->function_count(), std::min(angle, 30.0));
}

Mode Problem::Data::mode(std::vector<ContactSetup> contacts) const {
  const std::vector<double> knots = rod.fixed_knots();
  Mode mode;
  mode.contacts = std::move(contacts);
  for (const ContactSetup& c : mode.contacts) {
    if (!mode.name.empty()) mode.name += " and ";
    mode.name += contact_name(c, obstacle_names, knots.size() - 1);
    // A point at arc length s is at most s away from the base.
    const double reach = c.at_tip ? 1.0 : knots[static_cast<std::size_t>(c.region) + 1];
    if (palm) {
      if (mode.skip.empty()) mode.skip = grasp_obstruction(*this, reach);
    } else if (obstacles[static_cast<std::size_t>(c.obstacle)]->at(rod.base).distance > reach) {
      mode.skip = "out of reach: the obstacle is farther from the base than this part of the rod is long";
    }
  }
  return mode;
}

PoseProgramSpec Problem::Data::spec(const Mode& mode, const std::vector<int>& regions, int with_nodes) const {
  PoseProgramSpec s;
  s.rod = &rod;
  s.model = model;
  s.obstacles = obstacles;
  s.terms = terms;
  s.target = target;
  s.split = scene.coordinates.split_at_contact;
  s.contacts = mode.contacts;
  for (std::size_t k = 0; k < s.contacts.size(); ++k) s.contacts[k].region = regions[k];
  s.nodes = with_nodes;
  s.min_force = min_force;
  s.max_force = max_force;
  s.palm = palm;
  s.carried = carried;
  s.least_margin = least_margin;
  s.least_convexity = least_convexity;
  s.term_units = term_units;
  s.tables = tables;
  return s;
}

std::vector<int> Problem::Data::regions_of(const Mode& mode, const std::vector<double>& arc_lengths) const {
  std::vector<int> regions;
  regions.reserve(mode.contacts.size());
  for (const ContactSetup& c : mode.contacts) regions.push_back(c.region);
  if (scene.coordinates.split_at_contact) return regions;
  const Chain chain(rod, *components.coordinates, {}, 1);
  for (std::size_t k = 0; k < regions.size(); ++k) {
    if (!mode.contacts[k].at_tip) regions[k] = chain.piece_at(arc_lengths[k], {});
  }
  return regions;
}

int Problem::Data::coordinate_count(const Mode& mode) const {
  auto stretches = static_cast<int>(rod.fixed_knots().size()) - 1;
  if (scene.coordinates.split_at_contact) {
    stretches += static_cast<int>(
        std::count_if(mode.contacts.begin(), mode.contacts.end(), [](const ContactSetup& c) { return !c.at_tip; }));
  }
  return stretches * static_cast<int>(model->subdivision().size()) * model->function_count();
}

std::vector<int> Problem::Data::pieces_of_stretch(int stretch) const {
  const auto parts = static_cast<int>(model->subdivision().size());
  std::vector<int> pieces(static_cast<std::size_t>(parts));
  std::iota(pieces.begin(), pieces.end(), stretch * parts);
  return pieces;
}

std::vector<CheckPoint> Problem::Data::first_checks(const PoseProgramSpec& spec, const StartShape& shape) const {
  std::vector<CheckPoint> checks;
  if (obstacles.empty()) return checks;
  const PoseProgram probe(spec);
  const Eigen::VectorXd x = probe.start_from(shape);
  const PoseProgram::Layout& at = probe.layout();
  const Chain& chain = probe.chain();
  const std::span<const double> knots(x.data() + at.first_arc_length, static_cast<std::size_t>(chain.knot_count()));
  // Few points where the planner adds what is missing, but not so few that a rod without contact slips past an obstacle
  // between two of them; as many as asked for where the planner adds none.
  int count = 4;
  if (spec.contacts.empty()) {
    for (const Obstacle* o : obstacles) {
      count = std::max(count, static_cast<int>(std::ceil(std::min(16.0, 0.6 / o->smallest_radius()))));
    }
  }
  if (scene.contact.check_points > 0) count = scene.contact.check_points;
  for (int i = 1; i <= count; ++i) {
    const double s = static_cast<double>(i) / count;
    bool near_contact = false;
    for (int k = 0; k < at.arc_lengths; ++k)
      near_contact = near_contact || std::abs(s - x[at.first_arc_length + k]) < 0.02;
    if (near_contact) continue;
    const int j = i == count ? chain.piece_count() - 1 : chain.piece_at(s, knots);
    const double sigma =
        i == count ? 1.0 : std::clamp((s - chain.start(j, knots)) / chain.length(j, knots), 0.02, 0.98);
    for (int o = 0; o < static_cast<int>(obstacles.size()); ++o) {
      // A tip that touches is a contact already.
      const bool tip_touches =
          i == count && std::any_of(spec.contacts.begin(), spec.contacts.end(),
                                    [o](const ContactSetup& c) { return c.at_tip && c.obstacle == o; });
      if (!tip_touches) checks.push_back({j, sigma, o});
    }
  }
  return checks;
}

/// One of the assignments with the most contacts, for its size.
Mode Problem::Data::largest_mode() const {
  const int stretches = static_cast<int>(rod.fixed_knots().size()) - 1;
  std::vector<ContactSetup> contacts;
  for (const ContactSetup& slot : contact_slots(stretches, contact_obstacles)) {
    if (static_cast<int>(contacts.size()) == scene.contact.count) break;
    if (!slot.at_tip || contacts.empty() || !contacts.back().at_tip) contacts.push_back(slot);
  }
  Mode largest = mode(contacts);
  largest.name = std::to_string(contacts.size()) + " contacts, as one of the assignments that a plan searches";
  return largest;
}

Description Problem::describe() const {
  const Data& d = *data_;
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
  std::vector<Mode> shown(d.modes.begin(),
                          d.modes.begin() + static_cast<std::ptrdiff_t>(std::min(d.modes.size(), most_enumerated + 1)));
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

}  // namespace tendril
