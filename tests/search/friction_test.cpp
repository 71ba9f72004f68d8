// What the unknown state of friction can do to a plan: intervals that contain every state that friction allows.

#include <algorithm>
#include <cmath>

#include "combination/support.hpp"
#include "support/contains.hpp"
#include "support/reference_table.hpp"

namespace tendril::search {
namespace {

using combination::scene;

Scene braced(double moment, double friction, const std::string& solver) {
  Scene made = scene("brace");
  made.solver.plugin = solver;
  made.rod.actuators[0].minimum = made.rod.actuators[0].maximum = moment;
  made.contact.friction = friction;
  return made;
}

class Friction : public testing::TestWithParam<const char*> {};

// tests/reference/data/friction.csv: at 1 N mm the table has the corners of the cone of 0.3.
TEST_P(Friction, RangeOfTheBracedArmEndsAtTheReference) {
  const Plan plan = combination::plan(braced(1e-3, 0.3, GetParam()));
  ASSERT_EQ(plan.status, PlanStatus::solved) << plan.message;
  ASSERT_EQ(plan.friction.size(), 3U);
  const support::ReferenceTable table("friction");
  int met = 0;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (table.value(row, "moment") != 1e-3) continue;
    for (const FrictionRange& state : plan.friction) {
      ASSERT_EQ(state.ratios.size(), 1U);
      if (state.ratios[0] != table.value(row, "friction_ratio")) continue;
      ++met;
      EXPECT_NEAR(state.tip_x, table.value(row, "tip_x"), 1e-9);
      EXPECT_NEAR(state.tip_y, table.value(row, "tip_y"), 1e-9);
      EXPECT_NEAR(state.tip_angle, table.value(row, "tip_angle"), 1e-8);
      ASSERT_EQ(state.contacts.size(), 1U);
      EXPECT_NEAR(state.contacts[0].force / table.value(row, "normal_force"), 1.0, 1e-7);
    }
  }
  EXPECT_EQ(met, 3);
}

TEST_P(Friction, WidensWithTheCoefficient) {
  double before = 0.0;
  for (const double mu : {0.1, 0.3, 0.6}) {
    const Plan plan = combination::plan(braced(1e-3, mu, GetParam()));
    ASSERT_EQ(plan.status, PlanStatus::solved) << plan.message;
    const auto [low, high] =
        std::minmax_element(plan.friction.begin(), plan.friction.end(),
                            [](const FrictionRange& a, const FrictionRange& b) { return a.tip_y < b.tip_y; });
    EXPECT_GT(high->tip_y - low->tip_y, before);
    before = high->tip_y - low->tip_y;
  }
}

INSTANTIATE_TEST_SUITE_P(Solvers, Friction, testing::Values("nlopt", "ipopt", "ceres"),
                         [](const auto& each) { return std::string(each.param); });

TEST(FrictionRange, OfAnObstacleAloneCountsAndNoneIsTheSamePlan) {
  Scene made = scene("brace");
  const Plan without = combination::plan(made);
  EXPECT_TRUE(without.friction.empty());
  made.obstacles[0].friction = 0.2;
  const Plan with = combination::plan(made);
  ASSERT_EQ(with.friction.size(), 3U);
  EXPECT_EQ(with.moments, without.moments);
  EXPECT_EQ(with.coordinates, without.coordinates);
  made.contact.friction_state = FrictionState::none;
  EXPECT_TRUE(combination::plan(made).friction.empty());
}

// Glue may do what friction cannot: the arm lifts off its peg on the way.
TEST(FrictionRange, APlanWhoseRodGivesWayIsNotSolved) {
  Scene made = scene("brace");
  made.contact.friction = 10.0;
  const Plan plan = combination::plan(made);
  EXPECT_EQ(plan.status, PlanStatus::unstable);
  EXPECT_TRUE(plan.friction.empty());
  EXPECT_TRUE(contains_text(plan.message, "of the ratios -10 at 'obstacle 1': the rod gives way")) << plan.message;
}

TEST(FrictionRange, SenselessCoefficientsAreRefused) {
  const auto refusal = [](auto&& change) -> std::string {
    Scene made = scene("brace");
    change(made);
    try {
      validate(made);
    } catch (const SceneError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_TRUE(contains_text(refusal([](Scene& s) { s.contact.friction = -0.1; }), "must not be negative"));
  EXPECT_TRUE(contains_text(refusal([](Scene& s) { s.obstacles[0].friction = 30.0; }), "expected 0 to 10"));
  EXPECT_TRUE(contains_text(refusal([](Scene& s) {
                              s.contact.friction = 0.3;
                              s.contact.mode = ContactModeName::avoid;
                            }),
                            "no friction where contact is not planned"));
}

}  // namespace
}  // namespace tendril::search
