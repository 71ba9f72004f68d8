// Plans that ask for a tip whose place is known well, against Monte Carlo: their moments carried out in many scenes.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "planned.hpp"
#include "support/repetitions.hpp"
#include "tendril/app/input_error.hpp"

namespace tendril::app::test {
namespace {

/// More moments than the target asks for, and a peg that it could be reached beside.
const std::string loaded_arm = R"(
problem = "pose"
gravity = ["0 m/s^2", "-9.81 m/s^2"]
[rod]
length = "100 mm"
bending_stiffness = "4.9e-4 N m^2 +- 4 %"
linear_density = "84 g/m"
[[rod.actuator]]
limit = "20 N mm"
[[rod.actuator]]
from = "40 mm"
limit = "20 N mm"
[[rod.actuator]]
from = "70 mm"
limit = "20 N mm"
[coordinates]
plugin = "legendre"
[start]
tip_angle = "0.5 rad"
[tip_load]
mass = "1 g +- 0.2 g"
[target]
position = ["85 mm", "25 mm"]
[[objective]]
plugin = "tip_pose"
weight = 100
[[objective]]
plugin = "actuation_effort"
weight = 1e-4
[[objective]]
plugin = "tip_variance"
weight = 0
)";

const std::string peg = R"(
[[obstacle]]
shape = "circle"
center = ["50 mm", "-2 mm"]
radius = "8 mm +- 0.1 mm"
[contact]
max_force = "1 N"
)";

Settings weighted(const std::string& solver, const std::string& weight) {
  return {{"solver.plugin", solver}, {"objective[2].weight", weight}};
}

/// Mean square of the distance of tips from where they are without what is not known (m^2), over draws of it.
double drawn_variance(const Plan& plan, const std::string& scene) {
  Session session(arguments_of(scene, {}));
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  const int draws = repetitions(200);
  double sum = 0.0;
  for (int i = 0; i < draws; ++i) {
    Scene drawn = session.scene();
    drawn.rod.segments[0].bending_stiffness *= 1.0 + 0.04 * normal(random);
    drawn.tip_load.mass += 2e-4 * normal(random);
    if (!drawn.obstacles.empty()) drawn.obstacles[0].options["radius"] = RawValue{8e-3 + 1e-4 * normal(random)};
    Session other(arguments_of(scene, {}));
    other.use(drawn);
    const Plan reached = other.execute(plan.moments, plan).result;
    EXPECT_EQ(reached.status, PlanStatus::solved) << reached.message;
    sum += std::pow(reached.tip_x - plan.tip_x, 2) + std::pow(reached.tip_y - plan.tip_y, 2);
  }
  return sum / draws;
}

struct Planned {
  Plan plan;
  double variance = 0.0;  ///< of the tip's place, m^2, by the error bars
};

Planned planned(const std::string& scene, const Settings& settings) {
  Session session(arguments_of(scene, settings));
  Planned out{session.plan(std::nullopt)};
  EXPECT_EQ(out.plan.status, PlanStatus::solved) << out.plan.message;
  const Uncertainty bars = session.run_info().uncertainties.at(0);
  EXPECT_EQ(bars.trouble, "");
  out.variance = std::pow(bars.deviations.at(0).value, 2) + std::pow(bars.deviations.at(1).value, 2);
  return out;
}

class Robust : public testing::TestWithParam<const char*> {};

TEST_P(Robust, PlansSpreadLess) {
  // By another shape the arm gains a little, by the peg much.
  for (const auto& [scene, left] : {std::pair(loaded_arm, 0.9), std::pair(loaded_arm + peg, 0.4)}) {
    const Planned plain = planned(scene, weighted(GetParam(), "0"));
    const Planned robust = planned(scene, weighted(GetParam(), "1000"));
    EXPECT_LT(robust.variance, left * plain.variance);
    EXPECT_LT(drawn_variance(robust.plan, scene), left * drawn_variance(plain.plan, scene));
    RecordProperty("predicted", std::to_string(std::sqrt(robust.variance / plain.variance)));
  }
}

// What the term says is what the error bars say, which are made another way.
TEST_P(Robust, PlansReadTheErrorBars) {
  const std::string together =
      "[[correlation]]\nbetween = [\"rod.bending_stiffness\", \"tip_load.mass\"]\nvalue = -0.7\n";
  const std::string pressure = "rod.actuator[0].moment_per_pressure";
  for (const std::string& more : {std::string(), peg, together}) {
    const std::string scene = loaded_arm + more;
    Settings settings = weighted(GetParam(), "30");
    if (!more.empty()) settings.emplace_back(pressure, "1e-7 N m/Pa +- 3 %");
    const Planned there = planned(scene, settings);
    ASSERT_EQ(there.plan.terms.at(2).first, "tip_variance");
    EXPECT_NEAR(there.plan.terms[2].second, 30.0 * there.variance / 0.01, 1e-6 * there.plan.terms[2].second);
  }
}

// Three moments leave the optimum flat, where full steps by second derivatives that are learned lead away from it.
TEST_P(Robust, FlatOptimaAreReached) {
  for (const auto& [weight, least] : {std::pair("100", 0.0277781), std::pair("300", 0.0797831)}) {
    const Planned there = planned(loaded_arm, weighted(GetParam(), weight));
    EXPECT_NEAR(there.plan.objective, least, 1e-5 * least) << "weight " << weight;
  }
}

INSTANTIATE_TEST_SUITE_P(Solvers, Robust, testing::Values("nlopt", "ipopt", "ceres"),
                         [](const auto& solver) { return std::string(solver.param); });

TEST(RobustPlans, WithoutErrorBarsAreRefused) {
  const auto refusal = [](const Settings& settings) {
    try {
      Settings all = weighted(TENDRIL_TEST_SOLVER, "1");
      all.insert(all.end(), settings.begin(), settings.end());
      Session session(arguments_of(loaded_arm, all));
      session.problem();
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(refusal({}), "");
  EXPECT_NE(refusal({{"rod.bending_stiffness", "4.9e-4 N m^2"}, {"tip_load.mass", "1 g"}})
                .find("needs a number with an error bar"),
            std::string::npos);
  EXPECT_NE(refusal({{"rod.actuator[1].from", "40 mm +- 1 mm"}})
                .find("by 'rod.actuator[1].from' nothing is differentiated: pieces of the rod begin or end there"),
            std::string::npos);
  EXPECT_NE(refusal({{"coordinates.stretch_order", "2"}, {"rod.axial_stiffness", "50 N"}})
                .find("rods that stretch are not differentiated"),
            std::string::npos);
}

}  // namespace
}  // namespace tendril::app::test
