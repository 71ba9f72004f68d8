// Arms that tendons or pressures bend: the same plans as those of the moments that these make, and plans that execution
// bears out where these moments vary along the rod, told tensions or lengths.

#include <algorithm>
#include <cmath>
#include <utility>

#include "support.hpp"
#include "tendril/error.hpp"
#include "tendril/execute.hpp"

namespace tendril::combination {
namespace {

ActuatorSpec one_sided(double least, double most, double length) {
  ActuatorSpec actuator;
  actuator.to = length;
  actuator.minimum = least;
  actuator.maximum = most;
  return actuator;
}

TEST(Tendons, APairIsTheMomentsThatItMakes) {
  Scene moments = scene("brace");
  const double length = moments.rod.length();
  const double most = moments.rod.actuators[0].maximum;
  moments.rod.actuators = {one_sided(0.0, most, length), one_sided(-most, 0.0, length)};
  Scene tendons = moments;
  for (std::size_t a = 0; a < 2; ++a) {
    ActuatorSpec& tendon = tendons.rod.actuators[a];
    const double offset = a == 0 ? 8e-3 : -8e-3;
    tendon.kind = ActuatorKind::tendon;
    tendon.offset = {{0.0, offset}, {0.6 * length, offset}, {length, offset}};
  }
  const Plan of_moments = plan(moments);
  const Plan of_tendons = plan(tendons);
  ASSERT_TRUE(certified(of_moments));
  ASSERT_TRUE(certified(of_tendons));
  EXPECT_NEAR(of_tendons.objective, of_moments.objective, 1e-10 * of_moments.objective);
  EXPECT_NEAR(of_tendons.tip_x, of_moments.tip_x, 1e-10 * length);
  EXPECT_NEAR(of_tendons.tip_y, of_moments.tip_y, 1e-10 * length);
  for (std::size_t a = 0; a < 2; ++a) {
    EXPECT_NEAR(of_tendons.moments[a], of_moments.moments[a], 1e-10 * most) << a;
    // Along a constant offset the shortening is the angle of the tip times the offset.
    EXPECT_NEAR(of_tendons.turns[a], of_tendons.tip_angle, 1e-10) << a;
  }
}

/// The arm of four tendons told their lengths, with the limits of their tensions.
Scene arm_by_length(const std::string& solver) {
  Scene arm = scene("tendon_arm", {"solver.plugin=" + solver, "coordinates.order=12"});
  for (ActuatorSpec& a : arm.rod.actuators) a.by_length = true;
  return arm;
}

TEST(Tendons, PlansOfLengthsAreThoseOfTheTensionsThatFollow) {
  for (const std::string& solver : solvers_to_combine()) {
    SCOPED_TRACE(solver);
    const Plan by_tension = plan(scene("tendon_arm", {"solver.plugin=" + solver, "coordinates.order=12"}));
    const Scene arm = arm_by_length(solver);
    Plan by_length = plan(arm);
    ASSERT_TRUE(certified(by_tension));
    ASSERT_TRUE(certified(by_length));
    const double length = arm.rod.length();
    EXPECT_NEAR(by_length.objective, by_tension.objective, 1e-6 * by_tension.objective);
    EXPECT_NEAR(by_length.tip_x, by_tension.tip_x, 1e-6 * length);
    EXPECT_NEAR(by_length.tip_y, by_tension.tip_y, 1e-6 * length);
    EXPECT_GT(by_length.certificate.held_lengths, 0);
    EXPECT_GE(by_length.certificate.stability, by_tension.certificate.stability - 1e-6);
    const Components parts = plugins::make_components(registry(), arm);
    ExecuteControl control;
    control.start = &by_length;
    const Execution reached = verify(arm, parts.obstacles, by_length, control);
    EXPECT_EQ(reached.result.status, PlanStatus::solved) << reached.result.message;
    EXPECT_LT(by_length.model_error.value_or(infinity), 1e-8 * length);
  }
}

// What a spool can take up limits the plan: in every basis of contacts, by every solver.
TEST(Tendons, APlanKeepsTheLimitsOfLengths) {
  for (const std::string& solver : solvers_to_combine()) {
    SCOPED_TRACE(solver);
    const Plan free = plan(arm_by_length(solver));
    ASSERT_TRUE(certified(free));
    Scene arm = arm_by_length(solver);
    double most = 0.0;
    for (std::size_t a = 0; a < arm.rod.actuators.size(); ++a) {
      most = std::max(most, arm.rod.actuators[a].held(0.0, free.turns[a]));
    }
    const double limit = 0.8 * most;
    for (ActuatorSpec& a : arm.rod.actuators) a.most_shortening = limit;
    const Description described = problem(arm).describe();
    EXPECT_TRUE(std::any_of(described.rows.begin(), described.rows.end(),
                            [](const auto& row) { return row.name == "shortening" && row.count == 4; }));
    Plan limited = plan(arm);
    ASSERT_TRUE(certified(limited));
    EXPECT_GT(limited.objective, free.objective);
    double longest = 0.0;
    for (std::size_t a = 0; a < arm.rod.actuators.size(); ++a) {
      longest = std::max(longest, arm.rod.actuators[a].held(0.0, limited.turns[a]));
    }
    EXPECT_NEAR(longest, limit, 1e-9 * arm.rod.length());
    const Components parts = plugins::make_components(registry(), arm);
    ExecuteControl control;
    control.start = &limited;
    const Execution reached = verify(arm, parts.obstacles, limited, control);
    EXPECT_EQ(reached.result.status, PlanStatus::solved) << reached.result.message;
    EXPECT_LT(limited.model_error.value_or(infinity), 1e-8 * arm.rod.length());
  }
}

TEST(Tendons, ATermSeesTensions) {
  const auto tensions_of = [](const std::vector<std::string>& more) {
    std::vector<std::string> overrides{"solver.plugin=ipopt", "objective.1.plugin=tendon_tension",
                                       "objective.1.weight=0.01"};
    overrides.insert(overrides.end(), more.begin(), more.end());
    const Scene arm = scene("tendon_arm", overrides);
    const Plan found = plan(arm);
    EXPECT_TRUE(certified(found));
    std::vector<double> tensions;
    for (std::size_t a = 0; a < 4; ++a) tensions.push_back(arm.rod.actuators[a].input_of(found.moments[a]));
    return tensions;
  };
  const auto [least, most] = [&] {
    const std::vector<double> t = tensions_of({});
    return std::pair(*std::min_element(t.begin(), t.end()), *std::max_element(t.begin(), t.end()));
  }();
  EXPECT_NEAR(least, 0.0, 1e-6);
  EXPECT_GT(most, 0.1);
  for (const double t : tensions_of({"objective.1.wanted=1 N", "objective.1.weight=1e4"})) EXPECT_NEAR(t, 1.0, 0.2);
  // The same program without tendons has nothing to see.
  EXPECT_THROW(plan(scene("brace", {"objective.1.plugin=tendon_tension"})), SceneError);
}

TEST(Pressures, ALawOfPressurePlansTheMomentsThatItGives) {
  Scene pressures = scene("brace");
  ActuatorSpec& chamber = pressures.rod.actuators[0];
  chamber.kind = ActuatorKind::pressure;
  chamber.moment_per_pressure = 5e-8;
  chamber.more_moment_per_pressure = {5e-13};
  chamber.least_pressure = 0.0;
  chamber.most_pressure = 4e4;
  chamber.minimum = 0.0;
  chamber.maximum = chamber.moment_of(4e4);
  Scene moments = scene("brace");
  moments.rod.actuators = {one_sided(0.0, chamber.maximum, moments.rod.length())};
  const Plan of_pressures = plan(pressures);
  ASSERT_TRUE(certified(of_pressures));
  EXPECT_EQ(of_pressures.coordinates, plan(moments).coordinates);
  const double pressure = chamber.input_of(of_pressures.moments.at(0));
  EXPECT_NEAR(5e-8 * pressure + 5e-13 * pressure * pressure, of_pressures.moments.at(0), 1e-15);
}

TEST(Tendons, ALawOfTensionPlansTheMomentsThatItGives) {
  Scene tensions = scene("brace");
  ActuatorSpec& tendon = tensions.rod.actuators[0];
  tendon.kind = ActuatorKind::tendon;
  tendon.offset = {{0.0, 5e-3}};
  tendon.moment_per_pressure = 4e-3;
  tendon.more_moment_per_pressure = {2e-3};
  tendon.least_pressure = 0.0;
  tendon.most_pressure = 0.5;
  tendon.minimum = 0.0;
  tendon.maximum = tendon.moment_of(0.5);
  Scene moments = scene("brace");
  moments.rod.actuators = {one_sided(0.0, tendon.maximum, moments.rod.length())};
  const Plan of_tensions = plan(tensions);
  ASSERT_TRUE(certified(of_tensions));
  EXPECT_EQ(of_tensions.coordinates, plan(moments).coordinates);
  const double tension = tendon.input_of(of_tensions.moments.at(0));
  EXPECT_NEAR(4e-3 * tension + 2e-3 * tension * tension, of_tensions.moments.at(0), 1e-15);
  // It is shorter by what its offset says.
  EXPECT_NEAR(of_tensions.turns.at(0), of_tensions.tip_angle, 1e-10);
  const auto refused = [](const Scene& scene) {
    try {
      (void)plan(scene);
    } catch (const SceneError& error) {
      return std::string(error.path()) + ": " + error.what();
    }
    return std::string();
  };
  Scene pushed = tensions;
  pushed.rod.actuators[0].offset = {{0.0, -5e-3}};
  EXPECT_NE(refused(pushed).find("rod.actuator[0].moment_per_tension: the moment under tension turns the rod away"),
            std::string::npos);
  Scene back = tensions;
  back.rod.actuators[0].more_moment_per_pressure = {-8e-3};
  EXPECT_NE(refused(back).find("the moment turns back at a tension of 0.2525 N"), std::string::npos) << refused(back);
}

TEST(Tendons, PlansOfATaperedPairAreWhatExecutionFinds) {
  for (const std::string& solver : solvers_to_combine()) {
    SCOPED_TRACE(solver);
    const Scene arm = scene("tendon_arm", {"solver.plugin=" + solver, "coordinates.order=12"});
    Plan found = plan(arm);
    ASSERT_TRUE(certified(found));
    const Components parts = plugins::make_components(registry(), arm);
    // Solvers may pass the peg on either side: the plan's own shape is where it settles from.
    ExecuteControl control;
    control.start = &found;
    const Execution reached = verify(arm, parts.obstacles, found, control);
    EXPECT_EQ(reached.result.status, PlanStatus::solved) << reached.result.message;
    EXPECT_LT(found.model_error.value_or(infinity), 1e-8 * arm.rod.length());
    EXPECT_EQ(found.contacts.size(), 1u);
    for (std::size_t a = 0; a < found.moments.size(); ++a) {
      EXPECT_GE(arm.rod.actuators[a].input_of(found.moments[a]), -1e-9) << "tendon " << a << " pushes";
    }
  }
}

}  // namespace
}  // namespace tendril::combination
