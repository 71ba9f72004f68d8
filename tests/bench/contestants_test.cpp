#include "common/contestants.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "common/scenes.hpp"
#include "common/workload.hpp"
#include "support/contains.hpp"
#include "support/print.hpp"

namespace tendril::bench {
namespace {

plugins::Registry registry() { return plugins::Registry(plugins::Catalog(plugins::search_places({}))); }

std::vector<Scene> trial(const plugins::Registry& from) {
  const std::vector<BenchScene> all = bench_scenes(from, 1);
  return {all.front().scene};
}

// The planner restores and polishes whatever a solver refuses; that plan is not the solver's.
TEST(Contestants, WhoRefusesTheProgramIsLeftOutWithItsOwnReason) {
  plugins::Registry all = registry();
  const std::vector<std::string> found = all.names(ComponentKind::solver);
  if (std::find(found.begin(), found.end(), "nlopt") == found.end()) GTEST_SKIP() << "nlopt is not built";
  const std::vector<Contestant> two{
      {"plain", "nlopt", {}, Treatment::penalty},
      {"mma", "nlopt", {{"algorithm", RawValue{std::string("LD_MMA")}}}, Treatment::penalty}};
  std::vector<LeftOut> left_out;
  const std::vector<Contestant> able = able_contestants(all, two, trial(all), 2.0, left_out);
  ASSERT_EQ(able.size(), 1U);
  EXPECT_EQ(able.front().name, "plain");
  ASSERT_EQ(left_out.size(), 1U);
  EXPECT_EQ(left_out.front().what, "mma");
  EXPECT_TRUE(contains_text(left_out.front().why, "cannot take equality constraints"));
}

TEST(Contestants, AnOptionThatIsNotKnownIsAReason) {
  plugins::Registry all = registry();
  const std::string solver = all.names(ComponentKind::solver).front();
  const std::vector<Contestant> two{{"plain", solver, {}, Treatment::penalty},
                                    {"unknown", solver, {{"no_such", RawValue{std::string("x")}}}, Treatment::penalty}};
  std::vector<LeftOut> left_out;
  const std::vector<Contestant> able = able_contestants(all, two, trial(all), 2.0, left_out);
  ASSERT_EQ(able.size(), 1U);
  EXPECT_TRUE(contains_text(left_out.front().why, "no_such"));
}

TEST(Contestants, EverySolverTakesPartWithEveryTreatment) {
  plugins::Registry all = registry();
  std::vector<LeftOut> left_out;
  const std::vector<Contestant> found = find_contestants(all, left_out);
  for (const std::string& solver : all.names(ComponentKind::solver)) {
    EXPECT_EQ(std::count_if(found.begin(), found.end(),
                            [&](const Contestant& c) { return c.solver == solver && c.options.empty(); }),
              4)
        << solver;
  }
  EXPECT_TRUE(left_out.empty());
}

/// One program for each target and step, told apart by what the sweeps change.
TEST(ScenesFromFile, AreTheirStepsAndCases) {
  const auto of = [](const char* name, const std::vector<std::string>& settings = {}) {
    return scenes_from_file(std::string(TENDRIL_SCENES) + "/" + name, settings);
  };
  const std::vector<BenchScene> brace = of("brace.toml");
  ASSERT_EQ(brace.size(), 1U);
  EXPECT_TRUE(brace[0].targets.empty());

  // Two limits and four modes; carrying plans out is no program.
  const std::vector<BenchScene> paradigms = of("paradigms.toml");
  ASSERT_EQ(paradigms.size(), 6U);
  std::set<std::string> names;
  for (const BenchScene& one : paradigms) {
    names.insert(one.name);
    EXPECT_EQ(one.targets.size(), 25U) << one.name;
  }
  EXPECT_EQ(names.size(), 6U);
  EXPECT_TRUE(names.contains("paradigms, avoid, 0.0025 N m"));

  const std::vector<BenchScene> steps = of("trajectory.toml");
  ASSERT_EQ(steps.size(), 6U);  // two limits, three modes
  for (const BenchScene& one : steps) {
    ASSERT_EQ(one.targets.size(), 45U) << one.name;
    EXPECT_EQ(one.scene.problem, ProblemKind::pose);
    const Scene last = with_target(one, 44);
    EXPECT_NEAR(last.target.position->x, 0.09652, 1e-12);
    EXPECT_NEAR(last.target.position->y, 0.022, 1e-12);
    validate(last);
  }

  // Whatever a step has of its own goes with it.
  const std::vector<BenchScene> moving =
      of("brace.toml", {"problem=\"trajectory\"", "target.turns=0",
                        "trajectory.obstacle=[{name=\"obstacle 1\", shifts=[[0, 0], [1e-3, -2e-3]]}]"});
  ASSERT_EQ(moving.size(), 1U);
  ASSERT_EQ(moving[0].targets.size(), 2U);
  const Scene step = with_target(moving[0], 1);
  EXPECT_EQ(step.obstacles[0].place.shift, (Vec2{1e-3, -2e-3}));
  EXPECT_EQ(step.target.turns, 0);
  EXPECT_NEAR(step.target.position->x, 0.097, 1e-12);

  const std::vector<BenchScene> sizes = of("grasp_sizes.toml");
  ASSERT_EQ(sizes.size(), 26U);
  EXPECT_EQ(sizes[14].scene.gripper->object_diameter, 0.02);
  EXPECT_EQ(sizes[14].scene.contact.max_force, 10.0);
}

TEST(KnownScenes, KeepTheirDigitsWithTheFineBasis) {
  plugins::Registry all = registry();
  for (const KnownScene& known : known_scenes(all)) {
    const TimedPlan timed = timed_plan(all, known.scene);
    ASSERT_EQ(timed.plan.status, PlanStatus::solved) << known.name << ": " << timed.plan.message;
    const double length = known.scene.rod.length();
    // The default basis is 1e-9 L from the exact solution on these, the table's last digit included.
    EXPECT_NEAR(timed.plan.tip_x, known.tip.x, 2e-9 * length) << known.name;
    EXPECT_NEAR(timed.plan.tip_y, known.tip.y, 2e-9 * length) << known.name;
    EXPECT_NEAR(timed.plan.moments.front(), known.moment, 1e-12) << known.name;
  }
}

}  // namespace
}  // namespace tendril::bench
