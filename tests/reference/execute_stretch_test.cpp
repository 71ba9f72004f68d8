// Rods that stretch (model.md section 14), against reference values and against what they must equal.

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <numbers>

#include "execute_support.hpp"
#include "support/reference_table.hpp"

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

/// A rod with a moment u along it and one contact with a circle, by shooting from the contact to the base: beyond it
/// the rod is an arc that is not stretched, before it the force of the contact bends and stretches it. L = EI = 1.
struct RubbedArc {
  double moment = 0.0, axial = 0.0, body = 0.0;  ///< the last: radius of the rod
  Vec2 center{};
  double radius = 0.0;
  double side = 1.0;  ///< of the normal along the rod's own

  struct State {
    double angle = 0.0, place = 0.5, force = 0.0, ratio = 0.0;
    Vec2 tip{};
    double stretch = 1.0;    ///< right before the contact
    double curvature = 0.0;  ///< the mean of what it is on both sides
    Vec2 base{};
    double base_angle = 0.0;
  };

  /// Everything that follows from the angle, place, force and ratio of the contact.
  void integrate(State& at) const {
    const auto tangent = [](double angle) { return Vec2{std::cos(angle), std::sin(angle)}; };
    const Vec2 n = side * turned(tangent(at.angle));
    const Vec2 touched = center + (radius + body) * n;
    const Vec2 push = at.force * (n + at.ratio * tangent(at.angle));
    // On the surface, at -r n from the backbone.
    const double couple = cross(-body * n, at.force * at.ratio * tangent(at.angle));
    struct Rate {
      Vec2 p;
      double angle;
    };
    const auto rate = [&](Vec2 p, double angle) -> Rate {
      const double stretch = 1.0 + dot(push, tangent(angle)) / axial;
      return {stretch * tangent(angle), moment + couple + cross(touched - p, push)};
    };
    constexpr int steps = 400;
    const double h = -at.place / steps;
    Vec2 p = touched;
    double angle = at.angle;
    for (int i = 0; i < steps; ++i) {
      const Rate a = rate(p, angle);
      const Rate b = rate(p + 0.5 * h * a.p, angle + 0.5 * h * a.angle);
      const Rate c = rate(p + 0.5 * h * b.p, angle + 0.5 * h * b.angle);
      const Rate e = rate(p + h * c.p, angle + h * c.angle);
      p += h / 6.0 * (a.p + 2.0 * b.p + 2.0 * c.p + e.p);
      angle += h / 6.0 * (a.angle + 2.0 * b.angle + 2.0 * c.angle + e.angle);
    }
    at.base = p;
    at.base_angle = angle;
    at.stretch = 1.0 + dot(push, tangent(at.angle)) / axial;
    at.curvature = moment + 0.5 * couple;
    const double left = 1.0 - at.place;
    const double half = 0.5 * moment * left;
    const double chord = std::abs(half) > 0.0 ? left * std::sin(half) / half : left;
    at.tip = touched + chord * tangent(at.angle + half);
  }

  /// Solves rows(state) = 0 for the first of (angle, place, force, ratio), as many as there are rows.
  template <class Rows>
  void solve(State& at, const Rows& rows) const {
    const auto values = [&](State s) {
      integrate(s);
      return rows(s);
    };
    const std::array<double State::*, 4> unknown{&State::angle, &State::place, &State::force, &State::ratio};
    for (int round = 0; round < 20; ++round) {
      const auto now = values(at);
      Eigen::MatrixXd jacobian(now.size(), now.size());
      for (Eigen::Index c = 0; c < now.size(); ++c) {
        constexpr double step = 1e-6;
        State above = at, below = at;
        above.*unknown[static_cast<std::size_t>(c)] += step;
        below.*unknown[static_cast<std::size_t>(c)] -= step;
        jacobian.col(c) = (values(above) - values(below)) / (2.0 * step);
      }
      const Eigen::VectorXd change = jacobian.partialPivLu().solve(now);
      for (Eigen::Index c = 0; c < now.size(); ++c) at.*unknown[static_cast<std::size_t>(c)] -= change[c];
      if (change.cwiseAbs().maxCoeff() < 1e-12) break;
    }
    integrate(at);
  }

  /// From what was executed, which is near.
  State begin(const PlannedContact& c, double ratio) const {
    const double angle = std::atan2(c.tangent.y, c.tangent.x);
    return {angle, c.arc_length, c.force, ratio};
  }
};

RubbedArc arc_of(const ForwardScene& s, double moment, const Plan& reached) {
  const PlannedContact& c = reached.contacts.at(0);
  const double body = 0.5 * s.scene.rod.segments[0].thickness;
  return {moment, s.scene.rod.segments[0].axial_stiffness,
          body,   {0.5, 0.12},
          0.1,    dot(c.normal, turned(c.tangent)) < 0.0 ? -1.0 : 1.0};
}

ForwardScene rubbing(double axial, double thickness) {
  ForwardScene s = stretching(axial);
  s.scene.rod.segments[0].thickness = thickness;
  s.circle(0.5, 0.12, 0.1);
  return s;
}

TEST(ExecuteStretch, AContactThatRubsBendsAndStretchesWhatLiesBeforeIt) {
  for (const double axial : {8.0, 100.0}) {
    for (const double thickness : {0.0, 0.03}) {
      for (const double ratio : {-0.6, 0.4}) {
        SCOPED_TRACE(std::to_string(axial) + ", " + std::to_string(thickness) + ", " + std::to_string(ratio));
        const ForwardScene s = rubbing(axial, thickness);
        const Execution without = s.run({1.0});
        ASSERT_EQ(without.result.status, PlanStatus::solved) << without.result.message;
        ExecuteControl control;
        control.start = &without.result;
        control.friction = {ratio};
        const Execution e = execute(s.scene, s.obstacles, {1.0}, control);
        ASSERT_EQ(e.result.status, PlanStatus::solved) << e.result.message;
        ASSERT_EQ(e.result.contacts.size(), 1U);
        const PlannedContact& c = e.result.contacts[0];
        EXPECT_NEAR(c.tangential / c.force, ratio, 1e-12);
        const RubbedArc arc = arc_of(s, 1.0, e.result);
        RubbedArc::State exact = arc.begin(c, ratio);
        arc.solve(exact,
                  [](const RubbedArc::State& at) { return Eigen::Vector3d(at.base.x, at.base.y, at.base_angle); });
        EXPECT_NEAR(e.result.tip_x, exact.tip.x, 1e-8);
        EXPECT_NEAR(e.result.tip_y, exact.tip.y, 1e-8);
        EXPECT_NEAR(c.arc_length, exact.place, 1e-8);
        EXPECT_NEAR(c.force / exact.force, 1.0, 1e-7);
        EXPECT_GT(std::abs(exact.stretch - 1.0), 1e-4);
        EXPECT_LE(e.result.certificate.moment_balance, 1e-8);
      }
    }
  }
}

// What touches stays where it is on both surfaces, along which the contact rolls: on the obstacle as far as on the rod,
// whose length there is the mean of what it is on both sides.
TEST(ExecuteStretch, AContactThatSticksHoldsTheStretchedRod) {
  for (const double thickness : {0.0, 0.03}) {
    SCOPED_TRACE(thickness);
    ForwardScene s = rubbing(8.0, thickness);
    const Execution without = s.run({1.0});
    ASSERT_EQ(without.result.status, PlanStatus::solved) << without.result.message;
    s.scene.contact.friction = 5.0;
    const Execution e = s.run({1.3}, &without.result);
    ASSERT_EQ(e.result.status, PlanStatus::solved) << e.result.message;
    ASSERT_EQ(e.result.contacts.size(), 1U);
    const PlannedContact& c = e.result.contacts[0];
    EXPECT_TRUE(c.sticks);
    RubbedArc arc = arc_of(s, 1.0, without.result);
    RubbedArc::State at = arc.begin(without.result.contacts.at(0), 0.0);
    arc.solve(at, [](const RubbedArc::State& now) { return Eigen::Vector3d(now.base.x, now.base.y, now.base_angle); });
    // Of the body's surface on the side of the obstacle, per arc length.
    const auto length = [&](const RubbedArc::State& now) {
      return 0.5 * (1.0 + now.stretch) + arc.side * arc.body * now.curvature;
    };
    constexpr int steps = 300;
    for (int i = 1; i <= steps; ++i) {
      const RubbedArc::State before = at;
      arc.moment = 1.0 + 0.3 * i / steps;
      arc.solve(at, [&](const RubbedArc::State& now) {
        // The normal turns with the rod.
        const double on_obstacle = -arc.side * arc.radius * (now.angle - before.angle);
        const double on_rod = 0.5 * (length(now) + length(before)) * (now.place - before.place);
        return Eigen::Vector4d(now.base.x, now.base.y, now.base_angle, on_obstacle - on_rod);
      });
    }
    EXPECT_NEAR(e.result.tip_x, at.tip.x, 1e-6);
    EXPECT_NEAR(e.result.tip_y, at.tip.y, 1e-6);
    EXPECT_NEAR(c.arc_length, at.place, 1e-6);
    EXPECT_NEAR(c.tangential / c.force, at.ratio, 1e-5);
    EXPECT_GT(std::abs(at.ratio), 1e-3);
  }
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
