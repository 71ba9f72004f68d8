// Numbers of any size: weights, of which only ratios count, and obstacles that a step of any solver passes over.

#include <cmath>

#include "support.hpp"
#include "support/print.hpp"
#include "tendril/execute.hpp"

namespace tendril::combination {
namespace {

Plan weighted(double factor) {
  Scene brace = scene("brace");
  for (ObjectiveSpec& objective : brace.objectives) objective.weight *= factor;
  return plan(brace);
}

TEST(Weights, OnlyTheirRatiosCount) {
  const Plan own = weighted(1.0);
  ASSERT_TRUE(certified(own));
  for (const double factor : {0x1p-40, 0x1p40}) {
    // The largest weight becomes 1 by a division that is exact here: the same program, bit by bit.
    const Plan scaled = weighted(factor);
    ASSERT_TRUE(certified(scaled));
    EXPECT_EQ(scaled.coordinates, own.coordinates) << factor;
    EXPECT_EQ(scaled.moments, own.moments) << factor;
    EXPECT_EQ(scaled.objective, factor * own.objective) << factor;
    ASSERT_EQ(scaled.terms.size(), own.terms.size());
    for (std::size_t i = 0; i < own.terms.size(); ++i) EXPECT_EQ(scaled.terms[i].second, factor * own.terms[i].second);
  }
  for (const double factor : {1e-12, 1e12}) {
    // Here the quotients are rounded; the plan is polished to 1e-11.
    const Plan scaled = weighted(factor);
    ASSERT_TRUE(certified(scaled));
    for (std::size_t i = 0; i < own.coordinates.size(); ++i) {
      EXPECT_NEAR(scaled.coordinates[i], own.coordinates[i], 1e-10) << factor;
    }
    EXPECT_NEAR(scaled.objective / factor, own.objective, 1e-12 * own.objective) << factor;
  }
}

// Such an obstacle is swollen until a contact with it can be found, and shrinks back.
TEST(TinyObstacle, IsLeanedOnLikeAnyOther) {
  const double length = 0.1;  // of the rod in scenes/brace.toml
  for (const std::string& solver : registry().names(ComponentKind::solver)) {
    for (const double radius : {1e-4, 1e-6}) {
      SCOPED_TRACE(solver + ", radius " + std::to_string(radius) + " L");
      Scene brace = scene("brace");
      brace.solver.plugin = solver;
      // Its top is where the peg's is.
      const double height = 0.08 - radius;
      brace.obstacles[0].options["center"] = {RawValue::List{{0.6 * length}, {height * length}}, {}};
      brace.obstacles[0].options["radius"] = {radius * length, {}};
      const Plan found = plan(brace);
      ASSERT_TRUE(certified(found));
      ASSERT_EQ(found.contacts.size(), 1u);
      const PlannedContact& contact = found.contacts[0];
      EXPECT_NEAR(std::hypot(contact.point.x - 0.6 * length, contact.point.y - height * length), radius * length,
                  1e-9 * length);
      // The forward problem finds the contact in another way: along a path of growing loads.
      const Execution fine = execute(brace, plugins::make_obstacles(registry(), brace), found.moments);
      ASSERT_EQ(fine.result.status, PlanStatus::solved) << fine.result.message;
      ASSERT_EQ(fine.result.contacts.size(), 1u);
      // What six functions on each side of the contact leave, as in exact_test.cpp.
      EXPECT_NEAR(found.tip_x / length, fine.result.tip_x / length, 1e-8);
      EXPECT_NEAR(found.tip_y / length, fine.result.tip_y / length, 1e-8);
      EXPECT_NEAR(contact.force / fine.result.contacts[0].force, 1.0, 1e-7);
    }
  }
}

}  // namespace
}  // namespace tendril::combination
