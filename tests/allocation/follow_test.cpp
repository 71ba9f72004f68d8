// A loop that follows a target at a steady rate allocates nothing of core's once it runs.

#include <gtest/gtest.h>

#include <cmath>

#include "counting_malloc.hpp"
#include "support/print.hpp"
#include "tendril/plugins/components.hpp"
#include "tendril/tolerances.hpp"

namespace tendril::test {

namespace {

/// An arm under its weight; with a peg it leans on that, within the limit of its motor.
Scene arm(bool braced, const std::string& solver) {
  Scene scene;
  scene.gravity = Vec2{0.0, -9.81};
  scene.rod.segments = {{.length = 0.1, .bending_stiffness = 4.9e-4, .linear_density = 0.084}};
  const double limit = braced ? 2.5e-3 : 5e-3;
  scene.rod.actuators = {{.from = 0.0, .to = 0.1, .minimum = -limit, .maximum = limit}};
  scene.coordinates.plugin = "legendre";
  scene.objectives = {{.plugin = "tip_pose", .weight = 100.0}, {.plugin = "actuation_effort", .weight = 1e-4}};
  scene.solver.plugin = solver;
  if (braced) {
    const auto number = [](double value) { return RawValue{value}; };
    scene.obstacles = {
        {"peg", "circle", {{"center", {RawValue::List{number(0.06), number(0.0)}}}, {"radius", number(0.008)}}}};
    scene.start_tip_angle = 0.5;
    scene.contact.mode = ContactModeName::allow;
  }
  return scene;
}

TargetSpec target(bool braced, int step) {
  return {.position = Vec2{0.096, (braced ? 0.016 : 0.0) + 1e-4 * step}, .angle = {}};
}

class Follow : public testing::TestWithParam<bool> {};

/// Newton ends where the slope of the Lagrangian is below 1e-10, wherever it came from: two ends of it agree to that
/// over the curvature of the objective, which is above 0.1 here.
constexpr double same = 1e-9;
constexpr double same_length = same * 0.1;                         // m, of L
constexpr double same_moment = same * 4.9e-4 / 0.1;                // N m, of EI/L
constexpr double same_force = 10.0 * same * 4.9e-4 / (0.1 * 0.1);  // N, of EI/L^2; it is steep in the moment

void allocates_nothing_once_it_runs(bool braced, plugins::Registry& registry, const std::string& solver) {
  SCOPED_TRACE(solver);
  Scene scene = arm(braced, solver);
  scene.target = target(braced, 0);
  validate(scene);
  Problem problem(scene, plugins::make_components(registry, scene));
  Plan plan = problem.plan();
  ASSERT_EQ(plan.status, PlanStatus::solved) << plan.message;
  ASSERT_EQ(plan.contacts.size(), braced ? 1U : 0U);
  int step = 1;
  for (; step <= 3; ++step) problem.follow(target(braced, step), plan);
  int without_solver = 0;
  std::int64_t hessians = 0;
  const long before = allocations();
  for (; step <= 40; ++step) {
    problem.follow(target(braced, step), plan);
    without_solver += plan.status == PlanStatus::solved && plan.solver.iterations == 0 ? 1 : 0;
    hessians += plan.evaluations.hessians;
  }
  const long allocated = allocations() - before;
  EXPECT_EQ(without_solver, 37);
  EXPECT_EQ(allocated, 0);
  // Most steps go by the factorization that there is.
  EXPECT_LT(hessians, 20);

  // It is the plan that is made from scratch, and says the same of itself.
  problem.set_target(target(braced, step - 1));
  const Plan fresh = problem.plan();
  ASSERT_EQ(fresh.status, PlanStatus::solved);
  // Second order in what is left of the slope, but for rounding.
  EXPECT_NEAR(plan.objective, fresh.objective, 1e-12);
  EXPECT_NEAR(plan.tip_x, fresh.tip_x, same_length);
  EXPECT_NEAR(plan.tip_y, fresh.tip_y, same_length);
  EXPECT_NEAR(*plan.target_error, *fresh.target_error, same_length);
  ASSERT_EQ(plan.moments.size(), fresh.moments.size());
  EXPECT_NEAR(plan.moments[0], fresh.moments[0], same_moment);
  ASSERT_EQ(plan.contacts.size(), fresh.contacts.size());
  for (std::size_t k = 0; k < plan.contacts.size(); ++k) {
    EXPECT_NEAR(plan.contacts[k].force, fresh.contacts[k].force, same_force);
    EXPECT_NEAR(plan.contacts[k].arc_length, fresh.contacts[k].arc_length, same_length);
    EXPECT_EQ(plan.contacts[k].obstacle_name, fresh.contacts[k].obstacle_name);
  }
  EXPECT_TRUE(plan.certificate.valid());
  EXPECT_NEAR(plan.certificate.stability, fresh.certificate.stability, 10.0 * same);
  EXPECT_EQ(plan.certificate.stationarity_kind, "S");
  EXPECT_NEAR(plan.backbone.back().x, plan.tip_x, 1e-12);
  for (std::size_t i = 0; !braced && i < fresh.backbone.size(); ++i) {
    ASSERT_EQ(plan.backbone.size(), fresh.backbone.size());
    EXPECT_NEAR(plan.backbone[i].s, fresh.backbone[i].s, same_length) << i;
    EXPECT_NEAR(norm(plan.backbone[i].position() - fresh.backbone[i].position()), 0.0, same_length) << i;
    EXPECT_NEAR(plan.backbone[i].angle, fresh.backbone[i].angle, same) << i;
  }
  EXPECT_EQ(plan.terms.size(), fresh.terms.size());
  EXPECT_EQ(plan.modes.size(), fresh.modes.size());
}

TEST_P(Follow, AllocatesNothingOnceItRuns) {
  plugins::Registry registry{plugins::Catalog(plugins::search_places({}))};
  const auto solvers = registry.names(ComponentKind::solver);
  ASSERT_FALSE(solvers.empty());
  for (const std::string& solver : solvers) allocates_nothing_once_it_runs(GetParam(), registry, solver);
}

// The arm comes down on its peg and leaves it again.
TEST(FollowContacts, ComeAndGoWithoutASolver) {
  plugins::Registry registry{plugins::Catalog(plugins::search_places({}))};
  Scene scene = arm(true, registry.names(ComponentKind::solver).front());
  scene.rod.actuators[0].maximum = 1e-2;
  constexpr int steps = 50;
  const auto on_the_way = [](int i) {
    const double share = 1.0 - std::abs(1.0 - static_cast<double>(i) / steps);
    return TargetSpec{.position = Vec2{0.095 + 0.002 * share, 0.032 - 0.014 * share}, .angle = {}};
  };
  scene.target = on_the_way(0);
  Problem problem(scene, plugins::make_components(registry, scene));
  Problem other(scene, plugins::make_components(registry, scene));
  Plan plan = problem.plan();
  ASSERT_EQ(plan.status, PlanStatus::solved) << plan.message;
  ASSERT_TRUE(plan.contacts.empty());
  int changes = 0;
  for (int i = 1; i <= 2 * steps; ++i) {
    const std::size_t before = plan.contacts.size();
    problem.follow(on_the_way(i), plan);
    ASSERT_EQ(plan.status, PlanStatus::solved) << plan.message;
    EXPECT_TRUE(plan.certificate.valid());
    EXPECT_EQ(plan.solver.iterations, 0) << i;
    if (plan.contacts.size() == before) continue;
    ++changes;
    other.set_target(on_the_way(i));
    const Plan fresh = other.plan();
    EXPECT_EQ(fresh.contacts.size(), plan.contacts.size());
    EXPECT_NEAR(plan.objective, fresh.objective, 1e-12);
    EXPECT_NEAR(plan.tip_x, fresh.tip_x, same_length);
    EXPECT_NEAR(plan.tip_y, fresh.tip_y, same_length);
  }
  EXPECT_EQ(changes, 2);
  EXPECT_TRUE(plan.contacts.empty());
}

TEST_P(Follow, PlansInFullWhereNewtonAloneDoesNotDo) {
  const bool braced = GetParam();
  plugins::Registry registry{plugins::Catalog(plugins::search_places({}))};
  Scene scene = arm(braced, registry.names(ComponentKind::solver).front());
  scene.target = target(braced, 0);
  Problem problem(scene, plugins::make_components(registry, scene));
  Plan plan = problem.plan();
  ASSERT_EQ(plan.status, PlanStatus::solved);
  // To the other side, and from a plan that was never certified.
  const TargetSpec far{.position = Vec2{0.08, -0.03}, .angle = {}};
  problem.follow(far, plan);
  EXPECT_EQ(plan.status, PlanStatus::solved) << plan.message;
  const double objective = plan.objective;
  Plan nothing;
  problem.follow(far, nothing);
  EXPECT_EQ(nothing.status, PlanStatus::solved) << nothing.message;
  EXPECT_LE(objective, nothing.objective + 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Arm, Follow, testing::Bool(),
                         [](const testing::TestParamInfo<bool>& c) { return c.param ? "braced" : "free"; });

}  // namespace

}  // namespace tendril::test
