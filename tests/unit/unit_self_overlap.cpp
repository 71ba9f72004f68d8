#include <gtest/gtest.h>

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

}  // namespace
}  // namespace tendril
