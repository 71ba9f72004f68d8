#include <gtest/gtest.h>

#include <cmath>

#include "execute_support.hpp"
#include "support/print.hpp"
#include "support/reference_table.hpp"

namespace tendril::support {
namespace {

constexpr double exact = 1e-8;  // of L; what the forward problem promises

TEST(ExecuteFree, TipMomentGivesACircularArc) {
  for (const double m : {0.5, -2.0, 7.0, 25.0}) {
    const Execution e = ForwardScene().run({m});
    ASSERT_EQ(e.result.status, PlanStatus::solved) << e.result.message;
    EXPECT_NEAR(e.result.tip_x, std::sin(m) / m, exact) << m;
    EXPECT_NEAR(e.result.tip_y, (1.0 - std::cos(m)) / m, exact) << m;
    EXPECT_EQ(e.load, 1.0);
    EXPECT_TRUE(e.snaps.empty());
    EXPECT_TRUE(e.result.contacts.empty());
  }
}

TEST(ExecuteFree, SelfWeightTable) {
  const ReferenceTable table("self_weight");
  for (std::size_t row = 0; row < table.rows(); ++row) {
    ForwardScene s;
    s.weight(table.value(row, "weight"));
    const Execution e = s.run({table.value(row, "moment")});
    ASSERT_EQ(e.result.status, PlanStatus::solved) << e.result.message;
    EXPECT_NEAR(e.result.tip_x, table.value(row, "x"), exact) << row;
    EXPECT_NEAR(e.result.tip_y, table.value(row, "y"), exact) << row;
    EXPECT_NEAR(e.result.tip_angle, table.value(row, "theta"), exact) << row;
  }
}

TEST(ExecuteFree, TipForceTable) {
  const ReferenceTable table("tip_force");
  for (std::size_t row = 0; row < table.rows(); ++row) {
    ForwardScene s;
    s.scene.tip_load.force = {0.0, table.value(row, "alpha")};
    const Execution e = s.run({0.0});
    ASSERT_EQ(e.result.status, PlanStatus::solved) << e.result.message;
    EXPECT_NEAR(e.result.tip_angle, table.value(row, "theta"), exact) << row;
    EXPECT_NEAR(1.0 - e.result.tip_x, table.value(row, "u"), exact) << row;
    EXPECT_NEAR(e.result.tip_y, table.value(row, "w"), exact) << row;
  }
}

}  // namespace
}  // namespace tendril::support
