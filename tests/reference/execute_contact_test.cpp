#include <gtest/gtest.h>

#include <cmath>

#include "execute_support.hpp"
#include "support/reference_table.hpp"

namespace tendril::support {
namespace {

constexpr double exact = 1e-8;    // of L; what the forward problem promises
constexpr double forceful = 1e-6;  // of the force; likewise

ForwardScene braced_arm() {
  ForwardScene s;
  s.scene.rod.segments = {{0.1, 4.9e-4, 0.084, 0.0}};
  s.scene.rod.actuators[0].to = 0.1;
  s.scene.gravity = Vec2{0.0, -9.81};
  s.circle(0.6, 0.0, 0.08);
  s.scene.start_tip_angle = 0.5;
  return s;
}

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

}  // namespace
}  // namespace tendril::support
