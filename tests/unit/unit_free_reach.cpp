#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "nlp/polish.hpp"
#include "rod/chain.hpp"
#include "search/free_reach.hpp"

namespace tendril {
namespace {

double uniform(std::mt19937& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

/// Two segments of unlike stiffness under loads that leave the energy convex, bent by one actuator or two.
Rod random_rod(std::mt19937& random, int actuators) {
  Rod rod;
  const double joint = uniform(random, 0.3, 0.7);
  rod.segments = {{.to = joint, .weight = uniform(random, 0.0, 1.5), .rest_curvature = uniform(random, -0.5, 0.5)},
                  {.from = joint, .stiffness = uniform(random, 0.7, 1.5), .weight = uniform(random, 0.0, 1.5)}};
  const double direction = uniform(random, -3.0, 3.0);
  rod.gravity = {std::cos(direction), std::sin(direction)};
  rod.payload = uniform(random, 0.0, 0.1);
  rod.tip_force = {uniform(random, -0.2, 0.2), uniform(random, -0.2, 0.2)};
  rod.loads = {{.from = 0.2, .to = 0.8, .force = {uniform(random, -0.2, 0.2), 0.1}},
               {.from = 0.9, .to = 0.9, .force = {0.05, 0.0}, .weight = 0.05}};
  for (int a = 0; a < actuators; ++a) {
    const double limit = uniform(random, 0.2, 1.5);
    rod.actuators.push_back({a == 0 ? 0.0 : joint, a == 0 && actuators == 2 ? joint : 1.0, -0.3 * limit, limit});
  }
  return rod;
}

PoseProgramSpec free_program(const Rod& rod, const CoordinateModel& basis) {
  PoseProgramSpec spec;
  spec.rod = &rod;
  spec.model = &basis;
  spec.nodes = 2 * suggested_nodes(basis.function_count(), 3.0);
  return spec;
}

/// Where the tip is under some moments within the limits: equilibria found by the polish, with the moments fixed.
std::vector<Vec2> sampled_tips(const Rod& rod, const CoordinateModel& basis, std::mt19937& random, int count) {
  std::vector<Vec2> tips;
  for (int i = 0; i < count; ++i) {
    Rod held = rod;
    for (Rod::Actuator& a : held.actuators) {
      const double at = i == 0 ? a.minimum : i == 1 ? a.maximum : uniform(random, a.minimum, a.maximum);
      a.minimum = a.maximum = at;
    }
    PoseProgram program(free_program(held, basis));
    const PolishReport found = polish(program, Eigen::VectorXd::Zero(program.variable_count()), {});
    EXPECT_TRUE(found.converged);
    program.constraints(found.x);
    tips.push_back(program.backbone().tip());
  }
  return tips;
}

TEST(FreeReach, NoTipIsNearerThanItSaysAndWhatIsFarIsKnownToBe) {
  std::mt19937 random(5);
  const LegendreBasis basis(5);
  for (int trial = 0; trial < 12; ++trial) {
    SCOPED_TRACE(trial);
    const Rod rod = random_rod(random, 1 + trial % 2);
    const std::vector<Vec2> tips = sampled_tips(rod, basis, random, 40);
    FreeReach reach(free_program(rod, basis));
    for (int k = 0; k < 20; ++k) {
      const Vec2 point{uniform(random, -0.5, 1.1), uniform(random, -1.0, 1.0)};
      double nearest = infinity;
      for (const Vec2& tip : tips) nearest = std::min(nearest, norm(tip - point));
      for (const double wanted : {0.0, 0.5 * nearest, 2.0 * nearest}) {
        const double least = reach.least_distance(point, [=](double distance) { return distance > wanted; });
        EXPECT_LE(least, nearest);
        const bool plain = rod.actuators.size() == 1 && wanted < nearest && nearest > 0.3;
        if (plain) {
          EXPECT_GT(least, wanted);
        }
      }
    }
  }
}

TEST(FreeReach, IsNotKnownWhereLoadsMayBuckleTheRodOrNothingBoundsItsMoments) {
  std::mt19937 random(6);
  const LegendreBasis basis(5);
  const Vec2 far{-3.0, 0.0};
  const auto least = [&](const Rod& rod) {
    return FreeReach(free_program(rod, basis)).least_distance(far, [](double distance) { return distance > 2.0; });
  };
  const Rod rod = random_rod(random, 1);
  EXPECT_GT(least(rod), 1.5);
  Rod heavy = rod;
  heavy.payload = 4.0;
  Rod unlimited = rod;
  unlimited.actuators[0].maximum = infinity;
  Rod tapered = rod;
  tapered.segments[0].more_stiffness = {-0.2};
  for (const Rod& other : {heavy, unlimited, tapered}) EXPECT_EQ(least(other), 0.0);
}

}  // namespace
}  // namespace tendril
