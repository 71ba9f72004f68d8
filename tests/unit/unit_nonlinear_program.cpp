#include <gtest/gtest.h>

#include <stdexcept>

#include "tendril/error.hpp"
#include "tendril/nonlinear_program.hpp"

namespace tendril {

namespace {

/// f = x^2 with a row c = 3 x.
class Counting : public NonlinearProgram {
 public:
  Counting() : NonlinearProgram(1, 1, 0) {}
  int evaluations = 0;
  int hessians = 0;
  bool throws = false;

 protected:
  void do_evaluate(ConstVectorRef x, bool derivatives, Workspace& out) override {
    ++evaluations;
    if (throws) throw std::runtime_error("broken");
    out.cost = out.rest = x[0] * x[0];
    out.constraints[0] = 3.0 * x[0];
    if (!derivatives) return;
    out.gradient[0] = out.rest_gradient[0] = 2.0 * x[0];
    out.jacobian(0, 0) = 3.0;
  }
  void do_hessian(ConstVectorRef, double sigma, ConstVectorRef, Workspace& out) override {
    ++hessians;
    out.hessian(0, 0) = 2.0 * sigma;
  }
};

Eigen::VectorXd at(double x) { return Eigen::VectorXd::Constant(1, x); }

TEST(NonlinearProgram, ComputesValuesOncePerPoint) {
  Counting program;
  EXPECT_EQ(program.cost(at(2.0)), 4.0);
  EXPECT_EQ(program.constraints(at(2.0))[0], 6.0);
  EXPECT_EQ(program.rest(at(2.0)), 4.0);
  EXPECT_EQ(program.evaluations, 1);
  EXPECT_EQ(program.counts().values, 1);
  EXPECT_EQ(program.counts().first_derivatives, 0);
}

TEST(NonlinearProgram, DerivativesBringTheValuesAlong) {
  Counting program;
  EXPECT_EQ(program.gradient(at(2.0))[0], 4.0);
  EXPECT_EQ(program.jacobian(at(2.0))(0, 0), 3.0);
  EXPECT_EQ(program.cost(at(2.0)), 4.0);
  EXPECT_EQ(program.evaluations, 1);
  EXPECT_EQ(program.counts().values, 1);
  EXPECT_EQ(program.counts().first_derivatives, 1);
}

TEST(NonlinearProgram, ComparesPointsBitByBit) {
  Counting program;
  program.cost(at(0.0));
  program.cost(at(-0.0));
  program.cost(at(std::numeric_limits<double>::denorm_min()));
  EXPECT_EQ(program.evaluations, 3);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  program.cost(at(nan));
  program.cost(at(nan));
  EXPECT_EQ(program.evaluations, 4);
}

TEST(NonlinearProgram, KeepsTheHessianOfTheSameMultipliers) {
  Counting program;
  EXPECT_EQ(program.hessian(at(1.0), 0.5, at(1.0))(0, 0), 1.0);
  program.hessian(at(1.0), 0.5, at(1.0));
  EXPECT_EQ(program.hessians, 1);
  EXPECT_EQ(program.hessian(at(1.0), 1.0, at(1.0))(0, 0), 2.0);
  program.hessian(at(1.0), 1.0, at(2.0));
  program.hessian(at(1.5), 1.0, at(2.0));
  EXPECT_EQ(program.hessians, 4);
  EXPECT_EQ(program.counts().hessians, 4);
}

TEST(NonlinearProgram, ForgetsAPointThatThrew) {
  Counting program;
  program.throws = true;
  EXPECT_THROW(program.cost(at(1.0)), std::runtime_error);
  program.throws = false;
  EXPECT_EQ(program.cost(at(1.0)), 1.0);
}

TEST(NonlinearProgram, InvalidateMakesItComputeAgain) {
  Counting program;
  program.cost(at(1.0));
  program.invalidate();
  program.cost(at(1.0));
  EXPECT_EQ(program.evaluations, 2);
}

TEST(NonlinearProgram, RefusesAPointOfAnotherSize) {
  Counting program;
  EXPECT_THROW(program.cost(Eigen::VectorXd::Zero(2)), Error);
  EXPECT_THROW(program.hessian(at(1.0), 1.0, Eigen::VectorXd::Zero(2)), Error);
}

}  // namespace

}  // namespace tendril
