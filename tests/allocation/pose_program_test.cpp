// Evaluating a pose program allocates nothing: sizes are known when it is assembled.

#include "program/pose_program.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "counting_malloc.hpp"
#include "program/grasp_program.hpp"
#include "support/sample_programs.hpp"

namespace tendril::test {

namespace {

/// In the order of a line search (values only), then all derivatives.
void expect_no_allocation(NonlinearProgram& program, Eigen::VectorXd x) {
  const Eigen::VectorXd multipliers = Eigen::VectorXd::Constant(program.row_count(), 0.3);
  double sum = 0.0;
  const long before = allocations();
  for (int step = 0; step < 20; ++step) {
    x[0] += 1e-3;
    sum += program.cost(x) + program.constraints(x)[0];
    x[1] += 1e-3;
    sum += program.jacobian(x)(0, 1) + program.gradient(x)[0];
    sum += program.residuals(x)[0] + program.residual_jacobian(x)(0, 0) + program.rest(x) + program.rest_gradient(x)[0];
    sum += program.hessian(x, 0.7, multipliers)(0, 1);
  }
  EXPECT_EQ(allocations(), before) << sum;
}

struct Case {
  const char* name;
  int order;
  bool split;
  bool at_tip;
};

std::ostream& operator<<(std::ostream& os, const Case& c) { return os << c.name; }

class PoseProgramAllocation : public testing::TestWithParam<Case> {};

TEST_P(PoseProgramAllocation, IsNothingAfterConstruction) {
  const Case& c = GetParam();
  for (const auto& [shapes, rod] : {std::pair("circles", "uniform"), {"walls", "uniform"}, {"hulls", "varied"}}) {
    SCOPED_TRACE(shapes);
    const support::SamplePose sample(
        {std::make_shared<LegendreBasis>(c.order), c.split, c.at_tip, c.at_tip ? 0 : 1, shapes, false, rod});
    PoseProgram program(sample.spec);
    expect_no_allocation(program, program.start_from(constant_curvature(0.5)));
  }
}

// What error bars do to the tip, as a term reads it.
TEST_P(PoseProgramAllocation, IsNothingWithErrorBars) {
  const Case& c = GetParam();
  const support::SamplePose sample({std::make_shared<LegendreBasis>(c.order), c.split, c.at_tip, c.at_tip ? 0 : 1,
                                    "circles", false, "varied", false, false, false, true});
  PoseProgram program(sample.spec);
  expect_no_allocation(program, program.start_from(constant_curvature(0.5)));
}

// Two fingers as one program.
TEST(GraspProgramAllocation, IsNothingAfterConstruction) {
  const support::SampleGrasp sample({});
  GraspProgram program(sample.spec);
  expect_no_allocation(program, program.start_from(constant_curvature(-0.5), constant_curvature(-0.3)));
}

INSTANTIATE_TEST_SUITE_P(Legendre, PoseProgramAllocation,
                         testing::Values(Case{"six_split", 6, true, false}, Case{"six_whole", 6, false, false},
                                         Case{"six_tip", 6, true, true}, Case{"twenty_split", 20, true, false},
                                         Case{"twenty_whole", 20, false, false}, Case{"twenty_tip", 20, false, true}),
                         [](const testing::TestParamInfo<Case>& c) { return std::string(c.param.name); });

}  // namespace

}  // namespace tendril::test
