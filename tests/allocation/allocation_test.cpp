#include <gtest/gtest.h>

#include "counting_malloc.hpp"
#include "tendril/nonlinear_program.hpp"

namespace tendril::test {

namespace {

/// min |x|^2  s.t.  x_0 x_1 = 1, in ten variables.
class Plain : public NonlinearProgram {
 public:
  Plain() : NonlinearProgram(10, 1, 10) { row_lower_[0] = row_upper_[0] = 1.0; }

 protected:
  void do_evaluate(ConstVectorRef x, bool derivatives, Workspace& out) override {
    out.residuals = x;
    out.cost = x.squaredNorm();
    out.constraints[0] = x[0] * x[1];
    if (!derivatives) return;
    out.gradient = 2.0 * x;
    out.residual_jacobian.setIdentity();
    out.jacobian(0, 0) = x[1];
    out.jacobian(0, 1) = x[0];
  }
  void do_hessian(ConstVectorRef, double sigma, ConstVectorRef multipliers, Workspace& out) override {
    out.hessian.setZero();
    out.hessian.diagonal().setConstant(2.0 * sigma);
    out.hessian(0, 1) = out.hessian(1, 0) = multipliers[0];
  }
};

TEST(CountingMalloc, SeesEigenAndNew) {
  const long before = allocations();
  Eigen::VectorXd eigen = Eigen::VectorXd::Ones(1000);
  // A call by name: a new-expression may be left out by the compiler.
  void* plain = ::operator new(8000);
  EXPECT_GE(allocations(), before + 2) << eigen.sum();
  ::operator delete(plain);
}

TEST(HeapPeak, IsTheMostThatLivedAtOnce) {
  void* old = ::operator new(50000);
  watch_heap();
  void* first = ::operator new(30000);
  ::operator delete(first);
  ::operator delete(old);
  {
    const Eigen::VectorXd eigen = Eigen::VectorXd::Ones(1000);
    void* second = ::operator new(30000);
    ::operator delete(second);
    EXPECT_EQ(eigen.sum(), 1000.0);
  }
  void* third = ::operator new(90000);
  const long peak = heap_peak();
  ::operator delete(third);
  // In the end 90000 more and 50000 less live than in the beginning. Blocks are rounded up to 16 bytes.
  EXPECT_NEAR(static_cast<double>(peak), 40000.0, 100.0);
}

TEST(NonlinearProgram, DoesNotAllocateAfterConstruction) {
  Plain program;
  Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(10, 0.5, 1.5);
  const Eigen::VectorXd multipliers = Eigen::VectorXd::Ones(1);
  double sum = 0.0;
  const long before = allocations();
  for (int step = 0; step < 100; ++step) {
    x[0] += 0.01;
    sum += program.cost(x) + program.rest(x) + program.constraints(x)[0] + program.residuals(x)[0];
    sum += program.gradient(x)[0] + program.jacobian(x)(0, 1) + program.residual_jacobian(x)(0, 0) +
           program.rest_gradient(x)[0];
    sum += program.hessian(x, 1.0, multipliers)(0, 1);
  }
  EXPECT_EQ(allocations(), before) << sum;
}

}  // namespace

}  // namespace tendril::test
