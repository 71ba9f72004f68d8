// What uncertain numbers do to the tip, as a term reads it: derivatives against central differences at random points
// that are no equilibria.

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>
#include <string>

#include "differences.hpp"
#include "support/sample_programs.hpp"

namespace tendril {
namespace {

struct Case {
  const char* name;
  bool split;
  bool tip_contact;
  int interior_contacts;
  const char* shapes;
  const char* rod;
};

std::ostream& operator<<(std::ostream& os, const Case& c) { return os << c.name; }

/// The first number that it reads, as it is.
class First : public ObjectiveBase<First> {
 public:
  Reads reads() const override { return {.tip_deviations = true}; }
  template <class T>
  void operator()(const Quantities<T>& x, Contribution<T>& out) const {
    for (std::size_t i = 0; i < x.tip_deviations.size(); ++i) out.smooth((i == 0 ? 1.0 : 0.0) * x.tip_deviations[i].x);
  }
};

class TipDeviationsOf : public testing::TestWithParam<Case> {
 protected:
  TipDeviationsOf()
      : sample({std::make_shared<LegendreBasis>(4), GetParam().split, GetParam().tip_contact,
                GetParam().interior_contacts, GetParam().shapes, false, GetParam().rod, false, false, false, true}),
        program(sample.spec) {}

  /// Near a shape that is not at rest, with contacts that press.
  Eigen::VectorXd random_point(std::mt19937& random) {
    std::uniform_real_distribution<double> d(-0.2, 0.2);
    const PoseProgram::Layout& at = program.layout();
    Eigen::VectorXd x(program.variable_count());
    for (double& value : x) value = d(random);
    for (int i = 0; i < at.coordinates; ++i) x[i] /= std::pow(1.0 + i % 4, 1.5);
    for (int k = 0; k < at.arc_lengths; ++k) {
      const double low = program.lower()[at.first_arc_length + k];
      const double high = program.upper()[at.first_arc_length + k];
      x[at.first_arc_length + k] = low + (high - low) * (k + 1.0 + d(random)) / (at.arc_lengths + 1.0);
    }
    for (int k = 0; k < at.forces; ++k) x[at.first_force + k] = 0.5 + d(random);
    return x;
  }

  support::SamplePose sample;
  PoseProgram program;
};

TEST_P(TipDeviationsOf, HaveExactFirstDerivatives) {
  std::mt19937 random(3);
  for (int trial = 0; trial < 3; ++trial) expect_first_derivatives(program, random_point(random));
}

TEST_P(TipDeviationsOf, AreOtherOnesWhereAContactHoldsNothing) {
  std::mt19937 random(5);
  for (int k = 0; k < program.layout().forces; ++k) {
    const Eigen::VectorXd before = random_point(random);
    const double touching = program.cost(before);
    program.set_branch(k, Branch::separated);
    EXPECT_NE(program.cost(before), touching);
    expect_first_derivatives(program, random_point(random));
  }
}

// Squares of what is read are exact in the Hessian; what is read has second derivatives that are learned as the program
// is evaluated: nearly exact, where it was looked at along every variable.
TEST_P(TipDeviationsOf, LearnTheirSecondDerivatives) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> d(-1.0, 1.0);
  const First term;
  PoseProgramSpec spec = sample.spec;
  spec.terms = {{&term, 1.0, "first"}};
  PoseProgram seen(spec), asked(spec);
  const Eigen::VectorXd x = random_point(random);
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(seen.row_count());
  const Eigen::MatrixXd expected =
      differences(x, [&](const Eigen::VectorXd& z) { return Eigen::VectorXd(asked.gradient(z)); });
  for (int trial = 0; trial < 4 * x.size(); ++trial) {
    Eigen::VectorXd beside = x;
    for (double& value : beside) value += 1e-5 * d(random);
    seen.gradient(beside);
  }
  EXPECT_GT(largest(expected), 0.05);
  EXPECT_LT(largest(seen.hessian(x, 1.0, none) - expected), 1e-2 * largest(expected));
}

INSTANTIATE_TEST_SUITE_P(Samples, TipDeviationsOf,
                         testing::Values(Case{"free", true, false, 0, "circles", "uniform"},
                                         Case{"inside", true, false, 1, "circles", "loaded"},
                                         Case{"inside_whole", false, false, 1, "walls", "tapered"},
                                         Case{"two_inside", true, false, 2, "circles", "uniform"},
                                         Case{"tip", true, true, 0, "circles", "varied"},
                                         Case{"both", true, true, 1, "hulls", "thick"},
                                         Case{"both_whole", false, true, 1, "circles", "varied"}),
                         [](const testing::TestParamInfo<Case>& c) { return std::string(c.param.name); });

}  // namespace
}  // namespace tendril
