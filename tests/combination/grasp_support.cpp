#include "grasp_support.hpp"

#include <cmath>

#include "tendril/grasp.hpp"

namespace tendril::combination {

Scene grasp_of_diameter(double diameter, double force_limit, const std::vector<std::string>& overrides) {
  Scene made = scene("grasp_60mm", overrides);
  made.gripper->object_diameter = diameter;
  made.contact.max_force = force_limit;
  return made;
}

std::vector<double> diameters() {
  std::vector<double> all;
  for (int mm = 15; mm <= 75; mm += 5) all.push_back(1e-3 * mm);
  return all;
}

double contact_force(const Plan& plan) {
  double sum = 0.0;
  for (const PlannedContact& c : plan.contacts) sum += c.force;
  return sum;
}

Execution carried_out(const Scene& scene, const Plan& plan, const std::vector<double>& moments, Vec2 moved) {
  Scene there = scene;
  there.gripper->position = there.gripper->position - moved;
  std::vector<std::unique_ptr<Obstacle>> obstacles = obstacles_of_finger(scene, plan.grasp->palm_distance);
  ExecuteControl control;
  control.start = &plan;
  return execute(finger_in_world(there), obstacles, moments, control);
}

Plan confirmed(const Scene& made, double allowed) {
  PlanControl control;
  for (;;) {
    Plan found = plan(made, control);
    if (!certified(found)) return found;
    const double objective = found.objective;
    ExecuteControl own;
    own.start = &found;
    verify(finger_in_world(made), obstacles_of_finger(made, found.grasp->palm_distance), found, own);
    if (certified(found) && *found.model_error < allowed) return found;
    const std::size_t before = control.without.size();
    for (const ModeRecord& mode : found.modes) {
      if (mode.certified && mode.objective == objective) control.without.push_back(mode.mode);
    }
    if (control.without.size() == before) return found;
  }
}

}  // namespace tendril::combination
