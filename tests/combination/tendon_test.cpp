// Arms that tendons or pressures bend: the same plans as those of the moments that these make, and plans that execution
// bears out where these moments vary along the rod.

#include <cmath>
#include <utility>

#include "support.hpp"
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
