// Every rule for scenes: what breaks it is refused with its key, and what is just within it passes.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "tendril/error.hpp"
#include "tendril/plan.hpp"
#include "tendril/problem.hpp"

namespace tendril {
namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

Scene pose() {
  Scene scene;
  scene.gravity = Vec2{0.0, -9.81};
  scene.rod.segments = {{0.1, 1e-3, 0.1, 0.0}};
  scene.rod.actuators = {{0.0, 0.1, -0.01, 0.01, 0.0}};
  scene.target.position = Vec2{0.09, 0.01};
  scene.objectives = {{.plugin = "tip_pose", .options = {}, .position = {}}};
  return scene;
}

Scene pose_with_obstacle() {
  Scene scene = pose();
  scene.obstacles = {{"peg", "circle", {}}};
  return scene;
}

Scene two_segments() {
  Scene scene = pose();
  scene.rod.segments = {{0.04, 1e-3, 0.1, 0.0}, {0.06, 1e-3, 0.1, 0.0}};
  return scene;
}

Scene trajectory() {
  Scene scene = pose();
  scene.problem = ProblemKind::trajectory;
  scene.target = {};
  scene.trajectory.targets = {{Vec2{0.09, 0.01}, {}}, {{}, 0.3}};
  return scene;
}

Scene grasp() {
  Scene scene = pose();
  scene.problem = ProblemKind::grasp;
  scene.target = {};
  scene.gripper =
      GripperSpec{.half_palm = 0.02, .object_diameter = 0.04, .palm_distance = {}, .palm_distance_range = {}};
  return scene;
}

Scene grasp_of_two() {
  Scene scene = grasp();
  scene.fingers = {{scene.rod, 0.0, {}, 0.0, 1.0}, {scene.rod, 0.0, {}, 0.0, 1.0}};
  return scene;
}

struct Rule {
  Scene (*from)();
  std::function<void(Scene&)> change;
  std::string path;     ///< empty: the scene is valid
  std::string message;  ///< a part of it
};

void check(const Rule& rule) {
  Scene scene = rule.from();
  ASSERT_NO_THROW(validate(scene)) << "before anything is changed";
  rule.change(scene);
  if (rule.path.empty()) {
    EXPECT_NO_THROW(validate(scene));
    return;
  }
  try {
    validate(scene);
    ADD_FAILURE() << "nothing was refused; expected: " << rule.path << ": " << rule.message;
  } catch (const SceneError& error) {
    EXPECT_EQ(error.path(), rule.path) << error.what();
    EXPECT_NE(std::string(error.what()).find(rule.message), std::string::npos) << error.what();
  }
}

Rule refused(Scene (*from)(), std::function<void(Scene&)> change, const char* path, const char* message) {
  return {from, std::move(change), path, message};
}

Rule accepted(Scene (*from)(), std::function<void(Scene&)> change) { return {from, std::move(change), "", ""}; }

void check(const std::vector<Rule>& rules) {
  for (std::size_t i = 0; i < rules.size(); ++i) {
    SCOPED_TRACE("rule " + std::to_string(i + 1));
    check(rules[i]);
  }
}

/// Numbers of a scene that must be finite, positive or not negative.
struct Number {
  Scene (*from)();
  double& (*of)(Scene&);
  const char* path;
  bool zero, negative;  ///< whether these are allowed
};

std::vector<Rule> number_rules() {
  const Number numbers[] = {
      {pose, [](Scene& s) -> double& { return s.rod.segments[0].length; }, "rod.length", false, false},
      {pose, [](Scene& s) -> double& { return s.rod.segments[0].bending_stiffness; }, "rod.bending_stiffness", false,
       false},
      {pose, [](Scene& s) -> double& { return s.rod.segments[0].linear_density; }, "rod.linear_density", true, false},
      {pose, [](Scene& s) -> double& { return s.rod.segments[0].rest_curvature; }, "rod.rest_curvature", true, true},
      {two_segments, [](Scene& s) -> double& { return s.rod.segments[1].bending_stiffness; },
       "rod.segment[1].bending_stiffness", false, false},
      {two_segments, [](Scene& s) -> double& { return s.rod.segments[1].linear_density; },
       "rod.segment[1].linear_density", true, false},
      {pose, [](Scene& s) -> double& { return s.rod.base_position.x; }, "rod.base.position", true, true},
      {pose, [](Scene& s) -> double& { return s.rod.base_position.y; }, "rod.base.position", true, true},
      {pose, [](Scene& s) -> double& { return s.rod.base_angle; }, "rod.base.angle", true, true},
      {pose, [](Scene& s) -> double& { return s.rod.actuators[0].moment_per_pressure; },
       "rod.actuator[0].moment_per_pressure", true, true},
      {pose, [](Scene& s) -> double& { return s.gravity->x; }, "gravity", true, true},
      {pose, [](Scene& s) -> double& { return s.gravity->y; }, "gravity", true, true},
      {pose, [](Scene& s) -> double& { return s.start_tip_angle; }, "start.tip_angle", true, true},
      {pose, [](Scene& s) -> double& { return s.tip_load.mass; }, "tip_load.mass", true, false},
      {pose, [](Scene& s) -> double& { return s.tip_load.force.x; }, "tip_load.force", true, true},
      {pose, [](Scene& s) -> double& { return s.tip_load.force.y; }, "tip_load.force", true, true},
      {pose, [](Scene& s) -> double& { return s.target.position->x; }, "target.position", true, true},
      {pose, [](Scene& s) -> double& { return s.target.position->y; }, "target.position", true, true},
      {pose, [](Scene& s) -> double& { return s.target.angle.emplace(0.1); }, "target.angle", true, true},
      {pose, [](Scene& s) -> double& { return s.contact.min_force; }, "contact.min_force", true, false},
      {pose, [](Scene& s) -> double& { return s.contact.beta; }, "contact.beta", false, false},
      {pose, [](Scene& s) -> double& { return s.objectives[0].weight; }, "objective[0].weight", true, false},
      {pose, [](Scene& s) -> double& { return s.solver.tolerance; }, "solver.tolerance", false, false},
      {trajectory, [](Scene& s) -> double& { return s.trajectory.targets[0].position->x; }, "trajectory.positions[0]",
       true, true},
      {trajectory, [](Scene& s) -> double& { return s.trajectory.targets[0].position->y; }, "trajectory.positions[0]",
       true, true},
      {trajectory, [](Scene& s) -> double& { return *s.trajectory.targets[1].angle; }, "trajectory.angles[1]", true,
       true},
      {grasp, [](Scene& s) -> double& { return s.gripper->half_palm; }, "gripper.half_palm", false, false},
      {grasp, [](Scene& s) -> double& { return s.gripper->object_diameter; }, "gripper.object_diameter", false, false},
      {grasp, [](Scene& s) -> double& { return s.gripper->position.x; }, "gripper.position", true, true},
      {grasp, [](Scene& s) -> double& { return s.gripper->position.y; }, "gripper.position", true, true},
      {grasp, [](Scene& s) -> double& { return s.gripper->angle; }, "gripper.angle", true, true},
      {grasp, [](Scene& s) -> double& { return s.gripper->palm_distance.emplace(0.07); }, "gripper.palm_distance",
       false, false},
      {grasp, [](Scene& s) -> double& { return s.gripper->palm_distance_range.emplace(0.0, 0.1).first; },
       "gripper.palm_distance_range", true, false},
      {grasp, [](Scene& s) -> double& { return s.gripper->palm_distance_range.emplace(0.0, 0.1).second; },
       "gripper.palm_distance_range", false, false},
      {grasp_of_two, [](Scene& s) -> double& { return s.fingers[1].rod.segments[0].bending_stiffness; },
       "finger[1].bending_stiffness", false, false},
      {grasp_of_two, [](Scene& s) -> double& { return s.fingers[0].min_force; }, "finger[0].min_force", true, false}};
  std::vector<Rule> rules;
  for (const Number& n : numbers) {
    const auto set = [of = n.of](double value) { return [of, value](Scene& s) { of(s) = value; }; };
    rules.push_back(refused(n.from, set(not_a_number), n.path, ""));
    rules.push_back(refused(n.from, set(infinity), n.path, ""));
    rules.push_back(n.zero ? accepted(n.from, set(0.0)) : refused(n.from, set(0.0), n.path, ""));
    rules.push_back(n.negative ? accepted(n.from, set(-1e-3)) : refused(n.from, set(-1e-3), n.path, ""));
  }
  return rules;
}

TEST(Validation, OfNumbers) { check(number_rules()); }

TEST(Validation, OfRodsThatStretch) {
  const auto stretch = [](Scene& s) {
    s.coordinates.stretch_order = 2;
    for (SegmentSpec& segment : s.rod.segments) segment.axial_stiffness = 30.0;
  };
  const auto with = [&](auto change) {
    return [=](Scene& s) {
      stretch(s);
      change(s);
    };
  };
  const auto nothing = [](Scene&) {};
  const char* order = "coordinates.stretch_order";
  const auto of = [](int n) { return [n](Scene& s) { s.coordinates.stretch_order = n; }; };
  const auto tapers = [](Scene& s) { s.rod.segments[0].more_thickness = {0.001}; };
  check({accepted(two_segments, stretch), accepted(trajectory, stretch), accepted(pose_with_obstacle, stretch),
         accepted(pose, with(of(32))), refused(pose, with(of(33)), order, "found 33"),
         refused(pose, with(of(-1)), order, "expected 0"),
         refused(pose, of(1), "rod.axial_stiffness", "needs an axial stiffness above 0, found 0 N"),
         refused(two_segments, with([](Scene& s) { s.rod.segments[1].axial_stiffness = 0.0; }),
                 "rod.segment[1].axial_stiffness", "found 0 N"),
         refused(pose, with([](Scene& s) { s.rod.segments[0].more_axial_stiffness = {-40.0}; }), "rod.axial_stiffness",
                 "must be positive all along"),
         refused(grasp, with(nothing), order, "grasps are planned with fingers of fixed length"),
         refused(pose, with([](Scene& s) { s.problem = ProblemKind::estimate; }), order, "forces are estimated"),
         accepted(pose_with_obstacle, with([](Scene& s) { s.contact.friction = 0.3; })),
         refused(pose_with_obstacle, with(tapers), order, "a body whose diameter changes"),
         accepted(pose, with(tapers))});
}

TEST(Validation, OfActuators) {
  check({refused(
             pose, [](Scene& s) { s.rod.segments.clear(); }, "rod", "the rod has no length"),
         refused(
             pose, [](Scene& s) { s.rod.actuators[0].from = -1e-6; }, "rod.actuator[0].from", "starts at"),
         refused(
             pose, [](Scene& s) { s.rod.actuators[0].from = 0.1; }, "rod.actuator[0].from", "starts at 0.1 m"),
         refused(
             pose, [](Scene& s) { s.rod.actuators[0].from = not_a_number; }, "rod.actuator[0].from", "starts at"),
         accepted(pose, [](Scene& s) { s.rod.actuators[0].from = 0.0999; }),
         refused(
             pose, [](Scene& s) { s.rod.actuators[0].to = 0.0; }, "rod.actuator[0].to", "ends at 0 m"),
         refused(
             pose, [](Scene& s) { s.rod.actuators[0].to = 0.1 * (1.0 + 2e-9); }, "rod.actuator[0].to", "ends at"),
         accepted(pose, [](Scene& s) { s.rod.actuators[0].to = 0.1 * (1.0 + 5e-10); }),
         refused(
             pose, [](Scene& s) { s.rod.actuators[0].to = not_a_number; }, "rod.actuator[0].to", "ends at"),
         refused(
             pose, [](Scene& s) { s.rod.actuators[0].minimum = 0.011; }, "rod.actuator[0].min", "contradict"),
         accepted(pose, [](Scene& s) { s.rod.actuators[0].minimum = 0.01; }),
         refused(
             pose, [](Scene& s) { s.rod.actuators[0].minimum = not_a_number; }, "rod.actuator[0].limit", "contradict"),
         refused(
             pose, [](Scene& s) { s.rod.actuators[0].maximum = not_a_number; }, "rod.actuator[0].limit", "contradict"),
         refused(
             pose, [](Scene& s) { s.rod.actuators[0].minimum = s.rod.actuators[0].maximum = infinity; },
             "rod.actuator[0].limit", "no moment"),
         refused(
             pose, [](Scene& s) { s.rod.actuators[0].minimum = s.rod.actuators[0].maximum = -infinity; },
             "rod.actuator[0].limit", "no moment"),
         accepted(pose, [](Scene& s) {
           s.rod.actuators[0].minimum = -infinity;
           s.rod.actuators[0].maximum = infinity;
         })});
}

TEST(Validation, OfContacts) {
  check(
      {refused(
           pose, [](Scene& s) { s.contact.max_force = -1.0; }, "contact.max_force", "must not be negative"),
       refused(
           pose, [](Scene& s) { s.contact.max_force = not_a_number; }, "contact.max_force", "negative"),
       accepted(pose, [](Scene& s) { s.contact.max_force = 0.0; }),
       refused(
           pose, [](Scene& s) { s.contact = {.min_force = 2.0, .max_force = 1.0}; }, "contact.min_force", "contradict"),
       accepted(pose, [](Scene& s) { s.contact = {.min_force = 1.0, .max_force = 1.0}; }),
       refused(
           pose, [](Scene& s) { s.contact.count = 0; }, "contact.count", "at least 1 contact"),
       refused(
           pose, [](Scene& s) { s.contact.check_points = -1; }, "contact.check_points", "found -1"),
       refused(
           pose, [](Scene& s) { s.contact.check_points = 10001; }, "contact.check_points", "found 10001"),
       accepted(pose, [](Scene& s) { s.contact.check_points = 10000; }),
       refused(
           pose,
           [](Scene& s) {
             s.contact.mode = ContactModeName::require;
             s.contact.min_force = 1.0;
           },
           "contact.mode", "the scene has none"),
       refused(
           pose_with_obstacle, [](Scene& s) { s.contact.mode = ContactModeName::require; }, "contact.min_force",
           "above 0"),
       accepted(pose_with_obstacle,
                [](Scene& s) {
                  s.contact.mode = ContactModeName::require;
                  s.contact.min_force = 1.0;
                }),
       refused(
           pose, [](Scene& s) { s.solver.time_limit = 0.0; }, "solver.time_limit", "positive"),
       refused(
           pose, [](Scene& s) { s.solver.time_limit = not_a_number; }, "solver.time_limit", "positive"),
       accepted(pose, [](Scene& s) { s.solver.time_limit = infinity; }),
       refused(
           pose, [](Scene& s) { s.solver.max_iterations = 0; }, "solver.max_iterations", "found 0"),
       accepted(pose, [](Scene& s) { s.solver.max_iterations = 1; })});
}

TEST(Validation, OfTrajectories) {
  check({refused(
             trajectory, [](Scene& s) { s.problem = ProblemKind::pose; }, "trajectory", "needs problem"),
         refused(
             trajectory, [](Scene& s) { s.trajectory.targets.clear(); }, "trajectory", "needs targets"),
         refused(
             trajectory, [](Scene& s) { s.target.position = Vec2{}; }, "target", "no [target]"),
         refused(
             trajectory, [](Scene& s) { s.target.angle = 0.1; }, "target", "no [target]"),
         refused(
             trajectory, [](Scene& s) { s.trajectory.targets[1] = {}; }, "trajectory", "target [1] is empty"),
         refused(
             trajectory, [](Scene& s) { s.trajectory.replan_every = -1; }, "trajectory.replan_every", "found -1"),
         accepted(trajectory, [](Scene& s) { s.trajectory.replan_every = 1; })});
}

TEST(Validation, OfGrasps) {
  check({refused(
             grasp, [](Scene& s) { s.problem = ProblemKind::pose; }, "gripper", "needs problem"),
         refused(
             grasp_of_two,
             [](Scene& s) {
               s.problem = ProblemKind::pose;
               s.gripper.reset();
             },
             "finger", "needs problem"),
         refused(
             grasp, [](Scene& s) { s.gripper.reset(); }, "gripper", "needs a [gripper]"),
         refused(
             grasp, [](Scene& s) { s.gripper->finger_angle = 1.571; }, "gripper.finger_angle", "away from the palm"),
         refused(
             grasp, [](Scene& s) { s.gripper->finger_angle = -1.571; }, "gripper.finger_angle", "away"),
         refused(
             grasp, [](Scene& s) { s.gripper->finger_angle = not_a_number; }, "gripper.finger_angle", "away"),
         accepted(grasp, [](Scene& s) { s.gripper->finger_angle = -1.57; }),
         refused(
             grasp,
             [](Scene& s) {
               s.gripper->finger_angle_range = {0.1, 0.2};
             },
             "gripper.finger_angle_range", "lies outside of 0.1 rad to 0.2 rad"),
         refused(
             grasp,
             [](Scene& s) {
               s.gripper->finger_angle_range = {0.2, -0.2};
             },
             "gripper.finger_angle_range", "contradict"),
         refused(
             grasp,
             [](Scene& s) {
               s.gripper->finger_angle_range = {-0.2, 1.6};
             },
             "gripper.finger_angle_range", "away"),
         accepted(grasp,
                  [](Scene& s) {
                    s.gripper->finger_angle_range = {-0.2, 1.5};
                  }),
         refused(
             grasp,
             [](Scene& s) {
               s.gripper->half_palm_range = {0.021, 0.03};
             },
             "gripper.half_palm_range", "lies outside of 0.021 m to 0.03 m"),
         refused(
             grasp,
             [](Scene& s) {
               s.gripper->half_palm_range = {0.0, 0.03};
             },
             "gripper.half_palm_range", "positive"),
         accepted(grasp,
                  [](Scene& s) {
                    s.gripper->half_palm_range = {0.01, 0.03};
                  }),
         refused(
             grasp,
             [](Scene& s) {
               s.rod.base_angle_range = {-0.1, 0.1};
             },
             "rod.base", "expected 'half_palm_range' and 'finger_angle_range' in [gripper]"),
         refused(
             grasp, [](Scene& s) { s.rod.most_drawn_in = 0.02; }, "rod.insertion", "fingers keep their length"),
         refused(
             grasp_of_two,
             [](Scene& s) {
               s.fingers[0].finger_angle_range = {0.1, 0.2};
             },
             "finger[0].angle_range", "lies outside"),
         refused(
             grasp_of_two, [](Scene& s) { s.fingers[1].rod.most_drawn_in = 0.02; }, "finger[1]", "on the palm"),
         refused(
             grasp_of_two, [](Scene& s) { s.fingers.pop_back(); }, "finger", "found 1 [[finger]], expected two"),
         refused(
             grasp_of_two, [](Scene& s) { s.fingers.push_back(s.fingers[0]); }, "finger", "found 3"),
         refused(
             grasp_of_two, [](Scene& s) { s.gripper->fingers = Fingers::mirrored; }, "gripper.fingers",
             "found \"mirrored\""),
         accepted(grasp_of_two, [](Scene& s) { s.gripper->fingers = Fingers::both; }),
         refused(
             grasp_of_two, [](Scene& s) { s.fingers[1].finger_angle = 1.6; }, "finger[1].angle", "away"),
         refused(
             grasp_of_two, [](Scene& s) { s.fingers[1].max_force = 0.0; }, "finger[1].max_force", "above 0"),
         refused(
             grasp_of_two, [](Scene& s) { s.fingers[0].min_force = 1.1; }, "finger[0].min_force", "contradict"),
         refused(
             grasp_of_two, [](Scene& s) { s.fingers[0].rod.base_position.x = 0.1; }, "finger[0]", "on the palm"),
         refused(
             grasp_of_two, [](Scene& s) { s.fingers[1].rod.base_position.y = 0.1; }, "finger[1]", "on the palm"),
         refused(
             grasp_of_two, [](Scene& s) { s.fingers[1].rod.base_angle = 0.1; }, "finger[1]", "on the palm"),
         refused(
             grasp,
             [](Scene& s) {
               s.gripper->palm_distance = 0.07;
               s.gripper->palm_distance_range = {0.0, 0.1};
             },
             "gripper.palm_distance_range", "expected one of them"),
         refused(
             grasp,
             [](Scene& s) {
               s.gripper->palm_distance_range = {0.2, 0.1};
             },
             "gripper.palm_distance_range", "contradict"),
         accepted(grasp,
                  [](Scene& s) {
                    s.gripper->palm_distance_range = {0.1, 0.1};
                  }),
         refused(
             grasp,
             [](Scene& s) {
               s.obstacles = {{"peg", "circle", {}}};
             },
             "obstacle", "no [[obstacle]]"),
         refused(
             grasp, [](Scene& s) { s.target.position = Vec2{}; }, "target", "no target pose"),
         refused(
             grasp, [](Scene& s) { s.target.angle = 0.0; }, "target", "no target pose"),
         refused(
             grasp, [](Scene& s) { s.rod.base_position.x = 0.1; }, "rod.base", "on the palm"),
         refused(
             grasp, [](Scene& s) { s.rod.base_position.y = 0.1; }, "rod.base", "on the palm"),
         refused(
             grasp, [](Scene& s) { s.rod.base_angle = 0.1; }, "rod.base", "on the palm"),
         refused(
             grasp, [](Scene& s) { s.contact.mode = ContactModeName::avoid; }, "contact.mode", "needs contact"),
         refused(
             grasp, [](Scene& s) { s.contact.mode = ContactModeName::ignore; }, "contact.mode", "needs contact"),
         refused(
             grasp, [](Scene& s) { s.contact.max_force = 0.0; }, "contact.max_force", "above 0"),
         accepted(grasp, [](Scene& s) {
           s.contact.mode = ContactModeName::require;
           s.contact.min_force = 1.0;
         })});
}

TEST(Words, OfAllKindsModesTreatmentsAndStatusesAreTheirNames) {
  const std::pair<std::string_view, std::string_view> words[] = {
      {to_string(ProblemKind::pose), "pose"},
      {to_string(ProblemKind::trajectory), "trajectory"},
      {to_string(ProblemKind::grasp), "grasp"},
      {to_string(ProblemKind::execute), "execute"},
      {to_string(ProblemKind::estimate), "estimate"},
      {to_string(ContactModeName::ignore), "ignore"},
      {to_string(ContactModeName::avoid), "avoid"},
      {to_string(ContactModeName::allow), "allow"},
      {to_string(ContactModeName::require), "require"},
      {to_string(Treatment::penalty), "penalty"},
      {to_string(Treatment::slack), "slack"},
      {to_string(Treatment::scholtes), "scholtes"},
      {to_string(Treatment::fischer_burmeister), "fischer_burmeister"},
      {to_string(PlanStatus::solved), "solved"},
      {to_string(PlanStatus::infeasible), "infeasible"},
      {to_string(PlanStatus::unstable), "unstable"},
      {to_string(PlanStatus::not_converged), "not_converged"},
      {to_string(PlanStatus::diverged), "diverged"},
      {to_string(PlanStatus::time_limit), "time_limit"},
      {to_string(PlanStatus::interrupted), "interrupted"},
      {to_string(PlanStatus::failed), "failed"}};
  for (const auto& [found, expected] : words) EXPECT_EQ(found, expected);
}

TEST(Needs, AreOfWhatHasWeightAndOfObstaclesThatAreLookedAt) {
  EXPECT_TRUE(needs_term({.plugin = "a", .weight = 1e-300, .options = {}, .position = {}}));
  EXPECT_FALSE(needs_term({.plugin = "a", .weight = 0.0, .options = {}, .position = {}}));
  Scene scene = pose_with_obstacle();
  EXPECT_TRUE(needs_obstacles(scene));
  scene.contact.mode = ContactModeName::avoid;
  EXPECT_TRUE(needs_obstacles(scene));
  scene.contact.mode = ContactModeName::ignore;
  EXPECT_FALSE(needs_obstacles(scene));
  EXPECT_FALSE(needs_obstacles(pose()));
}

}  // namespace
}  // namespace tendril
