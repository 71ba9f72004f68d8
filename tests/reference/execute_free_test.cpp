#include <gtest/gtest.h>

#include <cmath>

#include "execute_support.hpp"
#include "support/print.hpp"
#include "support/reference_table.hpp"

namespace tendril::support {
namespace {

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

TEST(ExecuteFree, MomentsThatFallAlongTheRodTable) {
  const ReferenceTable table("profile");
  for (std::size_t row = 0; row < table.rows(); ++row) {
    ForwardScene s;
    s.weight(table.value(row, "weight"));
    // A tendon only pulls: it is its side that bends one way or the other.
    const double tension = std::abs(table.value(row, "moment"));
    const double side = table.value(row, "moment") < 0.0 ? -1.0 : 1.0;
    ActuatorSpec& tendon = s.scene.rod.actuators[0];
    tendon.kind = ActuatorKind::tendon;
    tendon.offset = {{0.0, side}, {1.0, side * table.value(row, "profile_end")}};
    (side < 0.0 ? tendon.maximum : tendon.minimum) = 0.0;
    const Execution e = s.run({tension * tendon.largest_offset()});
    ASSERT_EQ(e.result.status, PlanStatus::solved) << e.result.message;
    constexpr double reference = 1e-9;  // of L
    EXPECT_NEAR(e.result.tip_x, table.value(row, "tip_x"), reference) << row;
    EXPECT_NEAR(e.result.tip_y, table.value(row, "tip_y"), reference) << row;
    EXPECT_NEAR(e.result.tip_angle, table.value(row, "tip_angle"), reference) << row;
    // int h kappa ds from the shape that is reported, by the trapezoidal rule on its samples.
    double shortening = 0.0;
    const std::vector<BackbonePoint>& line = e.result.backbone;
    const auto rate = [&](const BackbonePoint& p) {
      return side * (1.0 + (table.value(row, "profile_end") - 1.0) * p.s) * p.curvature;
    };
    for (std::size_t i = 1; i < line.size(); ++i) {
      shortening += 0.5 * (line[i].s - line[i - 1].s) * (rate(line[i]) + rate(line[i - 1]));
    }
    EXPECT_NEAR(e.result.turns[0] * tendon.largest_offset(), shortening, 1e-4) << row;
  }
}

}  // namespace
}  // namespace tendril::support
