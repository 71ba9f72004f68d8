// Rods that are moved as a whole: what is drawn into a port is not there, and a moved base carries everything with it.

#include <cmath>
#include <numbers>

#include "support.hpp"
#include "tendril/execute.hpp"
#include "tendril/trajectory.hpp"

namespace tendril::combination {
namespace {

/// An arm that braces on a peg, of a rod of another length.
Scene brace_of(const char* length, const std::vector<std::string>& more) {
  std::vector<std::string> all{std::string("rod.length=\"") + length + '"'};
  all.insert(all.end(), more.begin(), more.end());
  return scene("brace", all);
}

std::vector<std::unique_ptr<Obstacle>> obstacles_of(const Scene& made) {
  return plugins::make_obstacles(registry(), made);
}

void expect_same(const Plan& found, const Plan& expected, double within, double drawn_in = 0.0) {
  EXPECT_NEAR(found.tip_x, expected.tip_x, within);
  EXPECT_NEAR(found.tip_y, expected.tip_y, within);
  EXPECT_NEAR(found.tip_angle, expected.tip_angle, 10.0 * within);
  ASSERT_EQ(found.moments.size(), expected.moments.size());
  for (std::size_t a = 0; a < found.moments.size(); ++a) EXPECT_NEAR(found.moments[a], expected.moments[a], within);
  ASSERT_EQ(found.contacts.size(), expected.contacts.size());
  for (std::size_t k = 0; k < found.contacts.size(); ++k) {
    EXPECT_NEAR(found.contacts[k].force, expected.contacts[k].force, 10.0 * within);
    EXPECT_NEAR(found.contacts[k].arc_length - drawn_in, expected.contacts[k].arc_length, 10.0 * within);
  }
}

TEST(Insertion, AFixedOneIsThatOfAShorterRod) {
  const Plan shorter = plan(scene("brace"));
  const Plan inserted = plan(brace_of("150 mm", {"rod.insertion.value=\"100 mm\""}));
  ASSERT_TRUE(certified(inserted));
  expect_same(inserted, shorter, 1e-12);
  EXPECT_NEAR(inserted.objective, shorter.objective, 1e-12);
}

TEST(Insertion, HeldWhereItMayMoveItIsThatOfAShorterRod) {
  const Scene shorter = scene("brace");
  const Scene longer = brace_of("150 mm", {"rod.insertion.min=\"60 mm\"", "rod.insertion.max=\"150 mm\""});
  const std::vector<double> moments{2.2e-3};
  const Execution expected = execute(shorter, obstacles_of(shorter), moments);
  ASSERT_TRUE(certified(expected.result));
  ExecuteControl control;
  control.place.insertion = 0.1;
  const Execution held = execute(longer, obstacles_of(longer), moments, control);
  ASSERT_TRUE(certified(held.result));
  EXPECT_EQ(held.result.place.insertion, 0.1);
  expect_same(held.result, expected.result, 1e-10, 0.05);
  // Out at 80 mm first, it is then pushed on.
  control.place.insertion = 0.08;
  const Execution before = execute(longer, obstacles_of(longer), moments, control);
  ASSERT_TRUE(certified(before.result));
  control.start = &before.result;
  control.place.insertion = 0.1;
  const Execution pushed = execute(longer, obstacles_of(longer), moments, control);
  ASSERT_TRUE(certified(pushed.result));
  EXPECT_GT(pushed.steps, 0);
  expect_same(pushed.result, expected.result, 1e-10, 0.05);
}

TEST(Insertion, OfAPlanIsAsGoodAsThatOfAShorterRod) {
  const Scene longer = brace_of("150 mm", {"rod.insertion.min=\"70 mm\"", "rod.insertion.max=\"130 mm\""});
  Plan chosen = plan(longer);
  ASSERT_TRUE(certified(chosen));
  ASSERT_TRUE(chosen.place.insertion);
  const Plan fixed = plan(scene("brace"));
  EXPECT_LT(chosen.objective, fixed.objective);
  // A rod of this length does the same under the same moment.
  Scene held = scene("brace", {"rod.length=\"130 mm\""});
  held.rod = out_of_port(held.rod, *chosen.place.insertion);
  const Execution shorter = execute(held, obstacles_of(held), chosen.moments);
  ASSERT_TRUE(certified(shorter.result));
  expect_same(shorter.result, chosen, 1e-9, *chosen.place.insertion - 0.13);
  const Execution executed = verify(longer, obstacles_of(longer), chosen);
  EXPECT_TRUE(certified(executed.result));
  ASSERT_TRUE(chosen.local_model_error);
  EXPECT_LT(*chosen.local_model_error, 1e-8);
}

TEST(Insertion, ATrajectoryThatOnlyInsertsNeedsNoSolverWhileContactsStay) {
  Scene pushed = brace_of("150 mm", {"rod.insertion.min=\"80 mm\"", "rod.insertion.max=\"150 mm\""});
  pushed.rod.actuators[0].minimum = pushed.rod.actuators[0].maximum = 2.2e-3;
  Problem problem = combination::problem(pushed);
  std::vector<TargetSpec> targets;
  for (int i = 0; i < 12; ++i) {
    targets.emplace_back().position = Vec2{0.094 + 0.0008 * i, 0.02 + 0.0003 * i};
  }
  const Trajectory trajectory =
      plan_trajectory(targets, {}, [&](const TargetSpec& target, const Plan* start, bool follow) {
        problem.set_target(target);
        PlanControl control;
        control.start = start;
        control.follow = follow;
        return problem.plan(control);
      });
  ASSERT_TRUE(trajectory.solved());
  double before = 0.0;
  for (std::size_t i = 0; i < trajectory.steps.size(); ++i) {
    const TrajectoryStep& step = trajectory.steps[i];
    if (i > 0) {
      EXPECT_EQ(step.effort.solver_calls, 0) << i;
    }
    EXPECT_GT(*step.plan.place.insertion, before) << i;
    ASSERT_EQ(step.plan.contacts.size(), 1U);
    before = *step.plan.place.insertion;
  }
}

TEST(Insertion, AmongEightPegsIsPlannedByEverySolver) {
  for (const std::string& solver : solvers_to_combine()) {
    SCOPED_TRACE(solver);
    const Scene pegs = scene("inserted", {"solver.plugin=" + solver, "search.effort=fast"});
    Plan found = plan(pegs);
    ASSERT_TRUE(certified(found));
    EXPECT_NEAR(*found.place.insertion, 0.180794, 1e-6);
    EXPECT_LT(*found.target_error, 1e-6);
    verify(pegs, obstacles_of(pegs), found);
    EXPECT_TRUE(certified(found));
    EXPECT_LT(*found.model_error, 1e-8);
  }
}

/// Two segments, two actuators and a load, whose ends a port may pass.
Scene jointed(const std::vector<std::string>& more) {
  std::vector<std::string> all{"rod.insertion.min=\"60 mm\"", "rod.insertion.max=\"150 mm\""};
  all.insert(all.end(), more.begin(), more.end());
  return scene_from_text(R"(
title = "jointed"
problem = "pose"
gravity = [0, -9.81]
[[rod.segment]]
length = "60 mm"
bending_stiffness = "1e-3 N m^2"
linear_density = "84 g/m"
[[rod.segment]]
length = "90 mm"
bending_stiffness = "4.9e-4 N m^2"
linear_density = "60 g/m"
[[rod.actuator]]
to = "70 mm"
limit = "6 N mm"
[[rod.actuator]]
limit = "2.5 N mm"
[[rod.load]]
at = "40 mm"
mass = "2 g"
[rod.insertion]
[coordinates]
plugin = "legendre"
order = 6
[start]
tip_angle = "0.5 rad"
[[obstacle]]
shape = "circle"
center = ["48 mm", "0 mm"]
radius = "8 mm"
[contact]
max_force = "1 N"
[target]
position = ["78 mm", "16 mm"]
[[objective]]
plugin = "tip_pose"
weight = 100
[[objective]]
plugin = "actuation_effort"
weight = 1e-4
[solver]
plugin = "nlopt"
)",
                         all);
}

// Knots at 40, 60 and 70 mm.
TEST(Insertion, PassesEndsOfSegmentsActuatorsAndLoads) {
  const Scene whole = jointed({});
  const std::vector<double> moments{1e-3, 1.5e-3};
  ExecuteControl control;
  Execution last;
  // Drawn in and pushed out again, at knots and between them.
  for (const double insertion : {0.145, 0.1, 0.09, 0.085, 0.07, 0.09, 0.13}) {
    SCOPED_TRACE(insertion);
    control.place.insertion = insertion;
    const Execution here = execute(whole, obstacles_of(whole), moments, control);
    ASSERT_TRUE(certified(here.result));
    Scene shorter = whole;
    shorter.rod = jointed({"rod.insertion.min=\"150 mm\""}).rod;
    std::vector<double> left = moments;
    if (insertion <= 0.08) {  // the first actuator is all inside
      shorter.rod.actuators.erase(shorter.rod.actuators.begin());
      left.erase(left.begin());
    }
    shorter.rod = out_of_port(shorter.rod, insertion);
    const Execution expected = execute(shorter, obstacles_of(shorter), left);
    ASSERT_TRUE(certified(expected.result));
    EXPECT_NEAR(here.result.tip_x, expected.result.tip_x, 1e-10);
    EXPECT_NEAR(here.result.tip_y, expected.result.tip_y, 1e-10);
    EXPECT_NEAR(*here.result.place.insertion, insertion, 1e-15);
    last = here;
    control.start = &last.result;
  }
}

TEST(Insertion, OfAPlanIsSoughtInEveryStretch) {
  const Scene whole = jointed({});
  const Plan best = plan(whole);
  ASSERT_TRUE(certified(best));
  double least = infinity;
  // In one stretch alone no plan is better, and the best of them is as good.
  for (const auto& [low, high] : {std::pair("60 mm", "80 mm"), std::pair("80 mm", "90 mm"),
                                  std::pair("90 mm", "110 mm"), std::pair("110 mm", "150 mm")}) {
    SCOPED_TRACE(low);
    const Plan one = plan(
        jointed({std::string("rod.insertion.min=\"") + low + '"', std::string("rod.insertion.max=\"") + high + '"'}));
    if (one.status != PlanStatus::solved) continue;
    EXPECT_GE(one.objective, best.objective - 1e-7);
    least = std::min(least, one.objective);
  }
  EXPECT_NEAR(best.objective, least, 1e-6);
  Plan checked = best;
  verify(whole, obstacles_of(whole), checked, {.start = &best});
  EXPECT_TRUE(certified(checked));
}

// Where the base moves with its surroundings nothing changes but their place.
TEST(Base, MovedIsASceneThatStandsThere) {
  const Vec2 at{0.03, -0.01};
  const double turn = 0.4;
  Scene there = scene("brace");
  there.rod.base_position = at;
  there.rod.base_angle = turn;
  const std::vector<double> moments{2.2e-3};
  const Execution expected = execute(there, obstacles_of(there), moments);
  ASSERT_TRUE(certified(expected.result));
  const Scene here = scene("brace");
  ExecuteControl control;
  control.place.base = {at, turn};
  const Execution moved = execute(here, obstacles_of(here), moments, control);
  ASSERT_TRUE(certified(moved.result));
  expect_same(moved.result, expected.result, 1e-10);
  // Led there from where the scene has it.
  control.place = {};
  const Execution before = execute(here, obstacles_of(here), moments, control);
  ASSERT_TRUE(certified(before.result));
  control.start = &before.result;
  control.place.base = {at, turn};
  const Execution led = execute(here, obstacles_of(here), moments, control);
  EXPECT_GT(led.steps, 0);
  ASSERT_TRUE(certified(led.result));
}

// It begins where it is, whatever stands where it is led to.
TEST(Base, LoweredOntoAnObstacleLiesOnIt) {
  const Scene here = scene("brace");
  const std::vector<double> moments{2.2e-3};
  const Execution expected = execute(here, obstacles_of(here), moments);
  ASSERT_EQ(expected.result.contacts.size(), 1U);
  ExecuteControl control;
  control.place.base = {{0.0, 0.03}, 0.0};
  const Execution above = execute(here, obstacles_of(here), moments, control);
  ASSERT_TRUE(certified(above.result));
  ASSERT_TRUE(above.result.contacts.empty());
  control.start = &above.result;
  control.place.base = {{}, 0.0};
  const Execution lowered = execute(here, obstacles_of(here), moments, control);
  ASSERT_TRUE(certified(lowered.result));
  EXPECT_EQ(lowered.result.message, "");
  EXPECT_EQ(lowered.contact_changes, 1);
  expect_same(lowered.result, expected.result, 1e-10);
}

TEST(Base, OfAPlanReachesWhatAFixedOneCannot) {
  const std::vector<std::string> range{"rod.base.position_range=[[\"-20 mm\", \"-20 mm\"], [\"20 mm\", \"20 mm\"]]",
                                       "rod.base.angle_range=[\"-20 deg\", \"30 deg\"]"};
  for (const std::string& solver : solvers_to_combine()) {
    SCOPED_TRACE(solver);
    std::vector<std::string> all = range;
    all.push_back("solver.plugin=" + solver);
    const Scene movable = scene("brace", all);
    Plan chosen = plan(movable);
    ASSERT_TRUE(certified(chosen));
    ASSERT_TRUE(chosen.place.base);
    EXPECT_LT(chosen.objective, plan(scene("brace")).objective);
    Scene held = scene("brace");
    held.rod.base_position = chosen.place.base->position;
    held.rod.base_angle = chosen.place.base->angle;
    const Execution expected = execute(held, obstacles_of(held), chosen.moments, {.start = &chosen});
    ASSERT_TRUE(certified(expected.result));
    EXPECT_NEAR(expected.result.tip_x, chosen.tip_x, 1e-9);
    EXPECT_NEAR(expected.result.tip_y, chosen.tip_y, 1e-9);
  }
}

}  // namespace
}  // namespace tendril::combination
