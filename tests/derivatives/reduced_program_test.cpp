// The program in the moments alone: its derivatives against central differences of a whole solved equilibrium each, and
// where it ends.

#include "program/reduced_program.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "differences.hpp"
#include "nlp/feasibility.hpp"
#include "program/worst_program.hpp"
#include "support/sample_programs.hpp"

namespace tendril {
namespace {

struct ReducedCase {
  const char* name;
  int order, pieces;
  bool split, tip_contact;
  int interior_contacts;
};

std::ostream& operator<<(std::ostream& os, const ReducedCase& c) { return os << c.name; }

class ReducedDerivatives : public testing::TestWithParam<ReducedCase> {
 protected:
  ReducedDerivatives()
      : sample({std::make_shared<LegendreBasis>(GetParam().order, GetParam().pieces), GetParam().split,
                GetParam().tip_contact, GetParam().interior_contacts}),
        program(sample.spec) {
    for (int k = 0; k < program.layout().forces; ++k) program.set_branch(k, Branch::touching);
  }

  support::SamplePose sample;
  PoseProgram program;
};

TEST_P(ReducedDerivatives, AreThoseOfEverythingThatFollowsFromTheMoments) {
  ASSERT_TRUE(ReducedProgram::applies(program));
  std::mt19937 random(7);
  std::uniform_real_distribution<double> d(-1.0, 1.0);
  int looked = 0;
  for (int trial = 0; trial < 40 && looked < 4; ++trial) {
    const FeasibilityReport f =
        restore_feasibility(program, program.start_from(constant_curvature(2.0 * d(random))), 1e-9);
    if (!f.feasible) continue;
    ReducedProgram reduced(program, f.x);
    ASSERT_EQ(reduced.variable_count(), program.layout().moments);
    Eigen::VectorXd u = reduced.start();
    for (double& value : u) value += 0.05 * d(random);
    // The equations of the pose program hold wherever the moments are.
    const Eigen::VectorXd x = reduced.full(u);
    if (!x.allFinite()) continue;
    for (int i = 0; i < program.row_count(); ++i) {
      if (!program.is_equality(i)) continue;
      EXPECT_NEAR(program.constraints(x)[i], program.row_lower()[i], 1e-10) << i;
    }
    EXPECT_DOUBLE_EQ(reduced.cost(u), program.cost(x));
    // Beside the end of its branch the rod moves so much that differences say nothing.
    if (!(largest(reduced.jacobian(u)) < 50.0)) continue;
    ++looked;
    expect_first_derivatives(reduced, u);
    expect_hessian(reduced, u, random);
  }
  EXPECT_GE(looked, 2);
}

TEST_P(ReducedDerivatives, HaveRowsForInequalitiesAndForLimitsOfWhatFollows) {
  // Arc lengths have two limits, forces one; both are rows, beside the check points and what is no equation.
  ReducedProgram reduced(program, program.start_from(constant_curvature(0.3)));
  std::vector<std::string> expected;
  for (int i = 0; i < program.row_count(); ++i) {
    if (!program.is_equality(i)) expected.push_back(program.row_name(i));
  }
  const PoseProgram::Layout& at = program.layout();
  for (int i = at.first_arc_length; i < at.first_force + at.forces; ++i) expected.push_back(program.variable_name(i));
  std::vector<std::string> found;
  for (int i = 0; i < reduced.row_count(); ++i) found.push_back(reduced.row_name(i));
  EXPECT_EQ(found, expected);
}

TEST_P(ReducedDerivatives, NeedToKnowWhatTouches) {
  for (int k = 0; k < program.layout().forces; ++k) program.set_branch(k, Branch::open);
  EXPECT_EQ(ReducedProgram::applies(program), program.layout().forces == 0);
}

/// The equilibria of a sample whose contacts push off their normals by ratios that are variables.
struct Rubbing {
  explicit Rubbing(const PoseProgramSpec& spec) : program(spec) {
    for (int k = 0; k < program.layout().forces; ++k) program.set_branch(k, Branch::touching);
  }
  bool begin(double tip_angle) {
    const FeasibilityReport f = restore_feasibility(program, program.start_from(constant_curvature(tip_angle)), 1e-9);
    if (f.feasible) reduced = std::make_unique<ReducedProgram>(program, f.x);
    return f.feasible;
  }
  PoseProgram program;
  std::unique_ptr<ReducedProgram> reduced{};
};

TEST_P(ReducedDerivatives, AgreeWhereTangentialRatiosAreChosenToo) {
  if (!GetParam().split || program.layout().forces == 0) return;
  sample.spec.friction.assign(sample.spec.obstacles.size(), 0.4);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> d(-1.0, 1.0);
  int looked = 0;
  for (int trial = 0; trial < 40 && looked < 3; ++trial) {
    Rubbing rubbing(sample.spec);
    if (!rubbing.begin(2.0 * d(random))) continue;
    ReducedProgram& reduced = *rubbing.reduced;
    ASSERT_EQ(reduced.ratio_count(), rubbing.program.layout().forces);
    ASSERT_EQ(reduced.variable_count(), rubbing.program.layout().moments + reduced.ratio_count());
    EXPECT_EQ(reduced.variable_name(reduced.variable_count() - 1),
              "tangential ratio " + std::to_string(reduced.ratio_count()));
    Eigen::VectorXd u = reduced.start();
    for (double& value : u) value += 0.05 * d(random);
    if (!reduced.full(u).allFinite() || !(largest(reduced.jacobian(u)) < 50.0)) continue;
    ++looked;
    expect_first_derivatives(reduced, u);
    expect_hessian(reduced, u, random);
  }
  EXPECT_GE(looked, 2);
}

TEST_P(ReducedDerivatives, OfTheWorstOfSeveralStatesAgree) {
  if (!GetParam().split || program.layout().forces == 0) return;
  sample.spec.friction.assign(sample.spec.obstacles.size(), 0.4);
  std::mt19937 random(9);
  std::uniform_real_distribution<double> d(-1.0, 1.0);
  constexpr double unit = 0.3;
  int looked = 0;
  for (int trial = 0; trial < 40 && looked < 3; ++trial) {
    const double tip_angle = 2.0 * d(random);
    std::vector<std::unique_ptr<Rubbing>> all;
    std::vector<WorstProgram::State> states;
    for (const double ratio : {0.0, 0.2, -0.4}) {
      all.push_back(std::make_unique<Rubbing>(sample.spec));
      if (!all.back()->begin(tip_angle)) break;
      states.push_back(
          {all.back()->reduced.get(), Eigen::VectorXd::Constant(all.back()->reduced->ratio_count(), ratio)});
    }
    if (states.size() < 3) continue;
    WorstProgram worst(states, unit);
    const int moments = program.layout().moments;
    ASSERT_EQ(worst.variable_count(), moments + 1);
    Eigen::VectorXd x = worst.start(all[0]->reduced->start().head(moments));
    if (!x.allFinite()) continue;
    double most = -1e300;
    for (std::size_t k = 0; k < states.size(); ++k) {
      const double cost = states[k].program->cost(worst.point(k, x));
      EXPECT_GE(x[moments], cost / unit);
      most = std::max(most, cost / unit);
    }
    EXPECT_EQ(x[moments], most);
    EXPECT_EQ(worst.cost(x), most);
    for (double& value : x) value += 0.02 * d(random);
    if (!worst.constraints(x).allFinite() || !(largest(worst.jacobian(x)) < 50.0)) continue;
    ++looked;
    expect_first_derivatives(worst, x);
    expect_hessian(worst, x, random);
  }
  EXPECT_GE(looked, 2);
}

INSTANTIATE_TEST_SUITE_P(Programs, ReducedDerivatives,
                         testing::Values(ReducedCase{"free", 6, 1, true, false, 0},
                                         ReducedCase{"tip", 5, 2, true, true, 0},
                                         ReducedCase{"inside", 6, 1, true, false, 1},
                                         ReducedCase{"inside_one_piece", 7, 1, false, false, 1}),
                         [](const auto& c) { return c.param.name; });

// The distance of a palm is chosen beside moments and ratios, and the object's balance is a row.
TEST(ReducedFinger, DerivativesAreThoseOfEverythingThatFollows) {
  support::SampleGrasp sample({});
  PoseProgramSpec spec = sample.spec.fingers[0];
  spec.palm->minimum = 0.3;
  spec.palm->maximum = 0.9;
  spec.friction.assign(spec.obstacles.size(), 0.6);
  PoseProgram program(spec);
  program.set_branch(0, Branch::touching);
  ASSERT_TRUE(ReducedProgram::applies(program));
  std::mt19937 random(3);
  std::uniform_real_distribution<double> d(-1.0, 1.0);
  int looked = 0;
  for (int trial = 0; trial < 60 && looked < 4; ++trial) {
    const FeasibilityReport f =
        restore_feasibility(program, program.start_from(constant_curvature(-0.8 + 0.8 * d(random))), 1e-9);
    if (!f.feasible) continue;
    ReducedProgram reduced(program, f.x);
    ASSERT_EQ(reduced.variable_count(), program.layout().moments + 2);
    EXPECT_EQ(reduced.variable_name(program.layout().moments), program.variable_name(program.layout().palm));
    EXPECT_EQ(reduced.ratio_count(), 1);
    int balances = 0;
    for (int i = 0; i < reduced.row_count(); ++i) balances += reduced.is_equality(i) ? 1 : 0;
    EXPECT_EQ(balances, 1);
    Eigen::VectorXd u = reduced.start();
    for (double& value : u) value += 0.02 * d(random);
    if (!reduced.full(u).allFinite() || !(largest(reduced.jacobian(u)) < 50.0)) continue;
    ++looked;
    expect_first_derivatives(reduced, u);
    expect_hessian(reduced, u, random);
  }
  EXPECT_GE(looked, 2);
}

/// A strip that its tip force has buckled, and that its moment straightens up to a fold.
class BuckledStrip : public testing::Test {
 protected:
  BuckledStrip() {
    rod.segments = {{0.0, 1.0, 1.0, 0.0, 0.0}};
    rod.actuators = {{0.0, 1.0, -10.0, 10.0}};
    rod.tip_force = {-3.0, 0.0};
    spec.rod = &rod;
    spec.model = &basis;
    spec.nodes = 24;
    program = std::make_unique<PoseProgram>(spec);
  }

  LegendreBasis basis{8};
  Rod rod;
  PoseProgramSpec spec;
  std::unique_ptr<PoseProgram> program;
};

TEST_F(BuckledStrip, FollowsItsBranchToItsEndAndNoFarther) {
  StartShape bent = constant_curvature(1.5);
  bent.moments = {0.0};
  const FeasibilityReport f = restore_feasibility(*program, program->start_from(bent), 1e-10);
  ASSERT_TRUE(f.feasible);
  ReducedProgram reduced(*program, f.x);
  const double u0 = reduced.start()[0];
  const auto tip_angle = [&](double u) {
    const Eigen::VectorXd x = reduced.full(Eigen::VectorXd::Constant(1, u));
    if (!x.allFinite()) return std::nan("");
    program->constraints(x);
    return program->backbone().tip_angle();
  };
  ASSERT_GT(tip_angle(u0), 0.3);
  // Against the bend, in steps of any length, until the branch ends; there the rod is still bent to its side.
  double last = u0;
  double end = std::nan("");
  for (double u = u0; u > u0 - 4.0; u -= 0.05) {
    if (const double angle = tip_angle(u); std::isnan(angle)) {
      end = u;
      break;
    } else {
      EXPECT_GT(angle, 0.0) << u;
      last = u;
    }
  }
  ASSERT_FALSE(std::isnan(end)) << "the branch has a fold";
  EXPECT_TRUE(std::isnan(tip_angle(u0 - 4.0)));
  EXPECT_TRUE(std::isnan(reduced.cost(Eigen::VectorXd::Constant(1, end))));
  // Coming back is always possible, and leads to the same shapes.
  EXPECT_GT(tip_angle(last), 0.0);
  ReducedProgram again(*program, f.x);
  const Eigen::VectorXd there = Eigen::VectorXd::Constant(1, 0.5 * (u0 + last));
  const Eigen::VectorXd first = again.full(there);
  ASSERT_TRUE(first.allFinite());
  ASSERT_TRUE(reduced.full(there).allFinite())
      << "from " << last << " to " << there[0] << ", the branch ends at " << end;
  EXPECT_LT((first - reduced.full(there)).cwiseAbs().maxCoeff(), 1e-9);
}

// From where it stood before, other moments are reached as if nobody had asked for those in between.
TEST_F(BuckledStrip, AWayThatFailedLeavesNoTrace) {
  StartShape bent = constant_curvature(1.5);
  bent.moments = {0.0};
  const FeasibilityReport f = restore_feasibility(*program, program->start_from(bent), 1e-10);
  ASSERT_TRUE(f.feasible);
  ReducedProgram tried(*program, f.x);
  ReducedProgram fresh(*program, f.x);
  const auto from_start = [&](double step) -> Eigen::VectorXd {
    return fresh.start() + Eigen::VectorXd::Constant(1, step);
  };
  ASSERT_FALSE(tried.full(from_start(-4.0)).allFinite()) << "the branch has a fold";
  for (const double step : {0.1, 0.5, 0.0}) {
    const Eigen::VectorXd expected = fresh.full(from_start(step));
    ASSERT_TRUE(expected.allFinite()) << step;
    ASSERT_TRUE(tried.full(from_start(step)).allFinite()) << step;
    EXPECT_LT((expected - tried.full(from_start(step))).cwiseAbs().maxCoeff(), 1e-9) << step;
    EXPECT_FALSE(tried.full(from_start(-4.0)).allFinite());
  }
}

// A strip that holds itself on the unstable branch between two folds, with one moment more on a part of it: steps in
// both moments at once point past a fold to the stable branch, which is near enough to be taken for its own.
TEST_F(BuckledStrip, NeverTakesAnEquilibriumBeyondAFoldForItsOwn) {
  const LegendreBasis pieces{6};
  spec.model = &pieces;
  rod.actuators = {{0.0, 1.0, -10.0, 10.0}, {0.4, 0.95, -20.0, 20.0}};
  struct From {
    double tip_force, tip_angle, moment, partial_moment;
  };
  for (const From& from : {From{-2.8, 0.3, 0.0, -2.0}, From{-2.8, 0.6, 1.5, 0.0}, From{-3.0, 0.6, 1.5, -2.0}}) {
    rod.tip_force = {from.tip_force, 0.0};
    PoseProgram strip(spec);
    StartShape bent = constant_curvature(from.tip_angle);
    bent.moments = {from.moment, from.partial_moment};
    const FeasibilityReport f = restore_feasibility(strip, strip.start_from(bent), 1e-10);
    ASSERT_TRUE(f.feasible);
    const auto is_stable = [&](const Eigen::VectorXd& x) {
      const int n = strip.layout().coordinates;
      // The rows of equilibrium are the slope of the energy, downhill.
      return Eigen::LLT<Eigen::MatrixXd>(-strip.jacobian(x).topLeftCorner(n, n)).info() == Eigen::Success;
    };
    ASSERT_FALSE(is_stable(f.x));
    int reached = 0;
    for (int way = 0; way < 72; ++way) {
      const double direction = 2.0 * std::numbers::pi * (way / 3) / 24.0;
      const double length = std::array{0.25, 0.5, 1.0}[static_cast<std::size_t>(way % 3)];
      ReducedProgram reduced(strip, f.x);
      const Eigen::VectorXd x =
          reduced.full(reduced.start() + length * Eigen::Vector2d(std::cos(direction), std::sin(direction)));
      if (!x.allFinite()) continue;
      ++reached;
      EXPECT_FALSE(is_stable(x)) << "way " << way << " from tip angle " << from.tip_angle;
    }
    EXPECT_GT(reached, 0);
  }
}

TEST_F(BuckledStrip, AnswersTheSameWhateverWasAskedBefore) {
  StartShape bent = constant_curvature(1.5);
  bent.moments = {0.0};
  const FeasibilityReport f = restore_feasibility(*program, program->start_from(bent), 1e-10);
  ASSERT_TRUE(f.feasible);
  ReducedProgram one(*program, f.x);
  ReducedProgram other(*program, f.x);
  const auto ask = [&](ReducedProgram& reduced, double more) {
    return Eigen::VectorXd(reduced.full(one.start() + Eigen::VectorXd::Constant(1, more)));
  };
  for (const double more : {3.0, 0.1, -40.0, 1.3, -0.2, 2.9}) ask(other, more);
  for (const double more : {0.1, 0.3, 1.4, 6.0}) {
    const Eigen::VectorXd first = ask(one, more);
    ASSERT_TRUE(first.allFinite()) << more;
    EXPECT_EQ(first, ask(other, more)) << more;
  }
}

TEST_F(BuckledStrip, HasNothingToChooseWhereMomentsAreFixed) {
  rod.actuators[0].minimum = rod.actuators[0].maximum = 0.5;
  const PoseProgram fixed(spec);
  EXPECT_FALSE(ReducedProgram::applies(fixed));
}

}  // namespace
}  // namespace tendril
