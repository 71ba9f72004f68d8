#include <algorithm>
#include <array>
#include <vector>

#include "grasp/frames.hpp"
#include "program/grasp_program.hpp"
#include "scene/make_rod.hpp"
#include "scene/plan_report.hpp"
#include "search/contacts.hpp"
#include "tendril/error.hpp"
#include "tendril/grasp.hpp"

namespace tendril {
namespace {

/// Each finger has a program of its own, so a term has to say what it says for either alone.
void require_terms_of_one_finger(const Task& upper, const Scene& scene) {
  for (const PoseProgramTerm& t : upper.terms) {
    if (!t.term->reads().mirrored) continue;
    std::size_t at = 0;
    while (at + 1 < scene.objectives.size() && scene.objectives[at].plugin != t.name.substr(0, t.name.find('#'))) ++at;
    throw SceneError("objective[" + std::to_string(at) + "].plugin",
                     "objective '" + t.name +
                         "' takes one finger for the other one's mirror image, but both fingers are planned; expected "
                         "terms that read each finger for itself, such as 'actuation_effort'");
  }
}

}  // namespace

void add_lower_finger(Task& upper, const Scene& scene) {
  if (!scene.gripper->exact_balance) {
    throw SceneError("gripper.balance",
                     "found \"objective\", but where both fingers are planned no force may be left on the object; "
                     "expected \"exact\"");
  }
  if (scene.contact.count != 1) {
    throw SceneError("contact.count", "found " + std::to_string(scene.contact.count) +
                                          " contacts for each finger, but where both fingers are planned each touches "
                                          "the object once; expected 1");
  }
  if (!scene.coordinates.split_at_contact) {
    throw SceneError("coordinates.split_at_contact",
                     "found false, but where both fingers are planned each has a knot at its contact; expected true");
  }
  upper.lower = std::make_unique<Task>();
  Task& lower = *upper.lower;
  lower.scene = finger_in_palm_frame(finger_of(scene, FingerName::lower));
  lower.model = upper.model;
  lower.scale = scale_of(lower.scene);
  lower.scene_scale = upper.scene_scale;
  lower.term_units = {lower.scale.length / lower.scene_scale.length, lower.scale.force() / lower.scene_scale.force()};
  lower.rod = make_rod(lower.scene, lower.scale);
  lower.obstacle_names = obstacle_names(lower.scene);
  lower.max_force = lower.scale.to_dimensionless(lower.scene.contact.max_force, dimension::force);
  set_up_grasp(lower);
  lower.terms = upper.terms;
  lower.objective_scale = upper.objective_scale;
  require_terms_of_one_finger(upper, scene);
  lower.nodes = lower.first_nodes();

  // Both stand on one palm.
  const double from_lower = lower.term_units.length / upper.term_units.length;
  upper.palm->minimum = std::max(upper.palm->minimum, lower.palm->minimum * from_lower);
  upper.palm->maximum = std::min(upper.palm->maximum, lower.palm->maximum * from_lower);
  if (upper.palm->minimum > upper.palm->maximum) upper.palm->minimum = upper.palm->maximum;
  lower.palm->minimum = upper.palm->minimum / from_lower;
  lower.palm->maximum = upper.palm->maximum / from_lower;
  // Without a load both press with the same force.
  const double force_from_lower = lower.term_units.force / upper.term_units.force;
  if (!upper.palm->loaded && std::max(upper.min_force, lower.min_force * force_from_lower) >
                                 std::min(upper.max_force, lower.max_force * force_from_lower)) {
    throw SceneError("contact.min_force",
                     "one finger has to press harder than the other one may, but an object at rest is pressed equally "
                     "hard from both sides");
  }

  for (Task* finger : {&upper, &lower}) {
    finger->modes.clear();
    const int stretches = static_cast<int>(finger->rod.fixed_knots().size()) - 1;
    const std::vector<ContactSetup> slots = contact_slots(stretches, finger->contact_obstacles);
    for (const ContactSetup& slot : slots) finger->modes.push_back(finger->mode({slot}));
  }
  for (std::size_t a = 0; a < lower.rod.actuators.size(); ++a) {
    if (lower.rod.actuators[a].fixed_at_zero())
      upper.left_out.push_back(
          {"moment of actuator " + std::to_string(a + 1) + " of the lower finger", "its limit is 0"});
  }
  if (!upper.palm->loaded)
    upper.left_out.push_back({"force of the second contact", "it is that of the first: the object is at rest"});
}

std::string pair_name(const Mode& above, const Mode& below) {
  return "upper finger: " + above.name + "; lower finger: " + below.name;
}

Description describe_both_fingers(const Task& upper, Description out) {
  const std::array<const Task*, 2> fingers{&upper, upper.lower.get()};
  out.length_unit = upper.scene_scale.length;
  out.force_unit = upper.scene_scale.force();
  if (fingers[1]->rod.has_gravity() && !fingers[0]->rod.has_gravity()) out.energies.push_back("gravity");
  std::size_t largest = 0;
  int most = -1;
  const auto add = [](std::vector<Description::Count>& to, const char* name, int count, const char* kind = "") {
    if (count > 0) to.push_back({name, count, kind});
  };
  for (const Mode& above : fingers[0]->modes) {
    for (const Mode& below : fingers[1]->modes) {
      Description::Mode m;
      m.name = pair_name(above, below);
      int coordinates = 0, moments = 0, moves = 0, arc_lengths = 0, checks = 0;
      for (std::size_t which = 0; which < 2; ++which) {
        const Task& d = *fingers[which];
        const Mode& mode = which == 0 ? above : below;
        PoseProgramSpec spec = d.spec(mode, {mode.contacts.front().region}, d.nodes);
        spec.checks = d.first_checks(spec, d.scene_start());
        const PoseProgram program(spec);
        const PoseProgram::Layout& at = program.layout();
        coordinates += at.coordinates;
        moments += at.moments;
        moves += at.moves;
        arc_lengths += at.arc_lengths;
        checks += at.checks;
      }
      const int palm = upper.palm->minimum != upper.palm->maximum ? 1 : 0;
      add(m.variables, "coordinates", coordinates);
      add(m.variables, "moments", moments);
      add(m.variables, "base", moves);
      add(m.variables, "contact_arc_length", arc_lengths);
      const int forces = upper.palm->loaded ? 2 : 1;
      const int ratios = upper.friction.empty() ? 0 : forces;
      const int balances = !upper.palm->loaded ? 1 : ratios > 0 ? 3 : 2;
      add(m.variables, "contact_force", forces);
      add(m.variables, "tangential_ratio", ratios);
      add(m.variables, "palm_distance", palm);
      add(m.rows, "equilibrium", coordinates, "equality");
      add(m.rows, "contact_gap", 2, "equality");
      add(m.rows, "closest_point", arc_lengths, "equality");
      add(m.rows, "closest_point", 2 - arc_lengths, "inequality");
      add(m.rows, "non_penetration", checks, "inequality");
      add(m.rows, "force_balance", balances, "equality");
      const int count = coordinates + moments + moves + arc_lengths + forces + ratios + palm;
      if (count > most) {
        most = count;
        largest = out.modes.size();
      }
      out.modes.push_back(std::move(m));
    }
  }
  if (!out.modes.empty()) {
    out.variables = out.modes[largest].variables;
    out.rows = out.modes[largest].rows;
  }
  return out;
}

}  // namespace tendril
