// Tendons that are told their length: the tension is what it takes (model.md section 6).

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "execute_support.hpp"

namespace tendril::support {
namespace {

void make_tendon(ActuatorSpec& tendon, const std::vector<OffsetPoint>& offset) {
  tendon.kind = ActuatorKind::tendon;
  tendon.offset = offset;
  (tendon.largest_offset() > 0.0 ? tendon.minimum : tendon.maximum) = 0.0;
}

/// A rod between two tendons. `end`: their distance at the tip over that at the base.
ForwardScene between_tendons(double offset, double end) {
  ForwardScene s;
  s.scene.rod.actuators.resize(2, s.scene.rod.actuators[0]);
  make_tendon(s.scene.rod.actuators[0], {{0.0, offset}, {1.0, end * offset}});
  make_tendon(s.scene.rod.actuators[1], {{0.0, -offset}, {1.0, -end * offset}});
  return s;
}

void tell_lengths(ForwardScene& s) {
  for (ActuatorSpec& a : s.scene.rod.actuators) a.by_length = a.kind == ActuatorKind::tendon;
}

/// Executes tensions, then the lengths that they gave, then the tensions that these gave.
void expect_inverse(const ForwardScene& by_tension, const std::vector<double>& tensions) {
  ForwardScene by_length;
  by_length.scene = by_tension.scene;
  tell_lengths(by_length);
  std::vector<double> moments;
  for (std::size_t a = 0; a < tensions.size(); ++a) {
    moments.push_back(by_tension.scene.rod.actuators[a].moment_of(tensions[a]));
  }
  const Execution pulled = by_tension.run(moments);
  ASSERT_EQ(pulled.result.status, PlanStatus::solved) << pulled.result.message;
  const std::vector<double> held = held_of(by_length.scene, pulled.result);
  const Execution drawn = execute(by_length.scene, by_tension.obstacles, held);
  ASSERT_EQ(drawn.result.status, PlanStatus::solved) << drawn.result.message;
  const Execution again = by_tension.run(drawn.result.moments);
  ASSERT_EQ(again.result.status, PlanStatus::solved) << again.result.message;
  for (const Execution* e : {&drawn, &again}) {
    EXPECT_NEAR(e->result.tip_x, pulled.result.tip_x, 1e-10);
    EXPECT_NEAR(e->result.tip_y, pulled.result.tip_y, 1e-10);
    EXPECT_NEAR(e->result.tip_angle, pulled.result.tip_angle, 1e-10);
    ASSERT_EQ(e->result.contacts.size(), pulled.result.contacts.size());
    for (std::size_t k = 0; k < pulled.result.contacts.size(); ++k) {
      EXPECT_NEAR(e->result.contacts[k].force, pulled.result.contacts[k].force, 1e-9);
    }
    for (std::size_t a = 0; a < moments.size(); ++a) EXPECT_NEAR(e->result.moments[a], moments[a], 1e-9) << a;
  }
  // What is held by its length is stiffer than what is held by its tension.
  EXPECT_GT(drawn.result.certificate.held_lengths, 0);
  EXPECT_EQ(pulled.result.certificate.held_lengths, 0);
  EXPECT_GE(drawn.result.certificate.stability, pulled.result.certificate.stability - 1e-9);
}

TEST(ExecuteLength, OneTendonBendsTheRodToAnArcOfItsShortening) {
  ForwardScene s = between_tendons(0.05, 1.0);
  tell_lengths(s);
  const Execution e = s.run({0.04, -0.04});
  ASSERT_EQ(e.result.status, PlanStatus::solved) << e.result.message;
  EXPECT_NEAR(e.result.tip_angle, 0.8, 1e-10);
  EXPECT_NEAR(e.result.moments[0], 0.8, 1e-10);
  EXPECT_NEAR(e.result.moments[1], 0.0, 1e-12);
  EXPECT_EQ(e.result.certificate.held_lengths, 1);
  EXPECT_GE(e.tendon_changes, 1);
  EXPECT_EQ(e.contact_changes, 0);
}

TEST(ExecuteLength, ATendonThatIsLongerThanItsWayIsSlack) {
  ForwardScene s = between_tendons(0.05, 1.0);
  tell_lengths(s);
  s.scene.start_tip_angle = 0.3;
  const Execution e = s.run({-0.01, -0.02});
  ASSERT_EQ(e.result.status, PlanStatus::solved) << e.result.message;
  EXPECT_NEAR(e.result.tip_angle, 0.0, 1e-10);
  EXPECT_EQ(e.result.moments, std::vector<double>(2, 0.0));
  EXPECT_EQ(e.result.certificate.held_lengths, 0);
}

TEST(ExecuteLength, InvertsControlByTension) {
  for (const double end : {1.0, 0.3}) {
    for (const double start : {0.0, 0.4, -0.5}) {
      SCOPED_TRACE(std::to_string(end) + " from " + std::to_string(start));
      ForwardScene s = between_tendons(0.06, end);
      s.scene.start_tip_angle = start;
      s.weight(2.0);
      expect_inverse(s, {18.0, 0.0});
      expect_inverse(s, {0.0, 11.0});
    }
  }
}

TEST(ExecuteLength, InvertsControlByTensionInContact) {
  for (const double end : {1.0, 0.4}) {
    SCOPED_TRACE(end);
    ForwardScene s = between_tendons(0.06, end);
    s.weight(4.0).circle(0.6, -0.16, 0.1);
    expect_inverse(s, {6.0, 0.0});
    ForwardScene up = between_tendons(0.06, end);
    up.circle(0.5, 0.25, 0.1);
    expect_inverse(up, {40.0, 0.0});
  }
}

TEST(ExecuteLength, InvertsControlByTensionWhereTheRodStretches) {
  ForwardScene s = between_tendons(0.06, 0.5);
  s.scene.rod.segments[0].axial_stiffness = 300.0;
  s.scene.coordinates.stretch_order = 1;
  s.weight(3.0).circle(0.55, -0.15, 0.1);
  // Both pull: what they do not bend they compress, so that both lengths count.
  expect_inverse(s, {25.0, 14.0});
}

TEST(ExecuteLength, LeadsOnFromAnEarlierResult) {
  ForwardScene s = between_tendons(0.06, 0.7);
  tell_lengths(s);
  s.weight(3.0);
  const Execution first = s.run({0.03, -0.05});
  ASSERT_EQ(first.result.status, PlanStatus::solved) << first.result.message;
  const std::vector<double> there{-0.03, 0.028};
  const Execution led = s.run(there, &first.result);
  const Execution loaded = s.run(there);
  ASSERT_EQ(led.result.status, PlanStatus::solved) << led.result.message;
  ASSERT_EQ(loaded.result.status, PlanStatus::solved) << loaded.result.message;
  EXPECT_NEAR(led.result.tip_x, loaded.result.tip_x, 1e-10);
  EXPECT_NEAR(led.result.tip_y, loaded.result.tip_y, 1e-10);
  // One tendon went slack, the other took over.
  EXPECT_GT(first.result.moments[0], 0.0);
  EXPECT_EQ(led.result.moments[0], 0.0);
  EXPECT_LT(led.result.moments[1], 0.0);
  EXPECT_GE(led.tendon_changes, 2);
}

// A heavy rod that leans to one side is held by the tendon on the other: by its length, not by its tension.
TEST(ExecuteLength, HoldsWhatATensionDoesNot) {
  ForwardScene s = upright(10.0);
  s.scene.rod.base_angle -= 0.02;
  s.scene.rod.actuators.resize(1);
  make_tendon(s.scene.rod.actuators[0], {{0.0, 0.05}});
  ForwardScene by_tension;
  by_tension.scene = s.scene;
  tell_lengths(s);
  const Execution held = s.run({-0.01});
  ASSERT_EQ(held.result.status, PlanStatus::solved) << held.result.message;
  EXPECT_GT(held.result.moments[0], 0.0);
  EXPECT_NEAR(held.result.turns[0], -0.2, 1e-10);
  EXPECT_EQ(held.result.certificate.held_lengths, 1);
  EXPECT_GT(held.result.certificate.stability, 0.3);
  const Execution let_go = by_tension.run(held.result.moments, &held.result);
  EXPECT_GT(std::hypot(let_go.result.tip_x - held.result.tip_x, let_go.result.tip_y - held.result.tip_y), 0.1);
}

TEST(ExecuteLength, LengthsThatContradictEachOtherAreTold) {
  ForwardScene s = between_tendons(0.05, 1.0);
  tell_lengths(s);
  const Execution e = s.run({0.02, 0.02});
  EXPECT_EQ(e.result.status, PlanStatus::not_converged);
  EXPECT_NE(e.result.message.find("the lengths of tendons contradict each other"), std::string::npos)
      << e.result.message;
}

TEST(ExecuteLength, LimitsAreOfLengthAndOfTension) {
  ForwardScene s = between_tendons(0.05, 1.0);
  tell_lengths(s);
  s.scene.rod.actuators[0].most_shortening = 0.03;
  s.scene.rod.actuators[0].maximum = 0.6;
  const Execution e = s.run({0.04, -0.04});
  EXPECT_EQ(e.result.status, PlanStatus::solved) << e.result.message;
  EXPECT_NE(e.result.message.find("held at 0.04 m, beyond its limit of 0.03 m"), std::string::npos) << e.result.message;
  EXPECT_NE(e.result.message.find("held at 16 N, beyond its limit of 12 N"), std::string::npos) << e.result.message;
}

// EI kappa = u and EA eps = N: of a pressure p that gives u = m(p) and N = n(p), and of two of them.
TEST(ExecuteLength, APressureStretchesByItsForce) {
  const double axial = 80.0;
  ForwardScene s;
  s.scene.rod.segments[0].axial_stiffness = axial;
  s.scene.coordinates.stretch_order = 1;
  ActuatorSpec& chamber = s.scene.rod.actuators[0];
  chamber.kind = ActuatorKind::pressure;
  chamber.least_pressure = 0.0;
  chamber.most_pressure = 4.0;
  chamber.moment_per_pressure = 0.2;
  for (const bool in_proportion : {true, false}) {
    chamber.more_moment_per_pressure = {0.03};
    chamber.force_per_pressure = in_proportion ? std::vector{2.0, 0.3} : std::vector{2.0, -0.1, 0.05};
    EXPECT_EQ(chamber.pulls_in_proportion(), in_proportion);
    for (const double p : {0.7, 2.0, 3.5}) {
      const double moment = 0.2 * p + 0.03 * p * p;
      const double force = in_proportion ? 2.0 * p + 0.3 * p * p : 2.0 * p - 0.1 * p * p + 0.05 * p * p * p;
      EXPECT_NEAR(chamber.pull_of(chamber.moment_of(p)).force, force, 1e-12);
      const Execution e = s.run({chamber.moment_of(p)});
      ASSERT_EQ(e.result.status, PlanStatus::solved) << e.result.message;
      const double length = 1.0 + force / axial;
      EXPECT_NEAR(e.result.tip_angle, moment, 1e-10);
      EXPECT_NEAR(e.result.tip_x, length * std::sin(moment) / moment, 1e-10);
      EXPECT_NEAR(e.result.tip_y, length * (1.0 - std::cos(moment)) / moment, 1e-10);
      EXPECT_LT(e.result.certificate.moment_balance, 1e-10);
    }
  }
}

}  // namespace
}  // namespace tendril::support
