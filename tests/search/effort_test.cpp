// How far is looked, what was found on the way, and what a reader should know first.

#include <cmath>

#include "combination/support.hpp"
#include "support/contains.hpp"

namespace tendril::search {
namespace {

using combination::certified;
using combination::scene;

Plan planned(Scene made, SearchEffort effort, const std::string& solver = {}) {
  made.effort = effort;
  if (!solver.empty()) made.solver.plugin = solver;
  return combination::plan(made);
}

bool noted(const Plan& plan, const std::string& text) {
  return std::any_of(plan.notes.begin(), plan.notes.end(),
                     [&](const std::string& note) { return contains_text(note, text); });
}

// More effort looks at all that less looks at.
TEST(SearchEffort, MoreOfItFindsNoWorsePlanWithAnySolver) {
  for (const std::string& solver : combination::solvers_to_combine()) {
    SCOPED_TRACE(solver);
    for (const char* name : {"brace", "two_pegs"}) {
      SCOPED_TRACE(name);
      double before = infinity;
      for (const SearchEffort effort : {SearchEffort::fast, SearchEffort::normal, SearchEffort::thorough}) {
        SCOPED_TRACE(to_string(effort));
        Scene made = scene(name, {"start.tip_angle=0"});
        made.solver.time_limit = 300.0;
        const Plan plan = planned(made, effort, solver);
        if (plan.status != PlanStatus::solved && effort == SearchEffort::fast) continue;
        ASSERT_TRUE(certified(plan));
        EXPECT_LE(plan.objective, before + 1e-6 * std::max(1.0, std::abs(before)));
        before = plan.objective;
      }
    }
  }
}

TEST(SearchEffort, FastStartsEveryWayOnce) {
  const Plan plan = planned(scene("brace", {"start.tip_angle=0"}), SearchEffort::fast);
  const Plan more = planned(scene("brace", {"start.tip_angle=0"}), SearchEffort::normal);
  EXPECT_LT(plan.evaluations.values, more.evaluations.values);
  EXPECT_GT(plan.objective, 1.0);
  EXPECT_LT(more.objective, 0.01);
}

TEST(SearchMinima, AreDistinctAndTheBestIsThePlan) {
  const Plan plan = planned(scene("brace", {"start.tip_angle=0"}), SearchEffort::thorough);
  ASSERT_TRUE(certified(plan));
  ASSERT_GE(plan.minima.size(), 2U);
  EXPECT_EQ(plan.minima[0].objective, plan.objective);
  EXPECT_EQ(plan.minima[0].moments, plan.moments);
  for (std::size_t i = 1; i < plan.minima.size(); ++i) {
    EXPECT_LE(plan.minima[i - 1].objective, plan.minima[i].objective);
  }
  // The arm braces itself above the peg, which then lies to its right; below it there is a plan too.
  const auto on = [&](const std::string& side) {
    return std::count_if(plan.minima.begin(), plan.minima.end(),
                         [&](const PlanMinimum& m) { return m.sides.at(0) == side; });
  };
  EXPECT_EQ(plan.minima[0].sides.at(0), "right");
  EXPECT_GE(on("left"), 1);
}

TEST(SearchNotes, AStartThroughAnObstacleIsNamed) {
  EXPECT_TRUE(
      noted(planned(scene("brace", {"start.tip_angle=0"}), SearchEffort::normal),
            "the start runs through 'obstacle 1', 8 % of the length deep: starts beside it were tried as well"));
  EXPECT_FALSE(noted(planned(scene("brace", {"start.tip_angle=1"}), SearchEffort::normal), "the start runs"));
}

TEST(SearchNotes, ATargetThatIsMissedIsTold) {
  const std::string missed = "the tip misses the target by ";
  EXPECT_FALSE(noted(planned(scene("brace"), SearchEffort::normal), missed));
  const Plan far = planned(scene("brace", {"target.position=[\"150 mm\", \"20 mm\"]"}), SearchEffort::normal);
  EXPECT_TRUE(noted(far, missed));
  EXPECT_TRUE(noted(far, "the target lies out of reach, by 51.3 % of the length"));
  Scene unread = scene("brace");
  std::erase_if(unread.objectives, [](const ObjectiveSpec& o) { return o.plugin == "tip_pose"; });
  EXPECT_TRUE(noted(planned(unread, SearchEffort::normal), "no objective reads the target"));
}

}  // namespace
}  // namespace tendril::search
