// Several contacts at once: against the exact boundary-value method, which is told where the contacts are, and against
// rigid links with springs, which find the contacts themselves.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ostream>
#include <string>

#include "execute_support.hpp"
#include "support/link_chain.hpp"
#include "support/print.hpp"
#include "tendril/tolerances.hpp"

namespace tendril::support {
namespace {

struct Peg {
  double x, y, radius;
};

struct Case {
  const char* name;
  std::vector<Peg> pegs;
  std::vector<double> moments;  ///< two: of both halves
  double weight;
  double start_angle;
  std::vector<int> held;  ///< the pegs that hold the rod, in the order along it
  bool at_tip;            ///< the last of them holds its tip
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

const std::vector<Peg>& alternating() {
  static const std::vector<Peg> pegs{{0.3, -0.075, 0.08}, {0.55, 0.085, 0.08}, {0.82, -0.05, 0.08}};
  return pegs;
}

std::vector<Case> cases() {
  return {
      {"TwoPegsBelow", {{0.35, -0.08, 0.08}, {0.75, -0.07, 0.06}}, {0.5}, 10.0, 0.0, {0, 1}, false},
      {"TwoPegsOnEitherSide", alternating(), {2.0}, 1.682, 0.0, {0, 1}, false},
      {"ThreeAlternatingPegs", alternating(), {0.0}, 1.682, 0.0, {0, 1, 2}, false},
      {"ThreePegsAmongSix",
       {{0.54097989, 0.18081573, 0.06939770},
        {0.32525356, 0.02860060, 0.06143524},
        {0.69710160, -0.25025593, 0.03570214},
        {0.55697721, 0.13685971, 0.14958573},
        {0.64828161, 0.25915828, 0.06473887},
        {0.75450976, -0.22465850, 0.05902040}},
       {0.46894341, -4.66612100},
       0.0,
       0.0,
       {1, 3, 5},
       false},
      {"ThreeWithTheTip",
       {{0.27358799, -0.07003904, 0.09140631},
        {0.65795284, -0.13909092, 0.06215012},
        {0.48175323, 0.32271641, 0.03589010},
        {0.95812079, 0.26023630, 0.03209108},
        {0.44368475, 0.17426264, 0.12542644},
        {0.67690232, 0.03902251, 0.14962582}},
       {-1.01843777, 5.98507820},
       0.0,
       -1.0,
       {0, 1, 5},
       true},
  };
}

ForwardScene scene_of(const Case& c) {
  ForwardScene s;
  if (c.weight != 0.0) s.weight(c.weight);
  for (const Peg& p : c.pegs) s.circle(p.x, p.y, p.radius);
  if (c.moments.size() == 2) {
    s.scene.rod.actuators.push_back(s.scene.rod.actuators[0]);
    s.scene.rod.actuators[0].to = s.scene.rod.actuators[1].from = 0.5;
  }
  s.scene.start_tip_angle = c.start_angle;
  return s;
}

RodBvp rod_of(const Case& c) {
  RodBvp rod;
  rod.sections[0].density = c.weight;
  rod.gravity = {0.0, -1.0};
  if (c.moments.size() == 2) rod.actuators = {{0.0, 0.5}, {0.5, 1.0}};
  return rod;
}

class ExecuteMany : public testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    reached_ = scene_of(GetParam()).run(GetParam().moments);
    ASSERT_EQ(reached_.result.status, PlanStatus::solved) << reached_.result.message;
    ASSERT_EQ(reached_.result.contacts.size(), GetParam().held.size());
  }
  Execution reached_;
};

TEST_P(ExecuteMany, ContactsAreFoundAndTheStateIsStable) {
  const Plan& plan = reached_.result;
  for (std::size_t k = 0; k < plan.contacts.size(); ++k) {
    EXPECT_EQ(plan.contacts[k].obstacle, GetParam().held[k]);
    EXPECT_EQ(plan.contacts[k].at_tip, GetParam().at_tip && k + 1 == plan.contacts.size());
    EXPECT_GT(plan.contacts[k].force, 0.1);
  }
  EXPECT_LE(plan.certificate.moment_balance, tolerance::moment_balance);
  EXPECT_LE(plan.certificate.penetration, tolerance::penetration);
  EXPECT_GT(plan.certificate.stability, 0.1);
  EXPECT_TRUE(plan.certificate.failures.empty());
}

TEST_P(ExecuteMany, AgreesWithTheBoundaryValueProblem) {
  const Plan& plan = reached_.result;
  std::vector<BvpContact> contacts;
  BvpGuess guess;
  guess.angle = angle_of(plan);
  for (const PlannedContact& c : plan.contacts) {
    const Peg& p = GetParam().pegs[static_cast<std::size_t>(c.obstacle)];
    contacts.push_back({{p.x, p.y}, p.radius, c.at_tip, {}});
    // Off by more than is asked for: the method has to find them again.
    guess.arc_lengths.push_back(c.at_tip ? 1.0 : c.arc_length + 1e-4);
    guess.forces.push_back(c.force * 1.01);
  }
  const BvpSolution exact = solve(rod_of(GetParam()), GetParam().moments, contacts, guess);
  EXPECT_NEAR(plan.tip_x, exact.tip_x, 1e-9);  // the local moment balance that is asked for
  EXPECT_NEAR(plan.tip_y, exact.tip_y, 1e-9);
  EXPECT_NEAR(plan.tip_angle, exact.tip_angle, 1e-9);
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    EXPECT_NEAR(plan.contacts[k].force / exact.forces[k], 1.0, 1e-6) << k;
    if (!contacts[k].at_tip) {
      EXPECT_NEAR(plan.contacts[k].arc_length, exact.arc_lengths[k], 1e-8) << k;
    }
  }
}

/// What the finest chain says, and the largest distance of the others from it.
struct ChainValue {
  double finest = 0.0, own_error = 0.0;
};

ChainValue judged(const std::vector<double>& values) {
  ChainValue c{values.back(), 0.0};
  for (const double v : values) c.own_error = std::max(c.own_error, std::abs(v - c.finest));
  return c;
}

// A chain touches a peg with whole joints, so its error depends on where these happen to lie: several chains show how
// large it is. Even numbers of links: a joint lies where the actuators meet.
TEST_P(ExecuteMany, AgreesWithALinkChainWithinItsOwnError) {
  const Plan& plan = reached_.result;
  std::vector<BvpContact> pegs;
  for (const Peg& p : GetParam().pegs) pegs.push_back({{p.x, p.y}, p.radius, false, {}});
  LinkChainOptions options;
  options.angle = angle_of(plan);
  std::vector<double> x, y;
  std::vector<std::vector<double>> forces(pegs.size());
  for (const int links : {198, 224, 258, 292, 330, 368, 402}) {
    options.links = links;
    const LinkChainSolution chain = settle(rod_of(GetParam()), GetParam().moments, pegs, options);
    x.push_back(chain.tip_x);
    y.push_back(chain.tip_y);
    for (std::size_t o = 0; o < pegs.size(); ++o) {
      forces[o].push_back(chain.contacts[o].force);
      const auto found = std::find_if(plan.contacts.begin(), plan.contacts.end(),
                                      [o](const PlannedContact& c) { return c.obstacle == static_cast<int>(o); });
      if (found == plan.contacts.end()) {
        EXPECT_EQ(chain.contacts[o].force, 0.0) << o;
      } else {
        EXPECT_NEAR(chain.contacts[o].arc_length, found->arc_length, 1.0 / links) << o;
      }
    }
  }
  const ChainValue tip_x = judged(x);
  const ChainValue tip_y = judged(y);
  EXPECT_LE(std::hypot(tip_x.own_error, tip_y.own_error), 1e-3);  // else this says little
  EXPECT_NEAR(plan.tip_x, tip_x.finest, tip_x.own_error);
  EXPECT_NEAR(plan.tip_y, tip_y.finest, tip_y.own_error);
  for (const PlannedContact& c : plan.contacts) {
    const ChainValue force = judged(forces[static_cast<std::size_t>(c.obstacle)]);
    EXPECT_LE(force.own_error / c.force, 0.1) << c.obstacle_name;
    EXPECT_NEAR(c.force, force.finest, force.own_error) << c.obstacle_name;
  }
}

INSTANTIATE_TEST_SUITE_P(Layouts, ExecuteMany, testing::ValuesIn(cases()),
                         [](const testing::TestParamInfo<Case>& c) { return std::string(c.param.name); });

}  // namespace
}  // namespace tendril::support
