// Starts, contacts that come and go, and what execute refuses.

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <limits>

#include "execute_support.hpp"
#include "obstacle/wall.hpp"
#include "support/contains.hpp"
#include "support/print.hpp"
#include "support/rod_bvp.hpp"
#include "tendril/error.hpp"

namespace tendril::support {
namespace {

ForwardScene one_circle(double x, double y, double radius) {
  ForwardScene s;
  s.circle(x, y, radius);
  return s;
}

// The reference's README: at moment 0.7 neither circle is touched.
TEST(ExecuteEvents, NoContactWhereTheReferenceSaysSo) {
  for (const ForwardScene& s : {one_circle(0.6, 0.3, 0.15), one_circle(0.5, 0.2, 0.1)}) {
    const Execution e = s.run({0.7});
    ASSERT_EQ(e.result.status, PlanStatus::solved) << e.result.message;
    EXPECT_TRUE(e.result.contacts.empty());
    EXPECT_NEAR(e.result.tip_x, std::sin(0.7) / 0.7, exact);
    EXPECT_NEAR(e.result.tip_y, (1.0 - std::cos(0.7)) / 0.7, exact);
  }
}

TEST(ExecuteEvents, AStartThatOverlapsEndsLikeOneThatDoesNot) {
  ForwardScene s = one_circle(0.5, 0.05, 0.1);
  const Execution overlapping = s.run({0.0});  // straight, 0.05 deep
  s.scene.start_tip_angle = -1.0;              // below the circle
  const Execution clear = s.run({0.0});
  ASSERT_EQ(overlapping.result.status, PlanStatus::solved) << overlapping.result.message;
  ASSERT_EQ(clear.result.status, PlanStatus::solved) << clear.result.message;
  ASSERT_EQ(overlapping.result.contacts.size(), 1U);
  ASSERT_EQ(clear.result.contacts.size(), 1U);
  EXPECT_LT(overlapping.result.tip_y, 0.0);
  EXPECT_NEAR(overlapping.result.tip_x, clear.result.tip_x, exact);
  EXPECT_NEAR(overlapping.result.tip_y, clear.result.tip_y, exact);
  EXPECT_NEAR(overlapping.result.contacts[0].force / clear.result.contacts[0].force, 1.0, 1e-6);
}

// Straight, with its last third beyond a wall: the rod buckles at once, to the side that its loads push it to, if any.
TEST(ExecuteEvents, AStartInsideAWallIsToldInWords) {
  for (const double moment : {0.3, 0.6, 0.9}) {
    ForwardScene s;
    s.weight(2.6487);
    ObstacleSpec wall;
    wall.name = "right wall";
    wall.shape = "wall";
    s.scene.obstacles.push_back(wall);
    s.obstacles.push_back(std::make_unique<Wall>(Vec2{2.0 / 3.0, 0.0}, Vec2{-1.0, 0.0}));
    const Execution e = s.run({moment});
    EXPECT_EQ(e.result.message.rfind("the start shape lies 333.3 mm inside 'right wall'", 0), 0U)
        << moment << ": " << e.result.message;
    EXPECT_EQ(e.result.message.find("beyond load fraction ") != std::string::npos, moment == 0.6);
  }
}

TEST(ExecuteEvents, OverlappingStartsGoToTheirOwnSide) {
  const Execution below = one_circle(0.5, 0.05, 0.1).run({0.0});
  const Execution above = one_circle(0.5, -0.05, 0.1).run({0.0});
  EXPECT_NEAR(below.result.tip_y, -above.result.tip_y, exact);
  EXPECT_GT(above.result.tip_y, 0.0);
}

TEST(ExecuteEvents, AStartThroughACoreHasNoSide) { EXPECT_THROW(one_circle(0.5, 0.0, 0.1).run({0.0}), SceneError); }

TEST(ExecuteEvents, AnObstacleAroundTheBaseIsRefused) {
  EXPECT_THROW(one_circle(0.0, 0.05, 0.1).run({0.0}), SceneError);
}

TEST(ExecuteEvents, ARisingMomentLiftsTheArmOffThePeg) {
  const ForwardScene s = unit_braced_arm();
  const Execution resting = s.run({0.5});
  ASSERT_EQ(resting.result.contacts.size(), 1U);
  const Execution lifted = s.run({1.2}, &resting.result);
  ASSERT_EQ(lifted.result.status, PlanStatus::solved) << lifted.result.message;
  EXPECT_TRUE(lifted.result.contacts.empty());
  EXPECT_EQ(lifted.contact_changes, 1);
  EXPECT_TRUE(lifted.snaps.empty());
  ForwardScene free;
  free.weight(1.682);
  const Execution same = free.run({1.2});
  EXPECT_NEAR(lifted.result.tip_x, same.result.tip_x, exact);
  EXPECT_NEAR(lifted.result.tip_y, same.result.tip_y, exact);
  // Lowered again it comes back to where it was.
  const Execution back = s.run({0.5}, &lifted.result);
  ASSERT_EQ(back.result.contacts.size(), 1U);
  EXPECT_NEAR(back.result.tip_y, resting.result.tip_y, exact);
  EXPECT_NEAR(back.result.contacts[0].force / resting.result.contacts[0].force, 1.0, 1e-6);
}

TEST(ExecuteEvents, AContactAtTheTipFollowsTheObstaclesNormal) {
  const Execution e = one_circle(0.95, 0.3, 0.08).run({2.0});
  ASSERT_EQ(e.result.status, PlanStatus::solved) << e.result.message;
  ASSERT_EQ(e.result.contacts.size(), 1U);
  const PlannedContact& c = e.result.contacts[0];
  EXPECT_TRUE(c.at_tip);
  BvpGuess guess;
  guess.angle = angle_of(e.result);
  guess.arc_lengths = {1.0};
  guess.forces = {c.force};
  const BvpSolution second = solve(RodBvp{}, {2.0}, {{{0.95, 0.3}, 0.08, true, {}}}, guess);
  EXPECT_NEAR(e.result.tip_x, second.tip_x, exact);
  EXPECT_NEAR(e.result.tip_y, second.tip_y, exact);
  EXPECT_NEAR(c.force / second.forces[0], 1.0, 1e-6);
}

// The tip catches the peg for a short while only. However long the path, it is caught and let go at the same moment.
TEST(ExecuteEvents, AShortContactIsNotSteppedOver) {
  double first = std::numeric_limits<double>::quiet_NaN();
  for (const double m : {1.0, 2.0, 4.0, 7.0}) {
    const Execution e = one_circle(1.02, 0.3, 0.08).run({m});
    ASSERT_EQ(e.result.status, PlanStatus::solved) << e.result.message;
    ASSERT_EQ(e.snaps.size(), 1U) << m;
    EXPECT_EQ(e.snaps[0].contacts_before.size(), 1U);
    EXPECT_TRUE(e.snaps[0].contacts_after.empty());
    EXPECT_NEAR(e.result.tip_x, std::sin(m) / m, exact);
    if (std::isnan(first)) first = e.snaps[0].moments[0];
    EXPECT_NEAR(e.snaps[0].moments[0], first, 1e-7) << m;
  }
}

TEST(ExecuteEvents, TheContactModeDoesNotMatter) {
  const Execution allowed = unit_braced_arm().run({0.5});
  ForwardScene s = unit_braced_arm();
  s.scene.contact.mode = ContactModeName::ignore;
  const Execution ignored = s.run({0.5});
  s.scene.contact.mode = ContactModeName::avoid;
  s.scene.contact.max_force = 0.0;
  const Execution avoided = s.run({0.5});
  for (const Execution* e : {&ignored, &avoided}) {
    ASSERT_EQ(e->result.contacts.size(), 1U);
    EXPECT_EQ(e->result.contacts[0].force, allowed.result.contacts[0].force);
  }
}

// The rod beyond the contact is an arc; once it is as curved as the circle it lies along it.
TEST(ExecuteEvents, AContactThatSpreadsIsNamed) {
  const Execution e = one_circle(0.5, -0.6, 0.55).run({-6.0});
  EXPECT_EQ(e.result.status, PlanStatus::not_converged);
  EXPECT_TRUE(contains_text(e.result.message, "contact spreads"));
  EXPECT_NEAR(e.load, 1.0 / 0.55 / 6.0, 1e-7);
}

// Both overlap the start and each other: grown to full size they leave no slit for the rod.
TEST(ExecuteEvents, ObstaclesWithoutRoomBetweenThemAreNamed) {
  ForwardScene s = one_circle(0.6, 0.1, 0.12);
  s.circle(0.62, -0.1, 0.1);
  const Execution e = s.run({0.3});
  EXPECT_EQ(e.result.status, PlanStatus::not_converged);
  EXPECT_TRUE(contains_text(e.result.message, "there is no room between them"));
  EXPECT_TRUE(e.snaps.empty());
  EXPECT_LT(e.load, 1.0);
}

TEST(ExecuteEvents, StopsWhenToldTo) {
  const ForwardScene s = unit_braced_arm();
  ExecuteControl control;
  control.time_limit = 0.0;
  EXPECT_EQ(execute(s.scene, s.obstacles, {0.5}, control).result.status, PlanStatus::time_limit);
  const std::atomic<bool> stop = true;
  control = {};
  control.stop = &stop;
  EXPECT_EQ(execute(s.scene, s.obstacles, {0.5}, control).result.status, PlanStatus::interrupted);
}

TEST(ExecuteEvents, MomentsThatMakeNoSenseAreRefused) {
  EXPECT_THROW(unit_braced_arm().run({}), Error);
  EXPECT_THROW(unit_braced_arm().run({1.0, 2.0}), Error);
  EXPECT_THROW(unit_braced_arm().run({std::numeric_limits<double>::infinity()}), Error);
}

}  // namespace
}  // namespace tendril::support
