// The braced arm against its boundary-value problem, solved at the moment that the plan found.

#include <cmath>
#include <cstdint>
#include <iostream>

#include "support.hpp"
#include "support/rod_bvp.hpp"

namespace tendril::combination {
namespace {

struct Comparison {
  Plan plan;
  double tip = infinity;         ///< distance of the tips, in L
  double arc_length = infinity;  ///< in L
  double force = infinity;       ///< relative
};

Comparison compare(const std::string& plugin, const RawOptions& options, bool split) {
  Comparison c;
  Scene brace = scene("brace");
  brace.coordinates = {plugin, split, 0, options, {}};
  c.plan = plan(brace);
  EXPECT_TRUE(certified(c.plan));
  if (c.plan.contacts.size() != 1) {
    ADD_FAILURE() << "the plan does not brace on the peg";
    return c;
  }
  // Numbers of scenes/brace.toml, in units of L and EI.
  const double length = 0.1;
  const double stiffness = 4.9e-4;
  support::RodBvp rod;
  rod.sections[0].density = 0.084 * 9.81 * length * length * length / stiffness;
  rod.gravity = {0.0, -1.0};
  const support::BvpContact peg{{0.6, 0.0}, 0.08};
  const PlannedContact& contact = c.plan.contacts[0];
  support::BvpGuess guess;
  guess.curvature = 0.4;
  guess.arc_lengths = {contact.arc_length / length};
  guess.forces = {contact.force * length * length / stiffness};
  const support::BvpSolution exact = solve(rod, {c.plan.moments[0] * length / stiffness}, {peg}, guess);
  c.tip = std::hypot(c.plan.tip_x / length - exact.tip_x, c.plan.tip_y / length - exact.tip_y);
  c.arc_length = std::abs(contact.arc_length / length - exact.arc_lengths[0]);
  c.force = std::abs(contact.force * length * length / stiffness / exact.forces[0] - 1.0);
  std::cout << plugin << (split ? ", split" : ", not split") << ": moment " << c.plan.moments[0] * 1e3
            << " N mm; error of tip " << c.tip << " L, place " << c.arc_length << " L, force " << c.force
            << " relative\n";
  return c;
}

TEST(BraceAgainstTheExactSolution, SixFunctionsOnEachSideOfTheContact) {
  const Comparison c = compare("legendre", {{"order", {std::int64_t{6}}}}, true);
  // What README.md and docs/execution.md say.
  EXPECT_LT(c.tip, 1e-12);
  EXPECT_LT(c.arc_length, 1e-12);
  EXPECT_LT(c.force, 1e-11);
}

TEST(BraceAgainstTheExactSolution, TwelveFunctionsThroughTheKink) {
  const Comparison c = compare("legendre", {{"order", {std::int64_t{12}}}}, false);
  // The kink of the curvature at the contact limits a smooth basis.
  EXPECT_NEAR(c.tip, 2.3e-5, 0.05e-5);
}

TEST(TwoPegsAgainstTheExactSolution, BothHoldTheArm) {
  const Plan found = plan(scene("two_pegs"));
  ASSERT_TRUE(certified(found));
  ASSERT_EQ(found.contacts.size(), 2u);
  const double length = 0.1;
  const double stiffness = 4.9e-4;
  const double force_unit = stiffness / (length * length);
  support::RodBvp rod;
  rod.sections[0].density = 0.084 * 9.81 * length * length * length / stiffness;
  rod.gravity = {0.0, -1.0};
  support::BvpGuess guess;
  guess.angle = [&](double s) {
    for (const BackbonePoint& p : found.backbone) {
      if (p.s >= s * length) return p.angle;
    }
    return found.tip_angle;
  };
  for (const PlannedContact& c : found.contacts) {
    EXPECT_GT(c.force, 0.01 * force_unit);
    guess.arc_lengths.push_back(c.arc_length / length);
    guess.forces.push_back(c.force / force_unit);
  }
  const support::BvpSolution exact =
      solve(rod, {found.moments[0] * length / stiffness}, {{{0.6, 0.0}, 0.08}, {{0.8, 0.26}, 0.08}}, guess);
  // As for one peg: six functions on each smooth stretch.
  EXPECT_LT(std::hypot(found.tip_x / length - exact.tip_x, found.tip_y / length - exact.tip_y), 1e-8);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_NEAR(found.contacts[i].arc_length / length, exact.arc_lengths[i], 1e-7);
    EXPECT_NEAR(found.contacts[i].force / force_unit, exact.forces[i], 1e-7 * exact.forces[i]);
  }
}

// The paper's models, for scale: what they leave of the truth on this arm.
TEST(BraceAgainstTheExactSolution, TheModelsOfThePaper) {
  // Twice to four times what they leave here: a fact about the models, which a worse plan would not keep.
  EXPECT_LT(compare("psc", {}, true).tip, 2e-7);
  EXPECT_LT(compare("psc", {}, false).tip, 4e-3);
  EXPECT_LT(compare("pcc", {{"pieces", {std::int64_t{3}}}}, true).tip, 3e-3);
  EXPECT_LT(compare("pcc", {{"pieces", {std::int64_t{12}}}}, true).tip, 2e-4);
  EXPECT_LT(compare("pcc", {{"pieces", {std::int64_t{12}}}}, false).tip, 6e-4);
}

}  // namespace
}  // namespace tendril::combination
