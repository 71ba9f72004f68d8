// A target that has to be met: rows that hold the tip near it, and what is said where they cannot.

#include <cmath>
#include <optional>

#include "combination/support.hpp"
#include "support/contains.hpp"
#include "tendril/error.hpp"

namespace tendril::search {
namespace {

using combination::certified;
using combination::scene;

// Effort pulls the tip away from the target, as far as it may.
TEST(TargetTolerance, HoldsTheTipWithEverySolver) {
  std::optional<double> objective;
  for (const std::string& solver : combination::solvers_to_combine()) {
    SCOPED_TRACE(solver);
    Scene made = scene("brace", {"objective.1.weight=10"});
    const Plan free = combination::plan_with(made, solver);
    ASSERT_TRUE(certified(free));
    made.target.position_tolerance = 2e-3;
    const Plan held = combination::plan_with(made, solver);
    ASSERT_TRUE(certified(held));
    EXPECT_GT(*free.target_error, 2.1e-3);
    EXPECT_NEAR(*held.target_error, 2e-3, 1e-11);
    EXPECT_GT(held.objective, free.objective);
    EXPECT_NEAR(held.objective, objective.value_or(held.objective), 1e-9 * held.objective);
    objective = held.objective;
  }
}

TEST(TargetTolerance, OfTheDirectionCountsModuloATurn) {
  for (const double turn : {0.0, 2.0 * M_PI, -2.0 * M_PI}) {
    Scene made = scene("brace", {"objective.1.weight=10"});
    made.target.angle = 0.3 + turn;
    made.target.angle_tolerance = 0.02;
    const Plan plan = combination::plan_with(made, "nlopt");
    ASSERT_TRUE(certified(plan)) << turn;
    EXPECT_LE(std::abs(plan.tip_angle - 0.3), 0.02 + 1e-9) << turn;
  }
}

TEST(TargetTolerance, ThatLeavesThePlanFreeChangesNothing) {
  Scene made = scene("brace");
  const Plan without = combination::plan_with(made, "nlopt");
  made.target.position_tolerance = 1e-3;
  const Plan with = combination::plan_with(made, "nlopt");
  ASSERT_TRUE(certified(with));
  EXPECT_NEAR(with.objective, without.objective, 1e-9 * without.objective);
  EXPECT_NEAR(with.tip_x, without.tip_x, 1e-9 * without.tip_x);
}

TEST(TargetTolerance, OutOfReachIsInfeasibleWithTheNearestPose) {
  for (const std::string& solver : combination::solvers_to_combine()) {
    SCOPED_TRACE(solver);
    Scene made = scene("brace");
    const Plan without = combination::plan_with(made, solver);
    made.target.position_tolerance = 0.1e-3;
    const Plan plan = combination::plan_with(made, solver);
    EXPECT_EQ(plan.status, PlanStatus::infeasible);
    EXPECT_TRUE(contains_text(plan.message, "comes within 0.000422 m of the target")) << plan.message;
    EXPECT_NEAR(*plan.target_error, *without.target_error, 1e-8);
    EXPECT_FALSE(plan.backbone.empty());
  }
}

TEST(TargetTolerance, BadOnesAreRefused) {
  const auto refused = [](auto change) {
    Scene made = scene("brace");
    change(made.target);
    try {
      (void)combination::plan(made);
    } catch (const SceneError& e) {
      return e.path() + ": " + e.what();
    }
    return std::string("planned");
  };
  EXPECT_TRUE(contains_text(refused([](TargetSpec& t) { t.position_tolerance = 0.0; }), "target.position_tolerance"));
  EXPECT_TRUE(contains_text(refused([](TargetSpec& t) { t.position_tolerance = NAN; }), "target.position_tolerance"));
  EXPECT_TRUE(contains_text(refused([](TargetSpec& t) { t.angle_tolerance = 0.1; }), "expected 'angle' beside it"));
}

}  // namespace
}  // namespace tendril::search
