// Contacts that push off their normals: given ratios against reference values, and what friction can do to a plan.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "execute_support.hpp"
#include "support/contains.hpp"
#include "support/print.hpp"
#include "support/reference_table.hpp"

namespace tendril::support {
namespace {

Execution rubbed(const ForwardScene& s, const Plan& start, const std::vector<double>& ratios) {
  ExecuteControl control;
  control.start = &start;
  control.friction = ratios;
  return execute(s.scene, s.obstacles, start.moments, control);
}

TEST(ExecuteFriction, BracedArmTable) {
  const ReferenceTable table("friction");
  for (std::size_t row = 0; row < table.rows(); ++row) {
    SCOPED_TRACE("row " + std::to_string(row));
    const ForwardScene s = braced_arm();
    const Execution without = s.run({table.value(row, "moment")});
    ASSERT_EQ(without.result.status, PlanStatus::solved) << without.result.message;
    const double ratio = table.value(row, "friction_ratio");
    const Execution e = rubbed(s, without.result, {ratio});
    ASSERT_EQ(e.result.status, PlanStatus::solved) << e.result.message;
    ASSERT_EQ(e.result.contacts.size(), 1U);
    const PlannedContact& c = e.result.contacts[0];
    EXPECT_NEAR(e.result.tip_x, table.value(row, "tip_x"), 1e-10);
    EXPECT_NEAR(e.result.tip_y, table.value(row, "tip_y"), 1e-10);
    EXPECT_NEAR(e.result.tip_angle, table.value(row, "tip_angle"), 1e-9);
    EXPECT_NEAR(c.arc_length, table.value(row, "arc_length"), 1e-10);
    EXPECT_NEAR(c.force / table.value(row, "normal_force"), 1.0, 1e-7);
    EXPECT_NEAR(c.tangential / c.force, ratio, 1e-12);
    EXPECT_LE(e.result.certificate.moment_balance, 1e-9);
  }
}

// Loads and friction may grow together: what is reached is the same.
TEST(ExecuteFriction, OnePathIsAsGoodAsTwo) {
  const ForwardScene s = braced_arm();
  const Execution without = s.run({1e-3});
  const Execution after = rubbed(s, without.result, {0.5});
  ExecuteControl control;
  control.friction = {0.5};
  const Execution at_once = execute(s.scene, s.obstacles, {1e-3}, control);
  ASSERT_EQ(at_once.result.status, PlanStatus::solved) << at_once.result.message;
  EXPECT_NEAR(at_once.result.tip_x, after.result.tip_x, 1e-10);
  EXPECT_NEAR(at_once.result.tip_y, after.result.tip_y, 1e-10);
  EXPECT_NEAR(at_once.result.contacts.at(0).force / after.result.contacts.at(0).force, 1.0, 1e-7);
  EXPECT_NEAR(at_once.result.certificate.stability, after.result.certificate.stability, 1e-7);
}

// A mirrored scene is pushed along the rod, not to one side.
TEST(ExecuteFriction, TheMirrorImageIsTheSame) {
  const ForwardScene s = braced_arm();
  ForwardScene mirrored = braced_arm();
  mirrored.scene.gravity = Vec2{0.0, 9.81};
  mirrored.scene.start_tip_angle = -0.5;
  for (const double ratio : {-0.6, 0.4}) {
    const Execution one = rubbed(s, s.run({1e-3}).result, {ratio});
    const Execution other = rubbed(mirrored, mirrored.run({-1e-3}).result, {ratio});
    ASSERT_EQ(one.result.status, PlanStatus::solved) << one.result.message;
    ASSERT_EQ(other.result.status, PlanStatus::solved) << other.result.message;
    EXPECT_NEAR(one.result.tip_x, other.result.tip_x, 1e-12);
    EXPECT_NEAR(one.result.tip_y, -other.result.tip_y, 1e-12);
    EXPECT_NEAR(one.result.contacts.at(0).tangential, other.result.contacts.at(0).tangential, 1e-10);
  }
}

// On a thick rod the tangential force acts at the surface: the local balance of moments knows its couple.
TEST(ExecuteFriction, OnAThickRodItActsOnTheSurface) {
  const auto pressed = [](double radius, double ratio) {
    ForwardScene s = braced_arm();
    s.scene.rod.segments[0].thickness = 2.0 * radius;
    const Execution without = s.run({1e-3});
    EXPECT_EQ(without.result.status, PlanStatus::solved) << without.result.message;
    return rubbed(s, without.result, {ratio});
  };
  const Execution thick = pressed(4e-3, 0.5);
  ASSERT_EQ(thick.result.status, PlanStatus::solved) << thick.result.message;
  EXPECT_LE(thick.result.certificate.moment_balance, 1e-8);
  // Without the couple it would be a thin rod on a grown circle.
  ForwardScene grown = braced_arm();
  grown.obstacles.clear();
  grown.scene.obstacles.clear();
  grown.circle(0.6, 0.0, 0.12);
  const Execution thin = rubbed(grown, grown.run({1e-3}).result, {0.5});
  ASSERT_EQ(thin.result.status, PlanStatus::solved) << thin.result.message;
  const double bend = 4e-3 * thick.result.contacts.at(0).tangential / 4.9e-4 * 0.05;
  EXPECT_GT(std::abs(thick.result.tip_angle - thin.result.tip_angle), 0.1 * std::abs(bend));
}

TEST(ExecuteFriction, RefusesRatiosOfOtherObstacles) {
  const ForwardScene s = braced_arm();
  const Execution without = s.run({0.0});
  EXPECT_THROW(rubbed(s, without.result, {0.1, 0.2}), Error);
}

}  // namespace
}  // namespace tendril::support
