// Contacts that stick and slip along a path of loads: against reference states where they slip, against a chain of
// rigid links whose joints rub, and against the closed form of where a rod that leans on a wall begins to slip.

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "execute_support.hpp"
#include "obstacle/wall.hpp"
#include "scene/make_rod.hpp"
#include "scene/plan_report.hpp"
#include "statics/statics.hpp"
#include "support/contains.hpp"
#include "support/reference_table.hpp"
#include "support/rubbing_chain.hpp"

namespace tendril::support {
namespace {

/// One state after the other, each from the one before.
std::vector<Plan> led(const ForwardScene& s, const std::vector<double>& moments) {
  std::vector<Plan> states;
  for (const double moment : moments) {
    const Plan* before = states.empty() ? nullptr : &states.back();
    states.push_back(s.run({moment}, before).result);
    EXPECT_EQ(states.back().status, PlanStatus::solved) << states.back().message;
    if (states.back().backbone.empty()) break;
  }
  return states;
}

Plan led_to(const ForwardScene& s, const std::vector<double>& moments) { return led(s, moments).back(); }

ForwardScene rubbing_arm(double friction) {
  ForwardScene s = braced_arm();
  s.scene.contact.friction = friction;
  return s;
}

double apart(const Plan& a, const Plan& b) { return std::hypot(a.tip_x - b.tip_x, a.tip_y - b.tip_y); }

TEST(StickAndSlip, ALoopOfMomentsReturnsElsewhereAndToTheSameShapeWithoutFriction) {
  const std::vector<double> loop{1e-3, 2e-3, 0.0, 1e-3};
  const std::vector<Plan> rubbed = led(rubbing_arm(0.3), loop);
  EXPECT_GT(apart(rubbed.front(), rubbed.back()), 1e-5);
  const std::vector<Plan> smooth = led(rubbing_arm(0.0), loop);
  EXPECT_LT(apart(smooth.front(), smooth.back()), 1e-10);
  // The second time around nothing is left of how it began.
  EXPECT_LT(apart(led_to(rubbing_arm(0.3), {1e-3, 2e-3, 0.0, 1e-3, 2e-3, 0.0, 1e-3}), rubbed.back()), 1e-10);
}

// The exact states of a contact with a given ratio are those in which it slips at that coefficient: one way on the way
// up, the other way on the way down.
TEST(StickAndSlip, TheReferenceStatesAreReachedWhereItSlips) {
  const ReferenceTable table("friction");
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const double ratio = table.value(row, "friction_ratio");
    if (ratio == 0.0) continue;
    SCOPED_TRACE("row " + std::to_string(row));
    const double moment = table.value(row, "moment");
    const Plan reached = led_to(rubbing_arm(std::abs(ratio)), {moment + (ratio < 0.0 ? 2e-3 : -2e-3), moment});
    ASSERT_EQ(reached.contacts.size(), 1U);
    const PlannedContact& c = reached.contacts[0];
    EXPECT_FALSE(c.sticks);
    EXPECT_NEAR(c.tangential / c.force, ratio, 1e-12);
    EXPECT_NEAR(reached.tip_x, table.value(row, "tip_x"), 1e-10);
    EXPECT_NEAR(reached.tip_y, table.value(row, "tip_y"), 1e-10);
    EXPECT_NEAR(reached.tip_angle, table.value(row, "tip_angle"), 1e-9);
    EXPECT_NEAR(c.arc_length, table.value(row, "arc_length"), 1e-10);
    EXPECT_NEAR(c.force / table.value(row, "normal_force"), 1.0, 1e-7);
  }
}

// The same state is one of a path that goes the one way, but not the other.
TEST(StickAndSlip, AContactThatSlidesWithItsFrictionIsSeen) {
  const ForwardScene s = rubbing_arm(0.3);
  const Plan reached = led_to(s, {-1e-3, 1e-3});
  ASSERT_EQ(reached.contacts.size(), 1U);
  ASSERT_FALSE(reached.contacts[0].sticks);
  const Scale scale = scale_of(s.scene);
  const double moment = 1e-3 / scale.moment();
  for (const double towards : {1.0, -1.0}) {
    const LoadPath path(make_rod(s.scene, scale), {s.obstacles[0].get()},
                        {.first = {moment}, .last = {moment + towards}, .loads_grow = false});
    const double along = dot(reached.contacts[0].tangent, turned(reached.contacts[0].normal));
    PointContact contact{.setup = {.obstacle = 0, .lean = std::copysign(0.3, along * reached.contacts[0].tangential)}};
    contact.s = reached.contacts[0].arc_length / scale.length;
    contact.force = reached.contacts[0].force / scale.force();
    const std::vector<PointContact> contacts{contact};
    Statics statics(path, std::make_shared<LegendreBasis>(12), contacts, 30);
    Eigen::VectorXd z = statics.point({curvature_of(reached, scale.length), contacts, 0.0});
    ASSERT_TRUE(statics.solve_at_load(z, 0.0).converged);
    const auto [which, rate] = statics.slides_with_friction(z);
    EXPECT_EQ(which, towards > 0.0 ? -1 : 0);
    EXPECT_TRUE(towards > 0.0 ? rate == 0.0 : rate > 1e-3) << rate;
  }
}

// How a path is cut into way points changes nothing.
TEST(StickAndSlip, WayPointsInBetweenChangeNothing) {
  const ForwardScene s = rubbing_arm(0.3);
  const Plan few = led_to(s, {2e-3, -1e-3, -0.9e-3, 5e-4});
  const Plan many = led_to(s, {2e-3, 1.3e-3, 1e-3, 0.1e-3, -1e-3, -0.95e-3, -0.9e-3, -0.5e-3, 0.0, 4e-4, 5e-4});
  EXPECT_LT(apart(few, many), 1e-11);
  EXPECT_NEAR(few.contacts.at(0).tangential / many.contacts.at(0).tangential, 1.0, 1e-8);
}

/// Links of a chain, short ones where joints touch.
std::vector<double> links_around(double from, double to, int fine, int coarse) {
  std::vector<double> links;
  const auto add = [&](double length, int count) {
    links.insert(links.end(), static_cast<std::size_t>(count), length / count);
  };
  add(from, coarse);
  add(to - from, fine);
  add(1.0 - to, coarse);
  return links;
}

// Sticking, slipping and turning back, against joints of a chain of rigid links that rub: the contact's place is good
// to one link, and its force and the shape to what that makes of them.
TEST(StickAndSlip, AChainOfRubbingLinksFollowsTheSamePath) {
  constexpr double unit = 4.9e-3;  // EI / L, N m
  constexpr double force_unit = 4.9e-2;
  const double weight = 0.084 * 9.81 * 1e-3 / 4.9e-4;
  const ForwardScene s = rubbing_arm(0.3);
  constexpr double link = 0.08 / 50;
  RubbingChain chain(links_around(0.55, 0.63, 50, 40), 0.5, 0.0, {{{{0.6, 0.0}, 0.08}, 0.3}});
  constexpr int steps = 50;
  for (int i = 1; i <= steps; ++i) {
    const double load = static_cast<double>(i) / steps;
    chain.step(0.5 * (1.0 - load), load * weight);
  }
  const std::vector<double> moments{0.0, 0.25, 0.5, 0.49, 0.0, -0.5, -0.47, 0.0};
  const std::vector<bool> sticks{false, false, false, true, false, false, true, false};
  std::vector<double> si;
  for (const double m : moments) si.push_back(unit * m);
  const std::vector<Plan> reached = led(s, si);
  for (std::size_t i = 0; i < moments.size(); ++i) {
    SCOPED_TRACE("way point " + std::to_string(i + 1));
    for (int step = 1; step <= steps && i > 0; ++step) {
      chain.step(moments[i - 1] + (moments[i] - moments[i - 1]) * step / steps, weight);
    }
    EXPECT_NEAR(reached[i].tip_x / 0.1, chain.tip().x, 2.5e-4);
    EXPECT_NEAR(reached[i].tip_y / 0.1, chain.tip().y, 2.5e-4);
    const RubbingChain::Contact there = chain.contact(0);
    const PlannedContact& c = reached[i].contacts.at(0);
    EXPECT_EQ(c.sticks, sticks[i]);
    EXPECT_EQ(there.slips, !sticks[i]);
    EXPECT_NEAR(c.force / force_unit, there.force, 0.01 * there.force);
    EXPECT_NEAR(c.tangential / force_unit, there.tangential, 0.02 * there.force);
    EXPECT_NEAR(c.arc_length / 0.1, there.arc_length, link);
  }
}

// What only sticks gives back what was put in.
TEST(StickAndSlip, WhatDoesNotSlipComesBack) {
  const std::vector<Plan> states = led(rubbing_arm(10.0), {0.0, 2e-3, -1e-3, 0.0});
  for (const Plan& p : states) EXPECT_TRUE(p.contacts.at(0).sticks);
  EXPECT_GT(std::abs(states[1].contacts[0].tangential - states[0].contacts[0].tangential), 1e-3);
  EXPECT_LT(apart(states.front(), states.back()), 1e-11);
  EXPECT_NEAR(states[3].contacts[0].tangential, states[0].contacts[0].tangential, 1e-9);
  // It rolls: what the contact moves along the rod it moves along the obstacle.
  const auto along_circle = [](const Plan& p) {
    return -8e-3 * std::atan2(p.contacts[0].normal.y, p.contacts[0].normal.x);
  };
  EXPECT_GT(std::abs(states[1].contacts[0].arc_length - states[0].contacts[0].arc_length), 1e-5);
  EXPECT_NEAR(states[1].contacts[0].arc_length - states[0].contacts[0].arc_length,
              along_circle(states[1]) - along_circle(states[0]), 1e-12);
}

/// Mean of the curvatures on both sides of a contact, where its couple makes it jump.
double curvature_at_contact(const Plan& p) {
  const double s = p.contacts.at(0).arc_length;
  const auto behind = std::find_if(p.backbone.begin(), p.backbone.end(),
                                   [s](const BackbonePoint& point) { return point.s > s + 1e-9; });
  const auto before = std::find_if(std::make_reverse_iterator(behind), p.backbone.rend(),
                                   [s](const BackbonePoint& point) { return point.s < s - 1e-9; });
  return 0.5 * (before->curvature + behind->curvature);
}

// A thick body rolls with its surface, which is longer or shorter than its backbone where it is bent. How far depends
// on how it is bent on the way, so that it comes back to the second order of the steps only.
TEST(StickAndSlip, AThickBodyRollsWithItsSurface) {
  ForwardScene s = rubbing_arm(10.0);
  s.scene.start_tip_angle = 1.5;
  s.scene.rod.segments[0].thickness = 6e-3;
  // It comes down too steeply to stick at once.
  const std::vector<Plan> states = led(s, {0.0, 5e-4, 1e-3, 5e-4});
  EXPECT_FALSE(states[0].contacts.at(0).sticks);
  for (std::size_t i = 1; i < states.size(); ++i) {
    EXPECT_TRUE(states[i].contacts.at(0).sticks);
    EXPECT_LE(states[i].certificate.moment_balance, 1e-8);
  }
  EXPECT_LT(apart(states[1], states[3]), 1e-8);
  const double rolled = 8e-3 * (std::atan2(states[1].contacts[0].normal.y, states[1].contacts[0].normal.x) -
                                std::atan2(states[2].contacts[0].normal.y, states[2].contacts[0].normal.x));
  const double moved = states[2].contacts[0].arc_length - states[1].contacts[0].arc_length;
  const double bent = 3e-3 * 0.5 * (curvature_at_contact(states[1]) + curvature_at_contact(states[2]));
  EXPECT_GT(std::abs(bent), 1e-3);
  EXPECT_NEAR(rolled / moved - 1.0, bent, 0.1 * std::abs(bent));
}

TEST(StickAndSlip, TheMirrorImageIsTheSame) {
  ForwardScene mirrored = rubbing_arm(0.3);
  mirrored.scene.gravity = Vec2{0.0, 9.81};
  mirrored.scene.start_tip_angle = -0.5;
  const std::vector<Plan> one = led(rubbing_arm(0.3), {1e-3, -1e-3, -0.9e-3});
  const std::vector<Plan> other = led(mirrored, {-1e-3, 1e-3, 0.9e-3});
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_NEAR(one[i].tip_x, other[i].tip_x, 1e-12);
    EXPECT_NEAR(one[i].tip_y, -other[i].tip_y, 1e-12);
    EXPECT_NEAR(one[i].contacts.at(0).tangential, other[i].contacts.at(0).tangential, 1e-10);
    EXPECT_EQ(one[i].contacts[0].sticks, other[i].contacts[0].sticks);
  }
}

// From hardly any friction, which leaves the rod where it is without, to more than holds it.
TEST(StickAndSlip, AnyCoefficientKeepsTheForceInItsCone) {
  const std::vector<double> path{2e-3, 0.0, 5e-4};
  const Plan smooth = led_to(rubbing_arm(0.0), path);
  for (const double friction : {1e-6, 1e-3, 0.1, 1.0, 10.0}) {
    SCOPED_TRACE(friction);
    const Plan reached = led_to(rubbing_arm(friction), path);
    const PlannedContact& c = reached.contacts.at(0);
    EXPECT_LE(std::abs(c.tangential), friction * c.force * (1.0 + 1e-9));
    EXPECT_EQ(c.sticks, std::abs(c.tangential) < friction * c.force * (1.0 - 1e-9));
    if (friction <= 1e-3) {
      EXPECT_LT(apart(reached, smooth), 1e-3 * friction);
    }
  }
}

/// A rod that a moment bends down to an arc of one radian, its tip at a wall.
struct Leaning {
  Eigen::Vector2d tip{std::sin(1.0), std::cos(1.0) - 1.0};

  /// The force that holds the tip, per weight: what moves it where nothing holds it, by its compliance (L = EI = 1).
  Eigen::Vector2d reaction() const {
    Eigen::Matrix2d compliance = Eigen::Matrix2d::Zero();
    Eigen::Vector2d moved = Eigen::Vector2d::Zero();
    constexpr int n = 2000;
    for (int i = 0; i < n; ++i) {
      const double s = (i + 0.5) / n;
      const Eigen::Vector2d off = tip - Eigen::Vector2d(std::sin(s), std::cos(s) - 1.0);
      const Eigen::Vector2d turning(-off.y(), off.x());
      // The weight beyond s, about s.
      const double moment = -(std::cos(s) - std::cos(1.0) - (1.0 - s) * std::sin(s));
      moved += turning * moment / n;
      compliance += turning * turning.transpose() / n;
    }
    return -compliance.inverse() * moved;
  }

  /// `facing`: angle of the wall's normal.
  ForwardScene at(double facing, double friction) const {
    ForwardScene s;
    s.scene.start_tip_angle = -1.0;
    s.weight(1e-5);
    s.scene.contact.friction = friction;
    const Vec2 normal{std::cos(facing), std::sin(facing)};
    ObstacleSpec wall;
    wall.name = "wall";
    wall.shape = "wall";
    s.scene.obstacles.push_back(wall);
    s.obstacles.push_back(std::make_unique<Wall>(Vec2{tip.x(), tip.y()} - 1e-11 * normal, normal));
    return s;
  }
};

// The direction in which a wall has to hold the tip is the rod's alone. As a block on a slope it slips where that leans
// off the wall's normal by more than the friction angle.
TEST(StickAndSlip, ARodThatLeansOnAWallUnderItsWeightSlipsBeyondTheFrictionAngle) {
  const Leaning rod;
  const Eigen::Vector2d force = rod.reaction();
  const double direction = std::atan2(force.y(), force.x());
  for (const double friction : {0.1, 0.3}) {
    for (const double side : {-1.0, 1.0}) {
      SCOPED_TRACE(testing::Message() << friction << ", side " << side);
      const double edge = direction + side * std::atan(friction);
      for (const double beyond : {-1e-4, 1e-4}) {
        const Execution e = rod.at(edge + side * beyond, friction).run({-1.0});
        ASSERT_EQ(e.result.status, PlanStatus::solved) << e.result.message;
        ASSERT_EQ(e.result.contacts.size(), 1U);
        const PlannedContact& c = e.result.contacts[0];
        EXPECT_TRUE(c.at_tip);
        EXPECT_EQ(c.sticks, beyond < 0.0);
        if (!c.sticks) continue;
        EXPECT_NEAR(c.force / 1e-5, force.norm() * std::cos(std::atan(friction) + beyond), 1e-3);
      }
    }
  }
}

/// A rod that hangs over pegs on a quarter of a circle, its tip pulled down, is drawn back at its base: the pull there,
/// for each unit of that at the tip.
double pull_over_pegs(int pegs, double friction) {
  constexpr double arc = 0.5;
  constexpr double radius = 0.01;
  const double tip_force = 100.0 * pegs;  // more than the rod's stiffness holds between two pegs
  ForwardScene s;
  s.scene.rod.actuators.clear();
  s.scene.tip_load.force = Vec2{0.0, -tip_force};
  s.scene.contact.friction = friction;
  for (int i = 0; i < pegs; ++i) {
    const double at = 0.5 * std::numbers::pi * (1.0 - (i + 0.5) / pegs);
    s.circle(0.1 + (arc - radius) * std::cos(at), (arc - radius) * std::sin(at) - arc, radius);
  }
  ExecuteControl control;
  control.place.base = {Vec2{}, 0.0};
  const std::vector<double> no_moments;
  const Execution hung = execute(s.scene, s.obstacles, no_moments, control);
  EXPECT_EQ(hung.result.status, PlanStatus::solved) << hung.result.message;
  control.start = &hung.result;
  control.place.base->position = {-0.02, 0.0};
  const Execution drawn = execute(s.scene, s.obstacles, no_moments, control);
  EXPECT_EQ(drawn.result.status, PlanStatus::solved) << drawn.result.message;
  EXPECT_EQ(drawn.result.contacts.size(), static_cast<std::size_t>(pegs));
  double across = 0.0;
  for (const PlannedContact& c : drawn.result.contacts) {
    EXPECT_FALSE(c.sticks);
    // Along the rod is clockwise.
    across += c.force * c.normal.x + c.tangential * c.normal.y;
  }
  return across / tip_force;
}

// The capstan: exp(mu angle), to the second order of the pegs' spacing.
TEST(StickAndSlip, OverPegsOnAnArcThePullGrowsAsOverACapstan) {
  for (const int pegs : {2, 4, 8}) {
    SCOPED_TRACE(pegs);
    const double capstan = std::exp(0.3 * 0.5 * std::numbers::pi);
    EXPECT_NEAR(pull_over_pegs(pegs, 0.3) / capstan, 1.0, 0.2 / (pegs * pegs));
  }
  // A rope would pull alike; the rod's stiffness takes a little.
  EXPECT_NEAR(pull_over_pegs(4, 0.0), 1.0, 1e-4);
}

TEST(StickAndSlip, WhatIsCarriedOverFromAResultWithoutFrictionSticksFirst) {
  ForwardScene s = rubbing_arm(0.0);
  const Plan smooth = led_to(s, {1e-3});
  s.scene.contact.friction = 0.3;
  const Execution there = s.run({1e-3}, &smooth);
  ASSERT_EQ(there.result.status, PlanStatus::solved) << there.result.message;
  EXPECT_TRUE(there.result.contacts.at(0).sticks);
  EXPECT_NEAR(there.result.contacts[0].tangential, 0.0, 1e-9);
  EXPECT_LT(apart(there.result, smooth), 1e-11);
}

// A plan is made without friction, and is verified so.
TEST(StickAndSlip, APlanIsVerifiedWithoutFriction) {
  const ForwardScene s = rubbing_arm(0.3);
  Plan plan = led_to(rubbing_arm(0.0), {1e-3});
  verify(s.scene, s.obstacles, plan);
  EXPECT_EQ(plan.status, PlanStatus::solved) << plan.message;
  EXPECT_LT(plan.model_error.value_or(1.0), 1e-10);
}

}  // namespace
}  // namespace tendril::support
