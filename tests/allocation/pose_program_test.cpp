// Evaluating a pose program allocates nothing: sizes are known when it is assembled.

#include "tendril/pose_program.hpp"

#include <gtest/gtest.h>

#include <string>

#include "counting_malloc.hpp"
#include "tendril/circle.hpp"
#include "tendril/grasp_program.hpp"
#include "tendril/wall.hpp"

namespace tendril::test {

namespace {

/// Reads all kinds of quantities and gives all kinds of parts.
class Mixed : public ObjectiveBase<Mixed> {
 public:
  Reads reads() const override {
    Reads r;
    r.tip_position = r.tip_angle = r.bending_energy = r.moments = true;
    r.contact_point = r.contact_gap = r.contact_normal = r.contact_force = r.contact_arc_length = true;
    r.target = true;
    r.samples = {0.3, 0.8};
    return r;
  }
  template <class T>
  void operator()(const Quantities<T>& x, Contribution<T>& out) const {
    const FingerQuantities<T>& f = x.fingers[0];
    out.residual(f.tip.x - x.target.position.x);
    out.residual(sin(f.tip.angle) * f.bending_energy);
    for (const T& u : f.moments) out.residual(u);
    for (const BackboneQuantities<T>& b : f.samples) out.smooth(b.x * b.angle + b.y * b.curvature);
    for (const ContactQuantities<T>& c : f.contacts) {
      out.linear(-c.force);
      out.smooth((c.x - c.reference_x) * c.gap * c.normal_y + c.arc_length * c.y);
    }
  }
};

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
  Rod rod;
  rod.segments = {{0.0, 1.0, 1.0, 1.7, 0.2}};
  rod.actuators = {{0.0, 1.0, -3.0, 3.0}, {0.4, 1.0, -1.0, 1.0}};
  rod.gravity = {0.0, -1.0};
  rod.payload = 0.1;
  rod.tip_force = {0.05, 0.02};
  const LegendreBasis basis(c.order);
  const Circle peg({0.6, -0.05}, 0.08);
  const Mixed mixed;
  PoseProgramSpec spec;
  spec.rod = &rod;
  spec.model = &basis;
  spec.obstacles = {&peg};
  spec.terms = {{&mixed, 2.0, "mixed"}};
  spec.target = {{0.9, 0.2}, 0.0, true, false};
  spec.split = c.split;
  spec.contacts = {{0, c.at_tip, c.at_tip ? 0 : 1}};
  spec.checks = {{0, 0.5, 0}, {1, 0.5, 0}, {1, 1.0, 0}};
  spec.nodes = 40;
  PoseProgram program(spec);
  Eigen::VectorXd x = program.start_from(constant_curvature(0.5));
  const Eigen::VectorXd multipliers = Eigen::VectorXd::Constant(program.row_count(), 0.3);
  double sum = 0.0;
  const long before = allocations();
  for (int step = 0; step < 20; ++step) {
    x[0] += 1e-3;
    // In the order of a line search (values only), then all derivatives.
    sum += program.cost(x) + program.constraints(x)[0];
    x[1] += 1e-3;
    sum += program.jacobian(x)(0, 1) + program.gradient(x)[0];
    sum += program.residuals(x)[0] + program.residual_jacobian(x)(0, 0) + program.rest(x) + program.rest_gradient(x)[0];
    sum += program.hessian(x, 0.7, multipliers)(0, 1);
  }
  EXPECT_EQ(allocations(), before) << sum;
}

// Two fingers as one program.
TEST(GraspProgramAllocation, IsNothingAfterConstruction) {
  Rod rod;
  rod.segments = {{0.0, 1.0, 1.0, 1.7, 0.2}};
  rod.actuators = {{0.0, 1.0, -3.0, 3.0}, {0.4, 1.0, -1.0, 1.0}};
  rod.gravity = {0.0, -1.0};
  rod.base = {0.0, 0.2};
  const LegendreBasis basis(6);
  const Circle object({}, 0.25);
  const Wall palm({}, {1.0, 0.0});
  const Mixed mixed;
  GraspProgramSpec spec;
  for (PoseProgramSpec& finger : spec.fingers) {
    finger.rod = &rod;
    finger.model = &basis;
    finger.obstacles = {&object, &palm};
    finger.carried = 1;
    finger.terms = {{&mixed, 2.0, "mixed"}};
    finger.contacts = {{0, false, 1}};
    finger.checks = {{0, 0.5, 0}, {1, 0.5, 1}};
    finger.nodes = 40;
    finger.palm = PalmSetup{};
  }
  spec.fingers[1].term_units = {0.8, 1.4};
  spec.palm_minimum = 0.3;
  spec.palm_maximum = 0.9;
  spec.separations = {{2, 1.0, 2, 1.0, {0.0, 1.0}}};
  GraspProgram program(spec);
  Eigen::VectorXd x = program.start_from(constant_curvature(-0.5), constant_curvature(-0.3));
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

INSTANTIATE_TEST_SUITE_P(Legendre, PoseProgramAllocation,
                         testing::Values(Case{"six_split", 6, true, false}, Case{"six_whole", 6, false, false},
                                         Case{"six_tip", 6, true, true}, Case{"twenty_split", 20, true, false},
                                         Case{"twenty_whole", 20, false, false}, Case{"twenty_tip", 20, false, true}),
                         [](const testing::TestParamInfo<Case>& c) { return std::string(c.param.name); });

}  // namespace

}  // namespace tendril::test
