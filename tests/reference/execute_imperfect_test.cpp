// What is almost symmetric falls to the side that it leans to, along a smooth path.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "execute_support.hpp"

namespace tendril::support {
namespace {

/// Clamped along +x, so that the mirror image in the x axis is exact in floating point.
Execution mast(double weight, double lean) {
  ForwardScene s;
  s.weight(weight);
  s.scene.gravity = Vec2{-1.0, 0.0};
  s.scene.rod.base_angle = lean;
  return s.run({0.0});
}

Execution column(double force, double eccentricity) {
  ForwardScene s;
  s.scene.tip_load.force = {-force, 0.0};
  return s.run({force * eccentricity});
}

void expect_mirrored(const Execution& left, const Execution& right) {
  ASSERT_EQ(left.result.status, PlanStatus::solved) << left.result.message;
  ASSERT_EQ(right.result.status, PlanStatus::solved) << right.result.message;
  EXPECT_TRUE(left.snaps.empty());
  EXPECT_TRUE(right.snaps.empty());
  EXPECT_GT(left.result.tip_angle, 0.1);
  EXPECT_EQ(left.result.tip_angle, -right.result.tip_angle);
  EXPECT_EQ(left.steps, right.steps);
  ASSERT_EQ(left.result.backbone.size(), right.result.backbone.size());
  for (std::size_t i = 0; i < left.result.backbone.size(); ++i) {
    EXPECT_EQ(left.result.backbone[i].x, right.result.backbone[i].x);
    EXPECT_EQ(left.result.backbone[i].y, -right.result.backbone[i].y);
  }
}

// Critical weight 7.8373474389, critical force 2.4674011003 (model.md section 8): all loads here are beyond them.
TEST(ExecuteImperfect, MastsAndColumnsFallToTheirOwnSideAndMirrorEachOther) {
  std::mt19937_64 random(11);
  const auto uniform = [&](double a, double b) { return a + (b - a) * static_cast<double>(random() >> 11U) * 0x1p-53; };
  for (int i = 0; i < 50; ++i) {
    const double imperfection = std::pow(10.0, uniform(-6.0, -1.5));
    const double weight = uniform(8.5, 30.0);
    SCOPED_TRACE("mast " + std::to_string(i) + " of weight " + std::to_string(weight) + " leans by " +
                 std::to_string(imperfection));
    expect_mirrored(mast(weight, imperfection), mast(weight, -imperfection));
  }
  for (int i = 0; i < 50; ++i) {
    const double imperfection = std::pow(10.0, uniform(-6.0, -1.5));
    const double force = uniform(2.6, 12.0);
    SCOPED_TRACE("column " + std::to_string(i) + " under force " + std::to_string(force) + ", eccentric by " +
                 std::to_string(imperfection));
    expect_mirrored(column(force, imperfection), column(force, -imperfection));
  }
}

// Upright, cosines are not mirrored to the last bit, and angles are taken to twelve digits.
TEST(ExecuteImperfect, UprightMastsFallToTheirOwnSideToo) {
  const auto fallen = [](double weight, double lean) {
    ForwardScene s = upright(weight);
    s.scene.rod.base_angle = 0.5 * std::numbers::pi - lean;
    const Execution e = s.run({0.0});
    EXPECT_EQ(e.result.status, PlanStatus::solved) << e.result.message;
    EXPECT_TRUE(e.snaps.empty());
    EXPECT_GT(lean * e.result.tip_x, 0.0);
    return e.result;
  };
  std::mt19937_64 random(12);
  const auto uniform = [&](double a, double b) { return a + (b - a) * static_cast<double>(random() >> 11U) * 0x1p-53; };
  for (int i = 0; i < 30; ++i) {
    const double lean = std::pow(10.0, uniform(-6.0, -1.5));
    const double weight = uniform(8.5, 30.0);
    SCOPED_TRACE("weight " + std::to_string(weight) + " leans by " + std::to_string(lean));
    const Plan right = fallen(weight, lean);
    const Plan left = fallen(weight, -lean);
    EXPECT_NEAR(right.tip_x, -left.tip_x, 1e-8);
    EXPECT_NEAR(right.tip_y, left.tip_y, 1e-8);
  }
  // A mast of 200 mm that leans by a twentieth of a degree; its tip in mm.
  const Plan known = fallen(15.696, 0.05 * std::numbers::pi / 180.0);
  EXPECT_NEAR(200.0 * known.tip_x, 159.6, 0.05);
  EXPECT_NEAR(200.0 * known.tip_y, -29.3, 0.05);
}

}  // namespace
}  // namespace tendril::support
