// Rods with everything that a scene can ask for, against the exact boundary-value method.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "execute_support.hpp"
#include "support/print.hpp"
#include "support/rod_bvp.hpp"

namespace tendril::support {
namespace {

/// The same rod twice, in SI numbers far from 1: 0.1 m and 1e-3 N m^2.
struct Twins {
  ForwardScene scene;
  RodBvp rod;
  std::vector<double> moments;
};

constexpr double length = 0.1;
constexpr double stiffness = 1e-3;

Twins random_rod(unsigned seed) {
  std::mt19937 random(seed);
  const auto within = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  Twins t;
  Scene& scene = t.scene.scene;
  scene.rod.segments.clear();
  t.rod.sections.clear();
  for (const double share : {0.45, 0.55}) {
    const double bending = stiffness * within(0.4, 2.0);
    const double density = within(0.0, 3.0) * stiffness / (length * length * length * 9.81);
    const double rest = within(-1.5, 1.5) / length;
    scene.rod.segments.push_back({share * length, bending, density, rest});
    t.rod.sections.push_back({share * length, bending, density, rest});
  }
  scene.rod.actuators.assign(2, scene.rod.actuators[0]);
  scene.rod.actuators[0].to = 0.6 * length;
  scene.rod.actuators[1].from = 0.3 * length;
  scene.rod.actuators[1].to = length;
  t.rod.actuators = {{0.0, 0.6 * length}, {0.3 * length, length}};
  scene.rod.base_position = {within(-0.2, 0.2), within(-0.2, 0.2)};
  scene.rod.base_angle = within(-3.0, 3.0);
  t.rod.base = {scene.rod.base_position.x, scene.rod.base_position.y};
  t.rod.base_angle = scene.rod.base_angle;
  scene.gravity = Vec2{within(-9.81, 9.81), within(-9.81, 9.81)};
  t.rod.gravity = {scene.gravity->x, scene.gravity->y};
  const double force = stiffness / (length * length);
  scene.tip_load.force = Vec2{within(-1.0, 1.0) * force, within(-1.0, 1.0) * force};
  t.rod.tip_force = {scene.tip_load.force.x, scene.tip_load.force.y};
  scene.tip_load.mass = within(0.0, 0.5) * force / 9.81;
  t.rod.payload = scene.tip_load.mass;
  scene.start_tip_angle = within(-1.0, 1.0);
  t.moments = {within(-2.0, 2.0) * stiffness / length, within(-2.0, 2.0) * stiffness / length};
  return t;
}

struct PegBeside {
  double x, y, radius;
};

/// A peg that the rod without it runs through, a little deep at three quarters of its length.
PegBeside peg_beside(const Plan& free) {
  const BackbonePoint& at = free.backbone[free.backbone.size() * 3 / 4];
  const double radius = 0.06 * length;
  const double aside = 0.8 * radius;
  return {at.x - aside * std::sin(at.angle), at.y + aside * std::cos(at.angle), radius};
}

class ExecuteRod : public testing::TestWithParam<unsigned> {};

TEST_P(ExecuteRod, EndsInAnExactEquilibrium) {
  const Twins t = random_rod(GetParam());
  const Execution e = t.scene.run(t.moments);
  ASSERT_EQ(e.result.status, PlanStatus::solved) << e.result.message;
  BvpGuess guess;
  guess.angle = angle_of(e.result);
  const BvpSolution exact = solve(t.rod, t.moments, {}, guess);
  EXPECT_NEAR(e.result.tip_x, exact.tip_x, 1e-8 * length);
  EXPECT_NEAR(e.result.tip_y, exact.tip_y, 1e-8 * length);
  EXPECT_NEAR(e.result.tip_angle, exact.tip_angle, 1e-8);
}

TEST_P(ExecuteRod, EndsInAnExactEquilibriumOnAPeg) {
  Twins t = random_rod(GetParam());
  const Execution free = t.scene.run(t.moments);
  ASSERT_EQ(free.result.status, PlanStatus::solved) << free.result.message;
  const PegBeside peg = peg_beside(free.result);
  t.scene.circle(peg.x / length, peg.y / length, peg.radius / length);
  const Execution e = t.scene.run(t.moments);
  ASSERT_EQ(e.result.status, PlanStatus::solved) << e.result.message;
  // The rod without the peg is no answer any more; it may have come to rest on another branch, clear of it.
  if (e.snaps.empty()) {
    ASSERT_EQ(e.result.contacts.size(), 1U);
  }
  std::vector<BvpContact> contacts;
  BvpGuess guess;
  guess.angle = angle_of(e.result);
  for (const PlannedContact& c : e.result.contacts) {
    contacts.push_back({{peg.x, peg.y}, peg.radius, c.at_tip, {}});
    guess.arc_lengths.push_back(c.arc_length);
    guess.forces.push_back(c.force);
  }
  const BvpSolution exact = solve(t.rod, t.moments, contacts, guess);
  EXPECT_NEAR(e.result.tip_x, exact.tip_x, 1e-8 * length);
  EXPECT_NEAR(e.result.tip_y, exact.tip_y, 1e-8 * length);
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    EXPECT_NEAR(e.result.contacts[k].force / exact.forces[k], 1.0, 1e-6);
  }
  EXPECT_LE(e.result.certificate.moment_balance, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Random, ExecuteRod, testing::Range(1U, 13U));

}  // namespace
}  // namespace tendril::support
