// What the unknown state of friction can do to a plan: intervals that contain every state that friction allows. And
// plans for the worst of these states, or for any of them, against what execution makes of moments and ratios nearby.

#include "problem/friction.hpp"

#include <algorithm>
#include <cmath>

#include "combination/support.hpp"
#include "search/friction_states.hpp"
#include "support/contains.hpp"
#include "support/reference_table.hpp"
#include "tendril/execute.hpp"
#include "tendril/tolerances.hpp"
#include "tendril/trajectory.hpp"

namespace tendril::search {
namespace {

using combination::scene;

/// What a pose costs that execution comes to at these moments, contacts pushing so far off their normals: by the
/// formulas of tip_pose (position alone) and actuation_effort.
double executed_cost(const Scene& scene, const Plan& from, const std::vector<double>& moments,
                     const std::vector<double>& ratios) {
  ExecuteControl control;
  control.start = &from;
  control.with_friction = false;
  control.friction = ratios;
  const Execution e =
      execute(scene, plugins::make_components(combination::registry(), scene).obstacles, moments, control);
  if (e.result.status != PlanStatus::solved) {
    ADD_FAILURE() << e.result.message;
    return infinity;
  }
  const double length = scene.rod.length();
  const double unit = scene.rod.segments.front().bending_stiffness / length;
  double cost = 0.0;
  for (const ObjectiveSpec& o : scene.objectives) {
    if (o.plugin == "tip_pose")
      cost += o.weight * std::pow(norm(Vec2{e.result.tip_x, e.result.tip_y} - *scene.target.position) / length, 2);
    for (const double m : moments) cost += o.plugin == "actuation_effort" ? o.weight * std::pow(m / unit, 2) : 0.0;
  }
  return cost;
}

/// The largest of such costs over a grid of ratios within the cones, the same at all obstacles or opposite.
double worst_cost(const Scene& scene, const Plan& from, const std::vector<double>& moments, int steps) {
  double worst = 0.0;
  for (const double sign : {1.0, -1.0}) {
    if (sign < 0.0 && scene.obstacles.size() == 1) continue;
    for (int i = -steps; i <= steps; ++i) {
      std::vector<double> ratios(scene.obstacles.size(), scene.contact.friction * i / steps);
      if (ratios.size() > 1) ratios[1] *= sign;
      worst = std::max(worst, executed_cost(scene, from, moments, ratios));
    }
  }
  return worst;
}

Scene with_state(Scene scene, double friction, FrictionState state) {
  scene.contact.friction = friction;
  scene.contact.friction_state = state;
  return scene;
}

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

TEST_P(Friction, WorstOfTheBracedArmIsTheLeastOfTheWorst) {
  Scene made = with_state(scene("brace"), 0.6, FrictionState::worst);
  made.solver.plugin = GetParam();
  const Plan plan = combination::plan(made);
  ASSERT_TRUE(combination::certified(plan));
  EXPECT_EQ(plan.friction.size(), 3U);
  // Nowhere in the cone is it worse, and the plan shows a state at the edge.
  EXPECT_NEAR(worst_cost(made, plan, plan.moments, 4) / plan.objective, 1.0, 1e-7);
  ASSERT_EQ(plan.contacts.size(), 1U);
  EXPECT_NEAR(std::abs(plan.contacts[0].tangential) / plan.contacts[0].force, 0.6, 1e-12);
  EXPECT_FALSE(plan.contacts[0].sticks);
  ASSERT_TRUE(plan.certificate.friction.has_value());
  EXPECT_LE(*plan.certificate.friction, tolerance::friction);
  // Other moments near are worse, and so is the plan without friction.
  for (const double share : {0.997, 1.003}) {
    EXPECT_GT(worst_cost(made, plan, {share * plan.moments[0]}, 1), plan.objective);
  }
  const Plan without = combination::plan(with_state(made, 0.0, FrictionState::range));
  EXPECT_LT(without.objective, plan.objective);
  EXPECT_GT(worst_cost(made, without, without.moments, 1), plan.objective);
}

TEST_P(Friction, AnyOfTheBracedArmIsTheBestOfAll) {
  Scene made = with_state(scene("brace"), 0.6, FrictionState::any);
  made.solver.plugin = GetParam();
  Plan plan = combination::plan(made);
  ASSERT_TRUE(combination::certified(plan));
  ASSERT_EQ(plan.contacts.size(), 1U);
  const double ratio = plan.contacts[0].tangential / plan.contacts[0].force;
  EXPECT_LE(std::abs(ratio), 0.6 + 1e-9);
  EXPECT_NE(ratio, 0.0);
  EXPECT_NEAR(executed_cost(made, plan, plan.moments, {ratio}) / plan.objective, 1.0, 1e-7);
  for (const double share : {0.99, 1.01}) {
    EXPECT_GT(executed_cost(made, plan, {share * plan.moments[0]}, {ratio}), plan.objective);
  }
  for (const double other : {-0.6, 0.0, 0.6}) {
    // To what a stationarity of 1e-6 leaves.
    EXPECT_GE(executed_cost(made, plan, plan.moments, {other}), plan.objective * (1.0 - 1e-5));
  }
  EXPECT_LT(plan.objective, combination::plan(with_state(made, 0.0, FrictionState::range)).objective);
  verify(made, plugins::make_components(combination::registry(), made).obstacles, plan, {});
  EXPECT_EQ(plan.status, PlanStatus::solved) << plan.message;
  EXPECT_LT(plan.model_error.value_or(1.0), 1e-9);
}

TEST(FrictionPlans, OfTwoContactsTakeEveryCornerWithEveryTreatment) {
  for (const Treatment treatment : {Treatment::penalty, Treatment::scholtes}) {
    Scene made = with_state(scene("two_pegs"), 0.3, FrictionState::worst);
    made.contact.treatment = treatment;
    const Plan worst = combination::plan(made);
    ASSERT_TRUE(combination::certified(worst));
    ASSERT_EQ(worst.contacts.size(), 2U);
    EXPECT_EQ(worst.friction.size(), 5U);
    EXPECT_NEAR(worst_cost(made, worst, worst.moments, 1) / worst.objective, 1.0, 1e-7);
    const Plan any = combination::plan(with_state(made, 0.3, FrictionState::any));
    ASSERT_TRUE(combination::certified(any));
    std::vector<double> ratios;
    for (const PlannedContact& c : any.contacts) ratios.push_back(c.tangential / c.force);
    ASSERT_EQ(ratios.size(), 2U);
    EXPECT_NEAR(executed_cost(made, any, any.moments, ratios), any.objective, 1e-9);
    EXPECT_LT(any.objective, combination::plan(with_state(made, 0.3, FrictionState::range)).objective);
    EXPECT_GT(worst.objective, any.objective);
  }
}

// Whatever solves and describes the rod: each plan is certified with all its states, and for any state costs no more
// than without friction, which costs no more than for the worst.
TEST_P(Friction, CombinesWithEveryCoordinateModelAndTreatment) {
  const std::vector<std::pair<std::string, RawOptions>> models{
      {"pcc", {{"pieces", {std::int64_t{3}}}}}, {"psc", {}}, {"legendre", {{"order", {std::int64_t{4}}}}}};
  for (const char* name : {"brace", "two_pegs"}) {
    for (const auto& [model, options] : models) {
      for (const Treatment treatment :
           {Treatment::penalty, Treatment::slack, Treatment::scholtes, Treatment::fischer_burmeister}) {
        SCOPED_TRACE(std::string(name) + ", " + model + ", treatment " + std::to_string(static_cast<int>(treatment)));
        Scene made = scene(name);
        made.coordinates.plugin = model;
        made.coordinates.options = options;
        made.solver.plugin = GetParam();
        made.contact.treatment = treatment;
        std::vector<double> costs;
        for (const FrictionState state : {FrictionState::any, FrictionState::range, FrictionState::worst}) {
          const Plan plan = combination::plan(with_state(made, 0.3, state));
          ASSERT_TRUE(combination::certified(plan));
          EXPECT_EQ(plan.friction.size(), (std::size_t{1} << made.obstacles.size()) + 1U);
          costs.push_back(plan.objective);
        }
        EXPECT_LE(costs[0], costs[1] + 1e-9);
        EXPECT_LE(costs[1], costs[2] + 1e-9);
      }
    }
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

// The states that are followed in the plan's own coordinates are those that execution comes to.
TEST(FrictionRange, OfTwoContactsIsWhatExecutionComesTo) {
  const Scene made = with_state(scene("two_pegs"), 0.3, FrictionState::range);
  const Plan plan = combination::plan(made);
  ASSERT_EQ(plan.friction.size(), 5U);
  for (const FrictionRange& state : plan.friction) {
    ExecuteControl control;
    control.start = &plan;
    control.with_friction = false;
    control.friction = state.ratios;
    const Execution e = execute(made, plugins::make_components(combination::registry(), made).obstacles, plan, control);
    ASSERT_EQ(e.result.status, PlanStatus::solved) << e.result.message;
    EXPECT_NEAR(e.result.tip_x, state.tip_x, 1e-9);
    EXPECT_NEAR(e.result.tip_y, state.tip_y, 1e-9);
    ASSERT_EQ(e.result.contacts.size(), state.contacts.size());
    for (std::size_t k = 0; k < state.contacts.size(); ++k) {
      EXPECT_NEAR(e.result.contacts[k].force / state.contacts[k].force, 1.0, 1e-6);
      EXPECT_NEAR(e.result.contacts[k].tangential, state.contacts[k].tangential, 1e-6 * state.contacts[k].force);
    }
    EXPECT_GT(state.stability, tolerance::stability);
  }
}

// Of more contacts than have every corner followed: if effects add up the interval is exact, and what was not looked at
// is told.
TEST(FrictionRange, OfManyContactsIsThatOfTheCornersToWhichEachPoints) {
  const std::vector<double> on_x{0.3, -0.2, 0.5, 0.0, -0.7, 0.1, 0.4, -0.6};
  const std::vector<double> on_y{-0.1, 0.2, 0.3, -0.4, 0.5, 0.6, -0.7, 0.8};
  int asked = 0;
  const auto state = [&](const Eigen::VectorXd& ratios) -> std::optional<SeenState> {
    ++asked;
    FrictionRange r;
    for (Eigen::Index i = 0; i < ratios.size(); ++i) {
      r.tip_x += on_x[static_cast<std::size_t>(i)] * ratios[i];
      r.tip_y += on_y[static_cast<std::size_t>(i)] * ratios[i];
    }
    return SeenState{r};
  };
  const Eigen::VectorXd limits = Eigen::VectorXd::LinSpaced(8, 0.2, 0.9);
  const FrictionStates found = follow_states(limits, state, true);
  EXPECT_EQ(found.lost.size(), 0);
  EXPECT_LT(asked, 80);
  EXPECT_TRUE(contains_text(found.note, "others of the corners may lie farther")) << found.note;
  double x = 0.0;
  double y = 0.0;
  for (std::size_t i = 0; i < 8; ++i) {
    x += std::abs(on_x[i]) * limits[static_cast<Eigen::Index>(i)];
    y += std::abs(on_y[i]) * limits[static_cast<Eigen::Index>(i)];
  }
  const auto span = [&](auto member) {
    const auto [low, high] =
        std::minmax_element(found.states.begin(), found.states.end(),
                            [&](const auto& a, const auto& b) { return a.range.*member < b.range.*member; });
    return std::pair{low->range.*member, high->range.*member};
  };
  EXPECT_NEAR(span(&FrictionRange::tip_x).first, -x, 1e-12);
  EXPECT_NEAR(span(&FrictionRange::tip_x).second, x, 1e-12);
  EXPECT_NEAR(span(&FrictionRange::tip_y).first, -y, 1e-12);
  EXPECT_NEAR(span(&FrictionRange::tip_y).second, y, 1e-12);
  // As many as have all corners.
  EXPECT_EQ(follow_states(limits.head(5), state, true).states.size(), 33U);
  EXPECT_TRUE(follow_states(limits.head(5), state, true).note.empty());
  // What is not reached is named.
  const auto short_of = [&](const Eigen::VectorXd& ratios) { return ratios[2] > 0.3 ? std::nullopt : state(ratios); };
  const FrictionStates lost = follow_states(limits, short_of, true);
  ASSERT_EQ(lost.lost.size(), 8);
  EXPECT_NEAR(lost.lost[2], limits[2], 1e-15);
}

/// Bodies on which tangential forces have a couple, and a contact at the tip.
Scene variant(const std::string& name) {
  if (name == "thick") return scene("brace", {"rod.thickness=\"6 mm\""});
  if (name == "tapered") return scene("brace", {"rod.thickness=[\"8 mm\", \"4 mm\"]"});
  if (name == "stretched") {
    return scene("brace", {"rod.thickness=\"6 mm\"", "rod.axial_stiffness=\"4 N\"", "coordinates.stretch_order=6"});
  }
  return combination::scene_from_text(R"(
problem = "pose"
gravity = ["0 m/s^2", "-9.81 m/s^2"]
[rod]
length = "100 mm"
bending_stiffness = "4.9e-4 N m^2"
linear_density = "84 g/m"
[[rod.actuator]]
limit = "5 N mm"
[[obstacle]]
name = "floor"
shape = "wall"
point = ["0 mm", "-20 mm"]
normal = [0.0, 1.0]
[contact]
mode = "require"
min_force = "5 mN"
[target]
position = ["96 mm", "-18 mm"]
[[objective]]
plugin = "tip_pose"
weight = 100
[[objective]]
plugin = "actuation_effort"
weight = 1e-3
)");
}

class FrictionOf : public testing::TestWithParam<const char*> {};

TEST_P(FrictionOf, ABodyOrATipIsPlannedAsItIsExecuted) {
  const Scene made = variant(GetParam());
  Plan worst = combination::plan(with_state(made, 0.4, FrictionState::worst));
  ASSERT_TRUE(combination::certified(worst));
  ASSERT_EQ(worst.contacts.size(), 1U);
  EXPECT_EQ(worst.contacts[0].at_tip, std::string(GetParam()) == "tip");
  EXPECT_NEAR(worst_cost(with_state(made, 0.4, FrictionState::worst), worst, worst.moments, 2) / worst.objective, 1.0,
              1e-7);
  for (const double share : {0.99, 1.01}) {
    if (std::abs(share * worst.moments[0]) > made.rod.actuators[0].maximum) continue;
    EXPECT_GT(worst_cost(with_state(made, 0.4, FrictionState::worst), worst, {share * worst.moments[0]}, 1),
              worst.objective);
  }
  const Plan any = combination::plan(with_state(made, 0.4, FrictionState::any));
  ASSERT_TRUE(combination::certified(any));
  const double ratio = any.contacts[0].tangential / any.contacts[0].force;
  EXPECT_NEAR(executed_cost(made, any, any.moments, {ratio}) / any.objective, 1.0, 1e-7);
  const Plan range = combination::plan(with_state(made, 0.4, FrictionState::range));
  ASSERT_TRUE(combination::certified(range));
  EXPECT_LE(any.objective, range.objective + 1e-12);
  EXPECT_GE(worst.objective, range.objective - 1e-12);
}

INSTANTIATE_TEST_SUITE_P(Rods, FrictionOf, testing::Values("thick", "tapered", "stretched", "tip"),
                         [](const auto& each) { return std::string(each.param); });

TEST(FrictionRange, AStateBeyondALimitIsTold) {
  Scene made = with_state(scene("brace"), 0.3, FrictionState::range);
  const Plan free = combination::plan(made);
  made.contact.max_force = free.contacts[0].force;
  const auto told = [](const Plan& plan) {
    return std::any_of(plan.notes.begin(), plan.notes.end(),
                       [](const std::string& note) { return contains_text(note, "more than its limit"); });
  };
  EXPECT_FALSE(told(free));
  const Plan limited = combination::plan(made);
  ASSERT_TRUE(combination::certified(limited));
  EXPECT_TRUE(told(limited));
  // Planned for the worst, no state is beyond it.
  const Plan worst = combination::plan(with_state(made, 0.3, FrictionState::worst));
  ASSERT_TRUE(combination::certified(worst));
  EXPECT_FALSE(told(worst));
  for (const FrictionRange& state : worst.friction) {
    EXPECT_LE(state.contacts[0].force, made.contact.max_force * (1.0 + 1e-9));
  }
}

// From the smallest coefficient on the plans begin at the one without friction, and drift apart as it grows.
TEST(FrictionExtremes, PlansAreCertifiedOrSayWhy) {
  const double without = combination::plan(scene("brace")).objective;
  double worst_before = without;
  double any_before = without;
  for (const double mu : {1e-6, 1e-3, 0.1, 1.0, 10.0}) {
    const Plan worst = combination::plan(with_state(scene("brace"), mu, FrictionState::worst));
    const Plan any = combination::plan(with_state(scene("brace"), mu, FrictionState::any));
    ASSERT_TRUE(combination::certified(any)) << mu;
    EXPECT_LE(any.objective, any_before + 1e-12) << mu;
    any_before = any.objective;
    ASSERT_TRUE(combination::certified(worst)) << mu;
    EXPECT_GE(worst.objective, worst_before - 1e-12) << mu;
    // Glue would carry the arm off its peg: the worst is least where nothing is touched.
    EXPECT_EQ(worst.friction.empty(), mu == 10.0);
    if (mu < 10.0) {
      EXPECT_LT(worst.objective - without, 2e-4 * mu) << mu;
    }
    worst_before = worst.objective;
  }
}

TEST(FrictionOfTrajectories, EveryStepHasItsStates) {
  for (const FrictionState state : {FrictionState::range, FrictionState::any, FrictionState::worst}) {
    Scene made = with_state(scene("trajectory"), 0.3, state);
    std::vector<TargetSpec>& targets = made.trajectory.targets;
    targets = {targets[20], targets[21], targets[22]};
    Problem problem = combination::problem(made);
    const Trajectory path = plan_trajectory(targets, {}, [&](const TargetSpec& target, const Plan* start, bool follow) {
      problem.set_target(target);
      PlanControl control;
      control.start = start;
      control.follow = follow;
      return problem.plan(control);
    });
    ASSERT_EQ(path.steps.size(), 3U);
    for (const TrajectoryStep& step : path.steps) {
      ASSERT_TRUE(combination::certified(step.plan)) << to_string(step.method);
      EXPECT_EQ(step.plan.friction.size(), 3U);
      // Each step is what it is on its own.
      Scene alone = made;
      alone.problem = ProblemKind::pose;
      alone.target = step.target;
      alone.trajectory = {};
      EXPECT_NEAR(step.plan.objective, combination::plan(alone).objective, 1e-9);
    }
  }
}

// Each state is found from what it was in the step before: it is the one that is followed to from the plan alone.
TEST(FrictionOfTrajectories, StatesOfAFollowedStepAreThoseOfItsPlan) {
  for (const char* name : {"brace", "two_pegs"}) {
    for (const FrictionState state : {FrictionState::range, FrictionState::any}) {
      SCOPED_TRACE(std::string(name) + (state == FrictionState::any ? ", any" : ", range"));
      const Scene made = with_state(scene(name), 0.3, state);
      Problem problem = combination::problem(made);
      Plan plan = problem.plan();
      ASSERT_TRUE(combination::certified(plan));
      TargetSpec target = made.target;
      for (int step = 1; step <= 6; ++step) {
        // To, and back another way.
        target.position = *made.target.position + Vec2{step <= 3 ? -2e-5 * step : 1e-5 * (step - 6), 1e-5 * step};
        ASSERT_TRUE(problem.step(target, plan, nullptr)) << step;
        ASSERT_TRUE(combination::certified(plan));
        Problem other = combination::problem(made);
        Plan alone = plan;
        ASSERT_TRUE(other.step(target, alone, nullptr)) << step;
        ASSERT_EQ(plan.friction.size(), std::size_t{1} << plan.contacts.size() | 1U);
        ASSERT_EQ(plan.friction.size(), alone.friction.size());
        for (std::size_t i = 0; i < plan.friction.size(); ++i) {
          const FrictionRange& one = plan.friction[i];
          const FrictionRange& same = alone.friction[i];
          EXPECT_EQ(one.ratios, same.ratios);
          EXPECT_NEAR(one.tip_x, same.tip_x, 1e-12);
          EXPECT_NEAR(one.tip_y, same.tip_y, 1e-12);
          EXPECT_NEAR(one.tip_angle, same.tip_angle, 1e-10);
          EXPECT_NEAR(*one.target_error, *same.target_error, 1e-12);
          EXPECT_NEAR(one.stability, same.stability, 1e-9);
          ASSERT_EQ(one.contacts.size(), same.contacts.size());
          for (std::size_t k = 0; k < one.contacts.size(); ++k) {
            EXPECT_NEAR(one.contacts[k].force / same.contacts[k].force, 1.0, 1e-9);
            EXPECT_EQ(one.contacts[k].sticks, same.contacts[k].sticks);
          }
        }
      }
    }
  }
}

// Where the states at the ends of a way lie straight, none is asked for half-way to them; where it bends, one is.
TEST(FrictionRange, StatesHalfWayAreAskedForWhereTheWayBends) {
  for (const double bend : {0.0, 0.04, 0.06, 1.0}) {
    int halves = 0;
    const auto state = [&](const Eigen::VectorXd& ratios) -> std::optional<SeenState> {
      const double w = ratios[0];
      if (std::abs(w) == 0.5) ++halves;
      SeenState seen;
      seen.point = Eigen::Vector2d(w, bend * w * w);
      return std::abs(w) == 0.5 && bend == 1.0 ? std::nullopt : std::optional(seen);
    };
    const FrictionStates found = follow_states(Eigen::VectorXd::Constant(1, 1.0), state, true);
    EXPECT_EQ(halves, bend < 0.05 ? 0 : bend < 1.0 ? 2 : 1) << bend;
    EXPECT_EQ(found.lost.size(), bend == 1.0 ? 1 : 0) << bend;
  }
}

TEST(FrictionCertificate, SaysWhatIsOffItsCone) {
  const Scene made = with_state(scene("brace"), 0.3, FrictionState::any);
  Plan plan = combination::plan(made);
  ASSERT_TRUE(combination::certified(plan));
  const double unit = scale_of(made).force();
  Plan changed = plan;
  changed.contacts[0].tangential = 0.31 * changed.contacts[0].force;
  changed.contacts[0].sticks = true;
  judge_cones(made, unit, changed);
  EXPECT_EQ(changed.status, PlanStatus::not_converged);
  EXPECT_TRUE(contains_text(changed.message, "off its cone"));
  // Within its cone a contact sticks, or was given its ratio, but does not slip.
  changed = plan;
  changed.contacts[0].tangential = 0.29 * changed.contacts[0].force;
  changed.contacts[0].sticks = false;
  judge_cones(made, unit, changed);
  EXPECT_EQ(changed.status, PlanStatus::not_converged);
  changed = plan;
  changed.contacts[0].tangential = 0.29 * changed.contacts[0].force;
  changed.contacts[0].sticks = true;
  judge_cones(made, unit, changed);
  EXPECT_EQ(changed.status, PlanStatus::solved);
  EXPECT_EQ(changed.certificate.friction, 0.0);
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
  for (const FrictionState state : {FrictionState::any, FrictionState::worst}) {
    EXPECT_TRUE(contains_text(refusal([state](Scene& s) { s.contact.friction_state = state; }), "without friction"));
    EXPECT_TRUE(contains_text(refusal([state](Scene& s) {
                                s = with_state(s, 0.3, state);
                                s.coordinates.split_at_contact = false;
                              }),
                              "has a knot at its contact"));
  }
  EXPECT_TRUE(contains_text(refusal([](Scene& s) {
                              s.contact.friction = 0.3;
                              s.contact.mode = ContactModeName::avoid;
                            }),
                            "no friction where contact is not planned"));
}

}  // namespace
}  // namespace tendril::search
