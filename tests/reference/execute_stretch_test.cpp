// Rods that stretch (model.md section 14), against reference values and against what they must equal.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "execute_support.hpp"
#include "support/reference_table.hpp"
#include "tendril/error.hpp"

namespace tendril::support {
namespace {

ForwardScene stretching(double axial_stiffness) {
  ForwardScene s;
  s.scene.rod.segments[0].axial_stiffness = axial_stiffness;
  s.scene.coordinates.stretch_order = 1;
  return s;
}

/// Of an actuator: a tendon beside the backbone.
void make_tendon(ActuatorSpec& actuator, double offset) {
  actuator.kind = ActuatorKind::tendon;
  actuator.offset = {{0.0, offset}};
  (offset > 0.0 ? actuator.minimum : actuator.maximum) = 0.0;
}

TEST(ExecuteStretch, Table) {
  const ReferenceTable table("stretch");
  for (std::size_t row = 0; row < table.rows(); ++row) {
    SCOPED_TRACE("row " + std::to_string(row));
    const auto value = [&](const char* name) { return table.value(row, name); };
    ForwardScene s = stretching(value("axial_stiffness"));
    s.weight(value("weight"));
    s.scene.rod.base_angle = value("base_angle");
    s.scene.tip_load.force = {value("tip_force_x"), value("tip_force_y")};
    const Execution e = s.run({value("moment")});
    ASSERT_EQ(e.result.status, PlanStatus::solved) << e.result.message;
    EXPECT_NEAR(e.result.tip_x, value("tip_x"), 1e-8);
    EXPECT_NEAR(e.result.tip_y, value("tip_y"), 1e-8);
    EXPECT_NEAR(e.result.tip_angle, value("tip_angle"), 1e-8);
    EXPECT_LT(e.result.certificate.moment_balance, 1e-8);
  }
}

// P (1 + eps) = pi^2 / 4 with eps = -P / EA: what is compressed is shorter, and buckles later.
TEST(ExecuteStretch, AStraightRodHasTheMarginOfItsCompressedLength) {
  const double axial = 20.0;
  for (const double load : {1.0, 2.4}) {
    ForwardScene s = stretching(axial);
    s.scene.rod.segments[0].torsional_stiffness = 0.7;
    s.scene.tip_load.force = {-load, 0.0};
    const Execution e = s.run({0.0});
    ASSERT_EQ(e.result.status, PlanStatus::solved) << e.result.message;
    EXPECT_NEAR(e.result.tip_x, 1.0 - load / axial, 1e-10);
    EXPECT_NEAR(e.result.certificate.least_stretch, 1.0 - load / axial, 1e-10);
    const double euler = std::numbers::pi * std::numbers::pi / 4.0;
    const double margin = 1.0 - load * (1.0 - load / axial) / euler;
    EXPECT_NEAR(e.result.certificate.stability, margin, 1e-8);
    // As stiff out of its plane, it buckles out of it at the same load.
    ASSERT_TRUE(e.result.certificate.out_of_plane);
    EXPECT_NEAR(*e.result.certificate.out_of_plane, margin, 1e-8);
  }
}

TEST(ExecuteStretch, TendonsCompressWhatTheyDoNotBend) {
  const double axial = 50.0;
  const double offset = 0.05;
  const double tension = 2.0;
  ForwardScene s = stretching(axial);
  s.scene.rod.actuators.push_back(s.scene.rod.actuators[0]);
  make_tendon(s.scene.rod.actuators[0], offset);
  make_tendon(s.scene.rod.actuators[1], -offset);
  const Execution pair = s.run({tension * offset, -tension * offset});
  ASSERT_EQ(pair.result.status, PlanStatus::solved) << pair.result.message;
  const double eps = -2.0 * tension / axial;
  EXPECT_NEAR(pair.result.tip_x, 1.0 + eps, 1e-10);
  EXPECT_NEAR(pair.result.tip_y, 0.0, 1e-10);
  // Each is shorter by what the rod is.
  EXPECT_NEAR(pair.result.turns[0] * offset, -eps, 1e-10);
  EXPECT_NEAR(pair.result.turns[1] * -offset, -eps, 1e-10);
  // One alone bends it to an arc of the length that is left.
  const Execution one = s.run({tension * offset, 0.0});
  ASSERT_EQ(one.result.status, PlanStatus::solved) << one.result.message;
  const double angle = tension * offset;
  const double length = 1.0 - tension / axial;
  EXPECT_NEAR(one.result.tip_angle, angle, 1e-10);
  EXPECT_NEAR(one.result.tip_x, length * std::sin(angle) / angle, 1e-10);
  EXPECT_NEAR(one.result.tip_y, length * (1.0 - std::cos(angle)) / angle, 1e-10);
}

TEST(ExecuteStretch, AStiffRodIsOneOfFixedLength) {
  ForwardScene fixed, stiff = stretching(1e9);
  for (ForwardScene* s : {&fixed, &stiff}) s->weight(3.0).circle(0.6, -0.16, 0.1);
  const Execution a = fixed.run({0.2});
  const Execution b = stiff.run({0.2});
  ASSERT_EQ(a.result.status, PlanStatus::solved) << a.result.message;
  ASSERT_EQ(b.result.status, PlanStatus::solved) << b.result.message;
  ASSERT_EQ(a.result.contacts.size(), 1U);
  ASSERT_EQ(b.result.contacts.size(), 1U);
  EXPECT_NEAR(a.result.tip_x, b.result.tip_x, 2e-8);
  EXPECT_NEAR(a.result.tip_y, b.result.tip_y, 2e-8);
  EXPECT_NEAR(a.result.contacts[0].force, b.result.contacts[0].force, 1e-6);
  EXPECT_NEAR(a.result.certificate.stability, b.result.certificate.stability, 1e-6);
}

// Units of length along the rod are free where nothing pulls along it: a rod that tendons lengthen or shorten evenly
// touches as a rod of that length, whose stiffness against the same turn is larger by as much.
TEST(ExecuteStretch, AContactOfAnEvenlyCompressedRodIsThatOfAShorterOne) {
  const double axial = 1e5;
  const double tension = 1e4;  // so large that the contact's own pull along the rod is nothing beside it
  const double offset = 1e-3;
  ForwardScene s = stretching(axial);
  s.scene.rod.actuators.resize(3, s.scene.rod.actuators[0]);
  make_tendon(s.scene.rod.actuators[1], offset);
  make_tendon(s.scene.rod.actuators[2], -offset);
  s.circle(0.5, 0.12, 0.1);
  const double eps = -2.0 * tension / axial;
  const Execution e = s.run({1.0, tension * offset, -tension * offset});
  ASSERT_EQ(e.result.status, PlanStatus::solved) << e.result.message;
  ForwardScene shorter;
  shorter.scene.rod.segments[0].length = 1.0 + eps;
  shorter.scene.rod.segments[0].bending_stiffness = 1.0 + eps;
  shorter.scene.rod.actuators[0].to = 1.0 + eps;
  // Obstacles are made in units of the length.
  shorter.circle(0.5 / (1.0 + eps), 0.12 / (1.0 + eps), 0.1 / (1.0 + eps));
  const Execution expected = shorter.run({1.0});
  ASSERT_EQ(expected.result.status, PlanStatus::solved) << expected.result.message;
  ASSERT_EQ(e.result.contacts.size(), 1U);
  ASSERT_EQ(expected.result.contacts.size(), 1U);
  // The contact's force has a part along the rod, a share of 1e-5 of which stretches it.
  const double share = e.result.contacts[0].force / axial;
  EXPECT_NEAR(e.result.tip_x, expected.result.tip_x, 2.0 * share);
  EXPECT_NEAR(e.result.tip_y, expected.result.tip_y, 2.0 * share);
  EXPECT_NEAR(e.result.contacts[0].arc_length * (1.0 + eps), expected.result.contacts[0].arc_length, 2.0 * share);
  EXPECT_NEAR(e.result.contacts[0].force, expected.result.contacts[0].force, 10.0 * share);
  EXPECT_NEAR(e.result.certificate.stability, expected.result.certificate.stability, 20.0 * share);
  // A curvature, in units of the length.
  EXPECT_NEAR(e.result.certificate.contact_convexity * (1.0 + eps), expected.result.certificate.contact_convexity,
              100.0 * share);
}

TEST(ExecuteStretch, ContactsDoNotRub) {
  ForwardScene s = stretching(50.0);
  s.circle(0.5, 0.12, 0.1);
  ExecuteControl control;
  control.friction = {0.3};
  EXPECT_THROW(execute(s.scene, s.obstacles, {0.5}, control), Error);
}

TEST(ExecuteStretch, ARodThatIsCompressedToNothingIsRefused) {
  ForwardScene s = stretching(1.5);
  s.scene.rod.actuators.push_back(s.scene.rod.actuators[0]);
  make_tendon(s.scene.rod.actuators[0], 0.1);
  make_tendon(s.scene.rod.actuators[1], -0.1);
  const Execution e = s.run({0.1, -0.1});
  EXPECT_EQ(e.result.status, PlanStatus::not_converged);
  EXPECT_EQ(e.result.message.rfind("the rod is compressed to nothing: 1 + its stretch falls to -3.333", 0), 0U)
      << e.result.message;
}

}  // namespace
}  // namespace tendril::support
