#include "support/link_chain.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/reference_table.hpp"

namespace tendril::support {
namespace {

// Without obstacles 400 links are off by 3e-6 L at most over the tables (measured).
constexpr double kFree = 5e-6;
// With obstacles the force sits on the nearest joint, up to half a link from its true place. Measured: 2.2e-4 L for the
// deepest contact, 5e-3 of the force.
constexpr double kTouching = 3e-4;
constexpr double kForce = 7e-3;
constexpr double kLink = 1.0 / 400.0;

TEST(LinkChainReference, TipForceTable) {
  const ReferenceTable table("tip_force");
  for (std::size_t i = 0; i < table.rows(); ++i) {
    RodBvp rod;
    rod.tip_force = {0.0, table.value(i, "alpha")};
    const LinkChainSolution s = settle(rod, {0.0});
    EXPECT_NEAR(s.tip_angle, table.value(i, "theta"), kFree) << i;
    EXPECT_NEAR(1.0 - s.tip_x, table.value(i, "u"), kFree) << i;
    EXPECT_NEAR(s.tip_y, table.value(i, "w"), kFree) << i;
  }
}

TEST(LinkChainReference, SelfWeightTable) {
  const ReferenceTable table("self_weight");
  for (std::size_t i = 0; i < table.rows(); ++i) {
    RodBvp rod;
    rod.sections[0].density = table.value(i, "weight");
    rod.gravity = {0.0, -1.0};
    const LinkChainSolution s = settle(rod, {table.value(i, "moment")});
    EXPECT_NEAR(s.tip_x, table.value(i, "x"), kFree) << i;
    EXPECT_NEAR(s.tip_y, table.value(i, "y"), kFree) << i;
    EXPECT_NEAR(s.tip_angle, table.value(i, "theta"), kFree) << i;
  }
}

TEST(LinkChainReference, ErrorFallsWithTheSquareOfTheLinks) {
  const ReferenceTable table("self_weight");
  RodBvp rod;
  rod.sections[0].density = table.value(1, "weight");
  rod.gravity = {0.0, -1.0};
  const auto error = [&](int links) {
    LinkChainOptions options;
    options.links = links;
    return std::abs(settle(rod, {0.0}, {}, options).tip_y - table.value(1, "y"));
  };
  // The ratio is 4 up to the next term of the expansion, which is about 1/links^2 itself.
  EXPECT_NEAR(error(50) / error(100), 4.0, 0.05);
  EXPECT_NEAR(error(100) / error(200), 4.0, 0.05);
}

TEST(LinkChainReference, CircleContactTable) {
  const ReferenceTable table("circle_contact");
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const BvpContact circle{{table.value(i, "x"), table.value(i, "y")}, table.value(i, "radius")};
    const LinkChainSolution s = settle(RodBvp{}, {table.value(i, "moment")}, {circle});
    EXPECT_NEAR(s.tip_x, table.value(i, "tip_x"), kTouching) << i;
    EXPECT_NEAR(s.tip_y, table.value(i, "tip_y"), kTouching) << i;
    EXPECT_NEAR(s.contacts[0].force / table.value(i, "force"), 1.0, kForce) << i;
    EXPECT_NEAR(s.contacts[0].arc_length, table.value(i, "arc_length"), kLink) << i;
    EXPECT_LE(s.penetration, 1e-9) << i;
  }
}

TEST(LinkChainReference, CirclesAreNotTouchedAtMoment07) {
  const ReferenceTable table("circle_contact");
  for (std::size_t i : {std::size_t{0}, std::size_t{2}}) {
    const BvpContact circle{{table.value(i, "x"), table.value(i, "y")}, table.value(i, "radius")};
    const LinkChainSolution s = settle(RodBvp{}, {0.7}, {circle});
    EXPECT_EQ(s.contacts[0].joints, 0) << i;
    EXPECT_EQ(s.contacts[0].force, 0.0) << i;
  }
}

/// The braced arm of the reference data, in SI units.
RodBvp braced_rod() {
  RodBvp rod;
  rod.sections = {{0.1, 4.9e-4, 0.084, 0.0}};
  rod.actuators = {{0.0, 0.1}};
  rod.gravity = {0.0, -9.81};
  return rod;
}

TEST(LinkChainReference, BracedArmTable) {
  const ReferenceTable table("braced_arm");
  for (std::size_t i = 0; i < table.rows(); ++i) {
    LinkChainOptions options;
    options.curvature = 5.0;
    const LinkChainSolution s =
        settle(braced_rod(), {table.value(i, "moment")}, {BvpContact{{0.06, 0.0}, 0.008}}, options);
    EXPECT_NEAR(s.tip_x, table.value(i, "tip_x"), 0.1 * kTouching) << i;
    EXPECT_NEAR(s.tip_y, table.value(i, "tip_y"), 0.1 * kTouching) << i;
    EXPECT_NEAR(s.contacts[0].force / table.value(i, "force"), 1.0, kForce) << i;
    EXPECT_NEAR(s.contacts[0].arc_length, table.value(i, "arc_length"), 0.1 * kLink) << i;
    EXPECT_LE(s.penetration, 1e-9 * 0.1) << i;
  }
}

// Given the contact's place and force as a dead load, the chain has only its own error of the second order.
TEST(LinkChainReference, GivenContactForceReplacesTheObstacle) {
  const ReferenceTable table("circle_contact");
  const Point centre{table.value(0, "x"), table.value(0, "y")};
  const BvpContact circle{centre, table.value(0, "radius")};
  BvpGuess guess;
  guess.curvature = 0.7;
  guess.arc_lengths = {0.6};
  guess.forces = {0.0};
  const BvpSolution exact = follow(RodBvp{}, {0.7}, {1.0}, {circle}, guess);
  const BvpState at = exact.at(exact.arc_lengths[0]);
  LinkChainOptions options;
  options.angle = guess.angle = exact.guess().angle;
  const double f = exact.forces[0] / circle.radius;
  options.forces = {{exact.arc_lengths[0], {f * (at.x - centre.x), f * (at.y - centre.y)}}};
  const LinkChainSolution s = settle(RodBvp{}, {1.0}, {}, options);
  EXPECT_NEAR(s.tip_x, table.value(0, "tip_x"), kFree);
  EXPECT_NEAR(s.tip_y, table.value(0, "tip_y"), kFree);
}

// Every feature of the boundary-value problem at once, against the other method.
TEST(LinkChainReference, AgreesWithTheBoundaryValueProblem) {
  RodBvp rod;
  rod.sections = {{0.4, 1.0, 2.0, 0.5}, {0.6, 0.7, 1.0, -0.3}};
  rod.actuators = {{0.0, 0.65}, {0.65, 1.0}};
  rod.gravity = {0.6, -0.8};
  rod.tip_force = {-0.3, 0.4};
  rod.payload = 0.5;
  rod.base = {0.1, 0.2};
  rod.base_angle = 0.3;
  const std::vector<double> moments{1.5, -0.8};
  BvpGuess guess;
  guess.curvature = 0.5;
  const BvpSolution exact = solve(rod, moments, {}, guess);
  const LinkChainSolution s = settle(rod, moments);
  EXPECT_NEAR(s.tip_x, exact.tip_x, kFree);
  EXPECT_NEAR(s.tip_y, exact.tip_y, kFree);
  EXPECT_NEAR(s.tip_angle, exact.tip_angle, kFree);
  for (std::size_t i = 0; i <= 400; i += 50) {
    EXPECT_NEAR(s.joints[i].x, exact.at(static_cast<double>(i) * kLink).x, kFree) << i;
    EXPECT_NEAR(s.joints[i].y, exact.at(static_cast<double>(i) * kLink).y, kFree) << i;
  }
}

// The chain finds by itself what the boundary-value problem is told: a peg and a floor, and a contact at the tip.
TEST(LinkChainReference, FindsSeveralContacts) {
  RodBvp rod;
  rod.sections[0].density = 20.0;
  rod.gravity = {0.0, -1.0};
  const std::vector<BvpContact> contacts{{{0.4, -0.12}, 0.1}, {{0.0, -0.1}, 0.0, false, {0.0, 1.0}}};
  const LinkChainSolution s = settle(rod, {1.0}, contacts);
  BvpGuess guess;
  guess.angle = [](double at) { return at < 0.75 ? -0.25 * std::sin(at * 4.19) : 2.0 * (at - 0.75); };
  for (const ChainContact& c : s.contacts) {
    guess.arc_lengths.push_back(c.arc_length);
    guess.forces.push_back(c.force);
  }
  const BvpSolution exact = solve(rod, {1.0}, contacts, guess);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_NEAR(s.contacts[k].force / exact.forces[k], 1.0, 3.0 * kForce) << k;
    EXPECT_NEAR(s.contacts[k].arc_length, exact.arc_lengths[k], kLink) << k;
  }
  EXPECT_NEAR(s.tip_y, exact.tip_y, kTouching);
}

TEST(LinkChainReference, FindsATipContact) {
  const BvpContact circle{{0.2, 0.77}, 0.3, true};
  const LinkChainSolution s = settle(RodBvp{}, {2.0}, {circle});
  BvpGuess guess;
  guess.curvature = 1.8;
  guess.arc_lengths = {1.0};
  guess.forces = {0.1};
  const BvpSolution exact = solve(RodBvp{}, {2.0}, {circle}, guess);
  // The tip is a joint, so nothing is rounded to the next one.
  EXPECT_EQ(s.contacts[0].joints, 1);
  EXPECT_EQ(s.contacts[0].arc_length, 1.0);
  EXPECT_NEAR(s.contacts[0].force, exact.forces[0], kFree * 10.0);
  EXPECT_NEAR(s.tip_x, exact.tip_x, kFree);
  EXPECT_NEAR(s.tip_y, exact.tip_y, kFree);
}

TEST(LinkChainReference, StabilityMarginVanishesAtBuckling) {
  RodBvp rod;
  rod.base_angle = std::acos(0.0);
  const double euler = rod.base_angle * rod.base_angle;
  LinkChainOptions options;
  options.links = 100;
  const auto margin = [&](double load) {
    rod.tip_force = {0.0, -load};
    return stability_margin(rod, {0.0}, settle(rod, {0.0}, {}, options));
  };
  // For a straight rod under a tip force the margin is 1 - load/critical load; 100 links are off by 2e-5.
  EXPECT_NEAR(margin(0.0), 1.0, 1e-9);
  EXPECT_NEAR(margin(0.5 * euler), 0.5, 1e-4);
  EXPECT_NEAR(margin(euler), 0.0, 1e-4);
}

}  // namespace
}  // namespace tendril::support
