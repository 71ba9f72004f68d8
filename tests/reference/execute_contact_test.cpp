#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "execute_support.hpp"
#include "obstacle/wall.hpp"
#include "support/contains.hpp"
#include "support/print.hpp"
#include "support/reference_table.hpp"

namespace tendril::support {
namespace {

constexpr double forceful = 1e-6;  // of the force; likewise

TEST(ExecuteContact, BracedArmTable) {
  const ReferenceTable table("braced_arm");
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const Execution e = braced_arm().run({table.value(row, "moment")});
    ASSERT_EQ(e.result.status, PlanStatus::solved) << e.result.message;
    ASSERT_EQ(e.result.contacts.size(), 1U);
    EXPECT_NEAR(e.result.tip_x, table.value(row, "tip_x"), 0.1 * exact) << row;
    EXPECT_NEAR(e.result.tip_y, table.value(row, "tip_y"), 0.1 * exact) << row;
    EXPECT_NEAR(e.result.tip_angle, table.value(row, "tip_angle"), exact) << row;
    EXPECT_NEAR(e.result.contacts[0].arc_length, table.value(row, "arc_length"), 0.1 * exact) << row;
    EXPECT_NEAR(e.result.contacts[0].force / table.value(row, "force"), 1.0, forceful) << row;
    EXPECT_LE(e.result.certificate.moment_balance, 1e-9);
    EXPECT_TRUE(e.snaps.empty());
  }
}

TEST(ExecuteContact, CircleContactTable) {
  const ReferenceTable table("circle_contact");
  for (std::size_t row = 0; row < table.rows(); ++row) {
    ForwardScene s;
    s.circle(table.value(row, "x"), table.value(row, "y"), table.value(row, "radius"));
    const Execution e = s.run({table.value(row, "moment")});
    ASSERT_EQ(e.result.status, PlanStatus::solved) << e.result.message;
    ASSERT_EQ(e.result.contacts.size(), 1U);
    EXPECT_NEAR(e.result.tip_x, table.value(row, "tip_x"), exact) << row;
    EXPECT_NEAR(e.result.tip_y, table.value(row, "tip_y"), exact) << row;
    EXPECT_NEAR(e.result.contacts[0].arc_length, table.value(row, "arc_length"), exact) << row;
    EXPECT_NEAR(e.result.contacts[0].force / table.value(row, "force"), 1.0, forceful) << row;
  }
}

// A heavy rod clamped just above a wall: linear beam theory lays it down at (72 h / w)^(1/4), from where the wall
// carries its weight. The rod's slope stays below 0.02, so that linear theory is good to its square.
TEST(ExecuteContact, AHeavyRodLiesAlongAWall) {
  constexpr double height = 1e-3;
  constexpr double weight = 100.0;
  ForwardScene s;
  s.weight(weight);
  s.scene.obstacles.push_back({"floor", "wall", {}});
  s.obstacles.push_back(std::make_unique<Wall>(Vec2{0.0, -height}, Vec2{0.0, 1.0}));
  const Execution e = s.run({0.0});
  EXPECT_EQ(e.result.status, PlanStatus::not_converged);
  EXPECT_TRUE(contains_text(e.result.message, "contact spreads"));
  EXPECT_EQ(e.load, 1.0);
  ASSERT_GT(e.result.contacts.size(), 50U);
  double carried = 0.0;
  for (const PlannedContact& c : e.result.contacts) {
    EXPECT_TRUE(c.extended) << c.arc_length << ", force " << c.force;
    EXPECT_NEAR(c.gap, 0.0, 1e-9);
    carried += c.force;
  }
  const double touches = std::pow(72.0 * height / weight, 0.25);
  EXPECT_NEAR(e.result.contacts.front().arc_length, touches, 2.0 / 160.0);
  // The wall carries what the clamp does not: its shear is 2/3 of the weight that hangs free.
  EXPECT_NEAR(carried, weight * (1.0 - 2.0 / 3.0 * touches), 1e-2 * weight);
}

// The layer at the base is w^(-1/2) wide. Leading terms of its matched expansion; the next are of the order of 1/w.
TEST(ExecuteContact, ABoundaryLayerIsResolved) {
  for (const double weight : {1e3, 1e4}) {
    ForwardScene s;
    s.weight(weight);
    const Execution e = s.run({0.0});
    ASSERT_EQ(e.result.status, PlanStatus::solved) << e.result.message;
    const double layer = 1.0 / std::sqrt(weight);
    EXPECT_NEAR(e.result.tip_x, std::sqrt(2.0) * layer, 2.0 / weight);
    EXPECT_NEAR(e.result.tip_y, -1.0 + (2.0 - std::sqrt(2.0)) * layer, 2.0 / weight);
  }
}

// A circle far smaller than a step of the path is not passed over: it holds the rod where larger ones do.
TEST(ExecuteContact, ATinyCircleHoldsTheRod) {
  std::vector<double> tips;
  for (const double radius : {1e-6, 1e-3}) {
    ForwardScene s;
    s.weight(5.0);
    s.circle(0.6, -0.05 - radius, radius);
    const Execution e = s.run({0.0});
    ASSERT_EQ(e.result.status, PlanStatus::solved) << e.result.message;
    ASSERT_EQ(e.result.contacts.size(), 1U);
    tips.push_back(e.result.tip_y);
  }
  EXPECT_NEAR(tips[0], tips[1], 1e-3);
}

// The contact ends beside the common end of two actuators, or on it, for some of these.
TEST(ExecuteContact, AContactMayEndAtAnActuatorsEnd) {
  for (int i = 0; i <= 20; ++i) {
    ForwardScene s;
    s.weight(5.0);
    s.scene.rod.actuators.push_back(s.scene.rod.actuators[0]);
    s.scene.rod.actuators[0].to = s.scene.rod.actuators[1].from = 0.5;
    s.circle(0.49 + 0.001 * i, -0.06, 0.02);
    const Execution e = s.run({0.0, 0.0});
    EXPECT_EQ(e.result.status, PlanStatus::solved) << i << ": " << e.result.message;
  }
}

// A start by points is let go from there: it ends on its side of the circle, where an even bend to that side ends.
TEST(ExecuteContact, AStartByPointsStaysOnItsSide) {
  for (const double side : {1.0, -1.0}) {
    ForwardScene bent = braced_arm();
    bent.scene.start_tip_angle = 0.8 * side;
    const Execution even = bent.run({1e-3});
    ASSERT_EQ(even.result.status, PlanStatus::solved) << even.result.message;
    ForwardScene s = braced_arm();
    for (int i = 1; i <= 8; ++i) {
      const double turn = 0.8 * i / 8;
      s.scene.start_points.push_back({0.1 / 0.8 * std::sin(turn), side * 0.1 / 0.8 * (1.0 - std::cos(turn))});
    }
    const Execution e = s.run({1e-3});
    ASSERT_EQ(e.result.status, PlanStatus::solved) << e.result.message;
    EXPECT_EQ(e.result.contacts.size(), even.result.contacts.size());
    EXPECT_NEAR(e.result.tip_x, even.result.tip_x, 1e-9);
    EXPECT_NEAR(e.result.tip_y, even.result.tip_y, 1e-9);
    EXPECT_NEAR(e.result.start_backbone.back().y, s.scene.start_points.back().y, 2e-3);
  }
}

}  // namespace
}  // namespace tendril::support
