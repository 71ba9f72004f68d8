// The margin of a contact that leans on the end of the rod.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "certificate/certifier.hpp"
#include "obstacle/circle.hpp"
#include "tendril/coordinate_model.hpp"
#include "tendril/tolerances.hpp"

namespace tendril::support {
namespace {

/// A contact that leans on the end of the rod slides to one side alone: disturbed to the other it is one at the tip,
/// and has to hold the rod as such.
TEST(CoreStabilityReference, AContactAtTheEndHoldsTheRodToBothSides) {
  Rod rod;
  rod.actuators.resize(1);
  const LegendreBasis basis(5);
  const Circle circle({0.9, 0.35}, 0.2);
  PoseProgramSpec spec;
  spec.rod = &rod;
  spec.model = &basis;
  spec.obstacles = {&circle};
  spec.nodes = 24;
  PoseProgramSpec at_tip = spec;
  spec.split = false;
  spec.contacts = {{0, false, 0}};
  at_tip.contacts = {{0, true, 0}};
  const PoseProgram inside(spec);
  const PoseProgram outside(at_tip);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> d(-0.5, 0.5);
  int differed = 0;
  for (int trial = 0; trial < 20; ++trial) {
    Eigen::VectorXd x = Eigen::VectorXd::Zero(inside.variable_count());
    Eigen::VectorXd y = Eigen::VectorXd::Zero(outside.variable_count());
    const int n = inside.layout().coordinates;
    for (int i = 0; i < n; ++i) x[i] = y[i] = d(random) / (1.0 + i);
    x[inside.moment_variable(0)] = y[outside.moment_variable(0)] = d(random);
    x[inside.force_variable(0)] = y[outside.force_variable(0)] = 30.0 + d(random);
    const auto margin = [&](double s) {
      x[inside.arc_length_variable(0)] = s;
      PoseProgram program(spec);
      Certifier certifier(spec);
      program.set_branch(0, Branch::touching);
      return certifier.certify(program, x);
    };
    PoseProgram tip(at_tip);
    tip.set_branch(0, Branch::touching);
    const double held = Certifier(at_tip).certify(tip, y).stability;
    const Certificate leaning = margin(1.0 - knot_clearance);
    const Certificate sliding = margin(1.0 - 10.0 * knot_clearance);
    if (!(sliding.contact_convexity > tolerance::convexity)) continue;
    EXPECT_NEAR(leaning.stability, std::min(held, sliding.stability), 1e-3 * (1.0 + std::abs(held)));
    if (sliding.stability > held + 1e-2 * (1.0 + std::abs(held))) ++differed;
  }
  EXPECT_GT(differed, 3);
}

}  // namespace
}  // namespace tendril::support
