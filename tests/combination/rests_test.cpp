// Plans that begin where the rod rests: models of many coordinates, and scenes whose only equilibria are unstable.

#include <string>

#include "support.hpp"
#include "support/contains.hpp"
#include "support/print.hpp"
#include "tendril/tolerances.hpp"

namespace tendril::combination {
namespace {

/// Functions so many that a program of all of them is slow: the moments alone are chosen.
TEST(Rests, ManyFunctionsArePlannedAsFewAre) {
  const Plan smooth = plan(scene("brace"));
  ASSERT_TRUE(certified(smooth));
  for (const std::string& solver : registry().names(ComponentKind::solver)) {
    SCOPED_TRACE(solver);
    Scene many = scene("brace", {"coordinates.order=20", "coordinates.pieces=8"});
    many.solver.plugin = solver;
    const Plan found = plan(many);
    ASSERT_EQ(found.status, PlanStatus::solved) << found.message;
    EXPECT_TRUE(certified(found));
    EXPECT_GT(found.coordinates.size(), 150u);
    // Six functions leave 1e-6 of the rod out.
    EXPECT_NEAR(found.objective, smooth.objective, 1e-3 * smooth.objective);
    ASSERT_EQ(found.contacts.size(), 1u);
    EXPECT_NEAR(found.contacts[0].force, smooth.contacts[0].force, 1e-3 * smooth.contacts[0].force);
    EXPECT_NEAR(found.tip_x, smooth.tip_x, 1e-5);
    EXPECT_NEAR(found.tip_y, smooth.tip_y, 1e-5);
  }
}

/// Four arcs without load have to press their tip against a thin body behind them: the moment bends them there only as
/// far as they would rather spring away to either side.
std::string pressed_from_behind(const std::string& solver) {
  return R"(problem = "pose"
[rod]
[[rod.segment]]
length = "0.5407 m"
bending_stiffness = "0.72 N m^2"
linear_density = 0
[[rod.segment]]
length = "0.4593 m"
bending_stiffness = "1 N m^2"
linear_density = 0
[[rod.actuator]]
limit = "3.17 N m"
[coordinates]
plugin = "pcc"
pieces = 4
[start]
tip_angle = 1.029
[[obstacle]]
name = "behind"
shape = "capsule"
from = ["0.1988 m", "-0.806 m"]
to = ["-0.2333 m", "-1.5341 m"]
radius = "0.0148 m"
[contact]
mode = "require"
min_force = "0.2576 N"
[target]
position = ["-0.1646 m", "-0.4649 m"]
[[objective]]
plugin = "tip_pose"
weight = 60
[[objective]]
plugin = "actuation_effort"
weight = 4e-6
[solver]
plugin = ")" +
         solver + "\"\n";
}

TEST(Rests, WhatIsOnlyUnstableIsInfeasible) {
  int shown = 0;
  for (const std::string& solver : registry().names(ComponentKind::solver)) {
    SCOPED_TRACE(solver);
    const Plan none = plan(scene_from_text(pressed_from_behind(solver)));
    EXPECT_EQ(none.status, PlanStatus::infeasible) << none.message;
    EXPECT_TRUE(contains_text(none.message, "from 5 starts"));
    // The equilibrium that there is, and is not stable, is shown where the search came by it.
    if (none.contacts.empty()) continue;
    ++shown;
    EXPECT_TRUE(contains_text(none.message, "margin of stability"));
    EXPECT_LE(none.certificate.equilibrium, tolerance::equilibrium);
    EXPECT_LT(none.certificate.stability, 0.0);
  }
  EXPECT_GT(shown, 0);
}

}  // namespace
}  // namespace tendril::combination
