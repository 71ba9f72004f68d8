// All equilibria over the box of moments: what a thorough search says of its plan, and what it finds with them alone.

#include <cmath>

#include "combination/support.hpp"
#include "search/parameters.hpp"
#include "tendril/execute.hpp"

namespace tendril::search {
namespace {

using combination::certified;
using combination::scene;

Plan thorough(Scene made) {
  made.effort = SearchEffort::thorough;
  made.solver.time_limit = 300.0;
  return combination::plan(made);
}

/// A number that steers the search is another one while this lives.
class Steered {
 public:
  Steered(std::string name, const std::string& value) : name_(std::move(name)) {
    for (const SearchParameter& p : list_search_parameters()) {
      if (p.name == name_) before_ = p.value;
    }
    set_search_parameter(name_, value);
  }
  ~Steered() { set_search_parameter(name_, before_); }
  Steered(const Steered&) = delete;
  Steered& operator=(const Steered&) = delete;

 private:
  std::string name_, before_;
};

TEST(SearchScan, ThePlanIsCompleteToAResolution) {
  const Scene made = scene("brace");
  const Plan plan = thorough(made);
  ASSERT_TRUE(certified(plan));
  ASSERT_TRUE(plan.scan);
  EXPECT_TRUE(plan.scan->complete()) << plan.scan->lost << " lost, " << plan.scan->unresolved << " unresolved";
  ASSERT_EQ(plan.scan->steps.size(), 1U);
  const ActuatorSpec& actuator = made.rod.actuators.front();
  EXPECT_NEAR(plan.scan->steps[0] * search_parameters().fine_scan, actuator.maximum - actuator.minimum, 1e-12);
  // At every moment the rod rests somewhere, and with some of them on either side of the peg.
  EXPECT_GT(plan.scan->equilibria, search_parameters().fine_scan + 1);
}

// Executions from all sides under many moments lead to no plan that costs less.
TEST(SearchScan, NoExecutionLeadsToABetterPlan) {
  Scene made = scene("brace");
  const Plan plan = thorough(made);
  ASSERT_TRUE(plan.scan && plan.scan->complete());
  made.effort = SearchEffort::fast;
  const auto obstacles = std::move(plugins::make_components(combination::registry(), made).obstacles);
  const ActuatorSpec& actuator = made.rod.actuators.front();
  int rests = 0;
  for (const double angle : {-2.5, -0.7, 0.9, 2.5}) {
    for (int i = 0; i <= 8; ++i) {
      made.start_tip_angle = angle;
      const Plan rest =
          execute(made, obstacles, {actuator.minimum + i * (actuator.maximum - actuator.minimum) / 8.0}).result;
      if (rest.status != PlanStatus::solved) continue;
      ++rests;
      PlanControl control;
      control.start = &rest;
      const Plan found = combination::plan(made, control);
      if (found.status == PlanStatus::solved) {
        EXPECT_GE(found.objective, plan.objective - 1e-6);
      }
    }
  }
  EXPECT_GT(rests, 20);
}

/// A rod above a table of which the target lies on the other side.
const char* const above_a_table = R"(
problem = "pose"
rod = {length = "1.3 m", bending_stiffness = "17 N m^2", actuator = [{limit = "20 N m"}]}
start = {tip_angle = 1.8}
contact = {mode = "require", min_force = "1 N"}
target = {position = ["0 m", "-0.8 m"]}
obstacle = [{name = "table", shape = "wall", point = ["0.5 m", "-0.18 m"], normal = [-0.14, 0.99]}]
objective = [{plugin = "tip_pose"}, {plugin = "actuation_effort", weight = 1e-4}]
)";

// Curled up, the rod comes to lie against the table from where no start beside it leads to.
TEST(SearchLetGo, AnArcThatIsLetGoLeadsToABetterPlan) {
  for (const std::string& solver : combination::solvers_to_combine()) {
    SCOPED_TRACE(solver);
    const Scene made = combination::scene_from_text(above_a_table, {"solver.plugin=" + solver});
    const Plan found = combination::plan(made);
    ASSERT_TRUE(certified(found));
    const Steered arcs("relaxed_arcs", "0");
    const Plan without = combination::plan(made);
    ASSERT_TRUE(certified(without));
    EXPECT_LT(found.objective, 0.5 * without.objective);
  }
}

TEST(SearchScan, FindsThePlanThatNoStartLeadsTo) {
  const Scene below = scene("brace", {"start.tip_angle=-0.5"});
  const Steered sides("sides", "0");
  const Steered starts("most_starts", "1");
  const Steered rests("ask_rests", "0");
  const Steered arcs("relaxed_arcs", "0");
  const Plan found = thorough(below);
  ASSERT_TRUE(certified(found));
  EXPECT_LT(found.objective, 0.01);
  EXPECT_TRUE(found.scan->complete());
  const Steered scan("scan", "0");
  const Plan missed = thorough(below);
  EXPECT_FALSE(missed.scan);
  EXPECT_GT(missed.objective, found.objective + 1.0);
}

TEST(SearchScan, OnlyAThoroughSearchWithinLimitsMakesOne) {
  EXPECT_FALSE(combination::plan(scene("brace")).scan);
  Scene free = scene("brace");
  free.rod.actuators.front().maximum = infinity;
  EXPECT_FALSE(thorough(free).scan);
}

}  // namespace
}  // namespace tendril::search
