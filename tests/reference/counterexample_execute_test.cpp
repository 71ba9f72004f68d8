// Executions that must not be called solved, and plans that execution must not confirm.

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>
#include <string>

#include "execute_support.hpp"
#include "obstacle/circle.hpp"
#include "support/clock.hpp"

namespace tendril::support {
namespace {

/// A straight rod pushed at its tip along itself by this share of the Euler load: its margin is one less that share.
Execution pushed(double share) {
  ForwardScene s;
  s.scene.tip_load.force = {-share * euler, 0.0};
  return s.run({0.0});
}

std::string told(const Execution& e) { return std::string(to_string(e.result.status)) + ": " + e.result.message; }

// The path is followed wherever the margin is positive; the certificate asks for 1e-6.
TEST(CounterexampleExecute, AStateWithHalfTheLeastMarginIsUnstable) {
  const Execution e = pushed(1.0 - 0.5e-6);
  EXPECT_EQ(e.result.status, PlanStatus::unstable) << told(e);
  EXPECT_EQ(e.result.message.find("unstable: the stability margin is 5.0"), 0U) << e.result.message;
  EXPECT_NEAR(e.result.certificate.stability, 0.5e-6, 1e-9);
  EXPECT_FALSE(e.result.certificate.valid());
  EXPECT_EQ(e.load, 1.0);
  // It is told all the same.
  EXPECT_NEAR(e.result.tip_x, 1.0, 1e-9);
  EXPECT_FALSE(e.result.backbone.empty());
}

TEST(CounterexampleExecute, AStateWithTwiceTheLeastMarginIsSolved) {
  const Execution e = pushed(1.0 - 2e-6);
  EXPECT_EQ(e.result.status, PlanStatus::solved) << told(e);
  EXPECT_NEAR(e.result.certificate.stability, 2e-6, 1e-9);
  EXPECT_TRUE(e.result.message.empty()) << e.result.message;
}

TEST(CounterexampleExecute, AtTheCriticalLoadNothingIsClaimed) {
  const Execution e = pushed(1.0 + 2e-10);
  EXPECT_EQ(e.result.status, PlanStatus::not_converged) << told(e);
  EXPECT_NE(e.result.message.find("the final loads are the critical ones"), std::string::npos) << e.result.message;
}

TEST(CounterexampleExecute, AnEarlierResultThatIsASaddleIsLeft) {
  // Straight above the Euler load: an equilibrium, and no place to stay.
  Plan saddle = pushed(0.0).result;
  ForwardScene s;
  s.scene.tip_load.force = {-1.5 * euler, 0.0};
  const Execution e = s.run({0.0}, &saddle);
  EXPECT_EQ(e.result.status, PlanStatus::solved) << told(e);
  ASSERT_EQ(e.snaps.size(), 1U);
  EXPECT_EQ(e.snaps[0].kind, SnapKind::start);
  EXPECT_GT(std::abs(e.result.tip_angle), 0.5);
  EXPECT_GT(e.result.certificate.stability, 0.1);
}

/// A hanging rod of this weight as it lies but for terms of the order of 1/weight: it turns down within a layer at its
/// base as a pendulum does (EI phi'' = w cos phi).
Plan hanging(double weight) {
  Plan plan;
  plan.moments = {0.0};
  const double rate = std::sqrt(weight);
  constexpr int samples = 4000;
  Vec2 at{};
  for (int i = 0; i <= samples; ++i) {
    const double s = static_cast<double>(i) / samples;
    const double e = std::tan(0.125 * std::numbers::pi) * std::exp(-rate * s);
    const double angle = 4.0 * std::atan(e) - 0.5 * std::numbers::pi;
    if (i > 0) at += 1.0 / samples * Vec2{std::cos(angle), std::sin(angle)};
    plan.backbone.push_back({s, at.x, at.y, angle, -4.0 * rate * e / (1.0 + e * e)});
  }
  return plan;
}

// Of 16 pieces of 40 functions the first one spans fourteen layers at a weight of 5e4: it settles, in an equilibrium
// of what these functions can do. The local moment tells what they cannot.
TEST(CounterexampleExecute, AShapeThatIsNotResolvedIsNotSolved) {
  for (const double weight : {2e4, 5e4}) {
    ForwardScene s;
    s.weight(weight);
    const Plan start = hanging(weight);
    const Execution e = s.run({0.0}, &start);
    const Certificate& c = e.result.certificate;
    EXPECT_LE(c.equilibrium, 1e-10) << weight;
    EXPECT_GT(c.stability, 0.5) << weight;
    EXPECT_EQ(e.load, 1.0) << weight;
    if (weight == 2e4) {
      EXPECT_LT(c.moment_balance, 5e-10);
      EXPECT_EQ(e.result.status, PlanStatus::solved) << told(e);
    } else {
      EXPECT_GT(c.moment_balance, 2e-9);
      EXPECT_EQ(e.result.status, PlanStatus::not_converged) << told(e);
      char text[96];
      std::snprintf(text, sizeof text, "local moment balance %.2e is above 1e-09", c.moment_balance);
      EXPECT_EQ(e.result.message, text);
    }
  }
}

/// A circle that does something when it has been asked often enough.
class Watched : public Circle {
 public:
  Watched(long calls, std::function<void()> then) : Circle({0.6, -0.3}, 0.08), left_(calls), then_(std::move(then)) {}
  SurfacePoint at(Vec2 point) const override {
    if (--left_ == 0) then_();
    return Circle::at(point);
  }
  long left() const { return left_; }

 private:
  mutable long left_;
  std::function<void()> then_;
};

ForwardScene watched(long calls, std::function<void()> then) {
  ForwardScene s;
  s.weight(1.682);
  s.circle(0.6, -0.3, 0.08);
  s.obstacles[0] = std::make_unique<Watched>(calls, std::move(then));
  return s;
}

/// How often a whole execution asks.
long calls_of_all() {
  constexpr long many = 1L << 40;
  const ForwardScene s = watched(many, [] {});
  EXPECT_EQ(s.run({0.5}).result.status, PlanStatus::solved);
  return many - static_cast<const Watched&>(*s.obstacles[0]).left();
}

TEST(CounterexampleExecute, InterruptedOnTheWayItSaysHowFarItCame) {
  std::atomic<bool> stop = false;
  const ForwardScene s = watched(calls_of_all() / 2, [&] { stop = true; });
  ExecuteControl control;
  control.stop = &stop;
  const Execution e = execute(s.scene, s.obstacles, {0.5}, control);
  EXPECT_EQ(e.result.status, PlanStatus::interrupted) << told(e);
  EXPECT_EQ(e.result.message, "interrupted before the final loads were reached");
  EXPECT_GT(e.load, 0.0);
  EXPECT_LT(e.load, 1.0);
  EXPECT_FALSE(e.result.backbone.empty());
}

TEST(CounterexampleExecute, OutOfTimeOnTheWayItSaysSo) {
  // However fast the machine, the limit has not passed before, and has when the obstacle answers.
  ExecuteControl control;
  control.time_limit = 1e5;
  const ForwardScene s = watched(calls_of_all() / 2, [] { advance_clock(std::chrono::seconds(200'000)); });
  const Execution e = execute(s.scene, s.obstacles, {0.5}, control);
  EXPECT_EQ(e.result.status, PlanStatus::time_limit) << told(e);
  EXPECT_GT(e.load, 0.0);
  EXPECT_LT(e.load, 1.0);
}

/// The braced arm in SI units, so that lengths and forces are not those of the model.
struct Arm : ForwardScene {
  static constexpr double length = 0.1;
  static constexpr double force_unit = 4.9e-4 / (length * length);
  Arm() {
    scene.rod.segments = {{length, 4.9e-4, 0.084, 0.0}};
    scene.rod.actuators[0].to = length;
    scene.gravity = Vec2{0.0, -9.81};
    circle(0.6, 0.0, 0.08);
    scene.start_tip_angle = 0.5;
    plan = run({2.5e-3}).result;
    EXPECT_EQ(plan.status, PlanStatus::solved) << plan.message;
    EXPECT_EQ(plan.contacts.size(), 1U);
  }
  Plan judged(Plan copy) const {
    verify(scene, obstacles, copy);
    return copy;
  }
  Plan plan;
};

testing::AssertionResult confirmed(const Plan& plan) {
  if (plan.status == PlanStatus::solved && plan.message.empty()) return testing::AssertionSuccess();
  return testing::AssertionFailure() << to_string(plan.status) << ": " << plan.message;
}

testing::AssertionResult not_confirmed(const Plan& plan, const std::string& reason) {
  const std::string whole = "execution does not confirm the plan: " + reason + " (" + plan.verification + ")";
  if (plan.status == PlanStatus::not_converged && plan.message == whole) return testing::AssertionSuccess();
  return testing::AssertionFailure() << to_string(plan.status) << ": " << plan.message << "\nexpected: " << whole;
}

// A tip may end within 5e-2 of the length from where the plan says.
TEST(CounterexampleVerify, TheTipMayBeOffByTheModelErrorOnly) {
  const Arm arm;
  for (const Vec2 direction : {Vec2{1.0, 0.0}, Vec2{0.0, 1.0}, Vec2{-0.6, -0.8}}) {
    for (const double share : {0.5, 2.0}) {
      Plan plan = arm.plan;
      const double off = share * 5e-2 * Arm::length;
      plan.tip_x += off * direction.x;
      plan.tip_y += off * direction.y;
      plan = arm.judged(plan);
      EXPECT_NEAR(plan.model_error.value_or(0.0), off, 1e-9);
      EXPECT_NEAR(plan.local_model_error.value_or(0.0), off, 1e-9);
      if (share < 1.0) {
        EXPECT_TRUE(confirmed(plan));
      } else {
        EXPECT_TRUE(not_confirmed(plan, "the tip ends elsewhere"));
        EXPECT_NE(plan.message.find("0.01 m (10 % of the length)"), std::string::npos) << plan.message;
      }
    }
  }
}

// Contacts with more than 1e-3 EI/L^2 have to be met.
TEST(CounterexampleVerify, ATraceOfForceIsNoContactAndMoreIsOne) {
  const Arm arm;
  for (const double share : {0.5, 2.0}) {
    Plan plan = arm.plan;
    PlannedContact ghost = plan.contacts[0];
    ghost.obstacle_name = "ghost";
    ghost.force = share * 1e-3 * Arm::force_unit;
    plan.contacts.push_back(ghost);
    plan = arm.judged(plan);
    if (share < 1.0) {
      EXPECT_TRUE(confirmed(plan));
    } else {
      EXPECT_TRUE(not_confirmed(plan, "the plan rests on 'circle 1', 'ghost', execution on 'circle 1'"));
    }
    plan = arm.plan;
    plan.contacts[0].force = share * 1e-3 * Arm::force_unit;
    plan = arm.judged(plan);
    if (share > 1.0) {
      EXPECT_TRUE(confirmed(plan));
    } else {
      EXPECT_TRUE(not_confirmed(plan, "the plan rests on no obstacle, execution on 'circle 1'"));
    }
  }
}

TEST(CounterexampleVerify, AnObstacleHoldsFromTheSideThatItsNormalTells) {
  const Arm arm;
  for (const double turn : {0.45, 0.55}) {
    Plan plan = arm.plan;
    Vec2& n = plan.contacts[0].normal;
    const double angle = turn * std::numbers::pi;
    n = {std::cos(angle) * n.x - std::sin(angle) * n.y, std::sin(angle) * n.x + std::cos(angle) * n.y};
    plan = arm.judged(plan);
    if (turn < 0.5) {
      EXPECT_TRUE(confirmed(plan));
    } else {
      EXPECT_TRUE(not_confirmed(plan, "the plan rests on the other side of 'circle 1' than execution does"));
    }
  }
}

// A plan that ignores obstacles settles from its own shape without them, and is loaded from the start with them.
TEST(CounterexampleVerify, ItsOwnShapeSettlesAmongTheObstaclesThatThePlanKnows) {
  Arm arm;
  ForwardScene alone;
  alone.scene = arm.scene;
  alone.scene.obstacles.clear();
  const Plan free = alone.run({2.5e-3}).result;
  arm.scene.contact.mode = ContactModeName::ignore;
  const Plan plan = arm.judged(free);
  EXPECT_LE(plan.local_model_error.value_or(1.0), 1e-9);
  EXPECT_TRUE(not_confirmed(plan, "the plan rests on no obstacle, execution on 'circle 1'"));
}

TEST(CounterexampleVerify, ASnapOnTheWayIsTold) {
  ForwardScene s = upright(10.0);
  Plan plan = s.run({0.0}).result;
  ASSERT_EQ(plan.status, PlanStatus::solved) << plan.message;
  verify(s.scene, s.obstacles, plan);
  EXPECT_TRUE(confirmed(plan));
  EXPECT_NE(plan.verification.find("after 1 snap(s)"), std::string::npos) << plan.verification;
}

// A plan that was called solved although its margin is half the least one.
TEST(CounterexampleVerify, AnExecutionThatIsNotSolvedConfirmsNothing) {
  ForwardScene s;
  s.scene.tip_load.force = {-(1.0 - 0.5e-6) * euler, 0.0};
  Plan plan = s.run({0.0}).result;
  plan.status = PlanStatus::solved;
  plan.message.clear();
  verify(s.scene, s.obstacles, plan);
  EXPECT_EQ(plan.status, PlanStatus::not_converged) << to_string(plan.status);
  EXPECT_NE(plan.message.find("loading from the start did not arrive: unstable"), std::string::npos) << plan.message;
  EXPECT_FALSE(plan.model_error.has_value());
}

}  // namespace
}  // namespace tendril::support
