#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "rod/self_overlap.hpp"

namespace tendril {
namespace {

std::vector<BackbonePoint> arc(double angle, int steps) {
  std::vector<BackbonePoint> points;
  for (int i = 0; i <= steps; ++i) {
    const double s = static_cast<double>(i) / steps;
    points.push_back({s, std::sin(angle * s) / angle, (1.0 - std::cos(angle * s)) / angle, angle * s, angle});
  }
  return points;
}

TEST(SelfOverlap, LessThanATurnDoesNotOverlap) {
  EXPECT_FALSE(self_overlap(arc(1.0, 100)));
  EXPECT_FALSE(self_overlap(arc(1.9 * std::numbers::pi, 100)));
  EXPECT_FALSE(self_overlap(std::vector<BackbonePoint>{}));
}

// Samples of the second turn lie on those of the first, or between them.
TEST(SelfOverlap, MoreThanATurnDoes) {
  for (const int steps : {100, 97}) {
    for (const double turns : {2.0, 3.5, 10.0}) {
      const auto met = self_overlap(arc(2.0 * std::numbers::pi * turns, steps));
      ASSERT_TRUE(met) << turns << " turns, " << steps << " steps";
      EXPECT_NEAR(met->second - met->first, 1.0 / turns, 2.0 / steps);
    }
  }
}

TEST(SelfOverlap, CrossingChordsMeetWhereTheyCross) {
  // Along x, up, and back down across the first chord: the tangent turns by more than half a turn.
  const std::vector<BackbonePoint> loop{
      {0.0, 0.0, 0.0, 0.0, 0.0}, {1.0, 1.0, 0.0, 0.8, 0.0}, {2.0, 1.0, 1.0, 3.2, 0.0}, {4.0, 0.5, -1.0, 4.5, 0.0}};
  const auto met = self_overlap(loop);
  ASSERT_TRUE(met);
  EXPECT_NEAR(met->first, 0.75, 1e-12);
  EXPECT_NEAR(met->second, 3.0, 1e-12);
}

/// Along x, half a turn of radius 0.1 to the left, and back at a distance of 0.2.
std::vector<BackbonePoint> hook() {
  std::vector<BackbonePoint> points;
  const double half_turn = 0.1 * std::numbers::pi;
  for (int i = 0; i <= 200; ++i) {
    const double s = (0.7 + half_turn) * i / 200.0;
    const double turned = std::clamp((s - 0.4) / 0.1, 0.0, std::numbers::pi);
    const double straight = std::min(s, 0.4) - std::max(0.0, s - 0.4 - half_turn);
    points.push_back({s, straight + 0.1 * std::sin(turned), 0.1 * (1.0 - std::cos(turned)), turned,
                      turned > 0.0 && turned < std::numbers::pi ? 10.0 : 0.0});
  }
  return points;
}

// Sides of a body meet where backbones do not.
TEST(SelfOverlap, OfABodyIsThatOfItsSides) {
  EXPECT_FALSE(self_overlap(hook()));
  EXPECT_FALSE(self_overlap(hook(), [](double) { return 0.08; }));
  const auto met = self_overlap(hook(), [](double s) { return s < 0.35 ? 0.12 : s > 0.75 ? 0.09 : 0.05; });
  ASSERT_TRUE(met);
  EXPECT_LT(met->first, 0.4);
  EXPECT_GT(met->second, 0.7);
}

// A body that is thicker than its backbone bends lies in itself on the inner side.
TEST(SelfOverlap, ABodyFoldsWhereItBendsTooMuch) {
  const std::vector<BackbonePoint> bent = arc(2.0, 100);
  EXPECT_FALSE(self_overlap(bent, [](double) { return 0.49; }));
  EXPECT_TRUE(self_overlap(bent, [](double s) { return 0.3 + 0.5 * s; }));
}

TEST(SelfOverlap, SidesOfABodyStandAcrossTheBackbone) {
  const std::vector<BackbonePoint> sides = body_outline(arc(1.0, 10), [](double s) { return 0.1 - 0.05 * s; });
  ASSERT_EQ(sides.size(), 22U);
  EXPECT_NEAR(sides.front().y, 0.1, 1e-15);
  EXPECT_NEAR(sides.back().y, -0.1, 1e-15);
  EXPECT_EQ(sides[10].s, 1.0);
  EXPECT_NEAR(norm(sides[10].position() - sides[11].position()), 0.1, 1e-15);
}

}  // namespace
}  // namespace tendril
