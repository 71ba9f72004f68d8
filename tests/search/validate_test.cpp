// Scenes made in code that make no sense are refused before anything is planned, by the key that is wrong; at the limit
// itself they are taken.

#include <cmath>
#include <functional>

#include "scripted_solver.hpp"
#include "tendril/error.hpp"

namespace tendril::search {
namespace {

using combination::scene;

struct Wrong {
  const char* scene;
  const char* path;
  std::function<void(Scene& scene)> change;
};

void make_tendon(Scene& made, std::vector<OffsetPoint> offset) {
  ActuatorSpec& actuator = made.rod.actuators[0];
  actuator.kind = ActuatorKind::tendon;
  actuator.offset = std::move(offset);
  actuator.minimum = 0.0;
}

TEST(SearchValidate, WhatMakesNoSenseIsRefusedByItsKey) {
  const double nan = std::nan("");
  const std::vector<Wrong> all{
      {"brace", "rod.length", [](Scene& s) { s.rod.segments[0].length = 0.0; }},
      {"brace", "rod.bending_stiffness", [](Scene& s) { s.rod.segments[0].bending_stiffness = -1.0; }},
      {"brace", "rod.linear_density", [](Scene& s) { s.rod.segments[0].linear_density = -1e-9; }},
      {"brace", "rod.rest_curvature", [nan](Scene& s) { s.rod.segments[0].rest_curvature = nan; }},
      {"brace", "rod.base.angle", [](Scene& s) { s.rod.base_angle = infinity; }},
      {"brace", "rod.actuator[0].from", [](Scene& s) { s.rod.actuators[0].from = 0.1; }},
      {"brace", "rod.actuator[0].to", [](Scene& s) { s.rod.actuators[0].to = 0.1 * (1.0 + 2e-9); }},
      {"brace", "rod.actuator[0].to", [](Scene& s) { s.rod.actuators[0].from = s.rod.actuators[0].to = 0.05; }},
      {"brace", "rod.actuator[0].min", [](Scene& s) { s.rod.actuators[0].minimum = 1.0; }},
      {"brace", "rod.actuator[0]", [](Scene& s) { s.rod.actuators[0].kind = ActuatorKind::pressure; }},
      {"brace", "rod.actuator[0].moment_per_pressure",
       [](Scene& s) { s.rod.actuators[0].more_moment_per_pressure = {1e-9}; }},
      {"brace", "rod.actuator[0].moment_per_pressure",
       [](Scene& s) {
         ActuatorSpec& a = s.rod.actuators[0];
         a.moment_per_pressure = 1e-6;
         a.more_moment_per_pressure = {-1e-11};
         a.least_pressure = 0.0;
         a.most_pressure = 6e4;
       }},
      {"brace", "rod.actuator[0].offset", [](Scene& s) { make_tendon(s, {}); }},
      {"brace", "rod.actuator[0].offset",
       [](Scene& s) {
         make_tendon(s, {{0.0, 0.0}, {0.1, 0.0}});
       }},
      {"brace", "rod.actuator[0].offset",
       [](Scene& s) {
         make_tendon(s, {{0.0, 1e-3}, {0.09, 1e-3}});
       }},
      {"brace", "rod.actuator[0].offset",
       [](Scene& s) {
         make_tendon(s, {{0.01, 1e-3}, {0.1, 1e-3}});
       }},
      {"brace", "rod.actuator[0].offset",
       [](Scene& s) {
         make_tendon(s, {{0.0, 1e-3}, {0.06, 1e-3}, {0.05, 1e-3}, {0.1, 1e-3}});
       }},
      {"brace", "rod.actuator[0].offset",
       [](Scene& s) {
         s.rod.actuators[0].offset = {{0.0, 1e-3}};
       }},
      {"brace", "rod.actuator[0].min",
       [](Scene& s) {
         make_tendon(s, {{0.0, 1e-3}});
         s.rod.actuators[0].minimum = -1e-3;
       }},
      {"brace", "rod.actuator[0].limit",
       [](Scene& s) { s.rod.actuators[0].minimum = s.rod.actuators[0].maximum = infinity; }},
      {"brace", "rod.actuator[0].limit",
       [](Scene& s) { s.rod.actuators[0].minimum = s.rod.actuators[0].maximum = -infinity; }},
      {"brace", "tip_load.mass", [](Scene& s) { s.tip_load.mass = -1e-9; }},
      {"brace", "target.angle", [nan](Scene& s) { s.target.angle = nan; }},
      {"brace", "contact.max_force", [](Scene& s) { s.contact.max_force = -1e-9; }},
      {"brace", "contact.min_force", [](Scene& s) { s.contact.min_force = 1.001; }},
      {"brace", "contact.count", [](Scene& s) { s.contact.count = 0; }},
      {"brace", "contact.check_points", [](Scene& s) { s.contact.check_points = 10001; }},
      {"brace", "contact.beta", [](Scene& s) { s.contact.beta = 0.0; }},
      {"brace", "contact.min_force", [](Scene& s) { s.contact.mode = ContactModeName::require; }},
      {"free", "contact.mode",
       [](Scene& s) {
         s.contact.mode = ContactModeName::require;
         s.contact.min_force = 0.1;
       }},
      {"brace", "objective[1].weight", [](Scene& s) { s.objectives[1].weight = -1.0; }},
      {"brace", "solver.tolerance", [](Scene& s) { s.solver.tolerance = 0.0; }},
      {"brace", "solver.time_limit", [](Scene& s) { s.solver.time_limit = 0.0; }},
      {"brace", "solver.max_iterations", [](Scene& s) { s.solver.max_iterations = 0; }},
      {"grasp_60mm", "gripper.half_palm", [](Scene& s) { s.gripper->half_palm = 0.0; }},
      {"grasp_60mm", "gripper.object_diameter", [](Scene& s) { s.gripper->object_diameter = 0.0; }},
      {"grasp_60mm", "gripper.finger_angle", [](Scene& s) { s.gripper->finger_angle = 1.5708; }},
      {"grasp_60mm", "gripper.palm_distance", [](Scene& s) { s.gripper->palm_distance = 0.0; }},
      {"grasp_60mm", "gripper.palm_distance_range",
       [](Scene& s) {
         s.gripper->palm_distance_range = {0.06, 0.05};
       }},
      {"grasp_60mm", "gripper.palm_distance_range",
       [](Scene& s) {
         s.gripper->palm_distance = 0.06;
         s.gripper->palm_distance_range = {0.05, 0.06};
       }},
      {"grasp_60mm", "contact.mode", [](Scene& s) { s.contact.mode = ContactModeName::avoid; }},
      {"grasp_60mm", "contact.max_force", [](Scene& s) { s.contact.max_force = 0.0; }},
      {"grasp_60mm", "target", [](Scene& s) { s.target.angle = 0.0; }},
      {"grasp_60mm", "rod.base", [](Scene& s) { s.rod.base_angle = 0.1; }},
      {"grasp_60mm", "gripper", [](Scene& s) { s.gripper.reset(); }},
      {"grasp_unequal", "finger[1].max_force", [](Scene& s) { s.fingers[1].max_force = 0.0; }},
      {"grasp_unequal", "finger[1].min_force", [](Scene& s) { s.fingers[1].min_force = 3.1; }},
      {"grasp_unequal", "finger[0].angle", [](Scene& s) { s.fingers[0].finger_angle = -1.5708; }},
      {"grasp_unequal", "finger", [](Scene& s) { s.problem = ProblemKind::pose, s.gripper.reset(); }},
      {"trajectory", "trajectory", [](Scene& s) { s.trajectory.targets.clear(); }},
      {"trajectory", "trajectory", [](Scene& s) { s.trajectory.targets[1] = {}; }},
      {"trajectory", "target", [](Scene& s) { s.target.angle = 0.0; }},
      {"trajectory", "trajectory.replan_every", [](Scene& s) { s.trajectory.replan_every = -1; }},
      {"trajectory", "trajectory", [](Scene& s) { s.problem = ProblemKind::pose; }},
  };
  for (const Wrong& wrong : all) {
    SCOPED_TRACE(std::string(wrong.scene) + ": " + wrong.path);
    Scene made = scene(wrong.scene);
    validate(made);
    wrong.change(made);
    try {
      validate(made);
      ADD_FAILURE() << "was not refused";
    } catch (const SceneError& error) {
      EXPECT_EQ(error.path(), wrong.path) << error.what();
    }
  }
}

TEST(SearchValidate, WhatIsAtItsLimitIsTaken) {
  const std::vector<std::pair<const char*, std::function<void(Scene&)>>> all{
      {"brace", [](Scene& s) { s.rod.segments[0].linear_density = 0.0; }},
      {"brace", [](Scene& s) { s.rod.actuators[0].to = 0.1 * (1.0 + 0.5e-9); }},
      {"brace", [](Scene& s) { s.rod.actuators[0].minimum = s.rod.actuators[0].maximum; }},
      {"brace", [](Scene& s) { s.contact.min_force = s.contact.max_force; }},
      {"brace", [](Scene& s) { s.contact.max_force = 0.0; }},
      {"brace", [](Scene& s) { s.contact.check_points = 10000; }},
      {"brace", [](Scene& s) { s.objectives[1].weight = 0.0; }},
      {"brace", [](Scene& s) { s.solver.time_limit = infinity; }},
      {"grasp_60mm", [](Scene& s) { s.gripper->finger_angle = 1.5707; }},
      {"grasp_60mm",
       [](Scene& s) {
         s.gripper->palm_distance_range = {0.05, 0.05};
       }},
      {"trajectory", [](Scene& s) { s.trajectory.replan_every = 0; }},
  };
  for (const auto& [name, change] : all) {
    SCOPED_TRACE(name);
    Scene made = scene(name);
    change(made);
    EXPECT_NO_THROW(validate(made));
  }
}

}  // namespace
}  // namespace tendril::search
