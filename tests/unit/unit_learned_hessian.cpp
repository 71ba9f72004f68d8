// Second derivatives that are learned from gradients.

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <limits>

#include "nlp/learned_hessian.hpp"

namespace tendril {

namespace {

const Eigen::Matrix3d& bend() {
  static const Eigen::Matrix3d h{{4.0, 1.0, -2.0}, {1.0, -3.0, 0.5}, {-2.0, 0.5, 1.0}};
  return h;
}

const Eigen::Vector3d steps[] = {{0.3, 0.0, 0.1}, {-0.1, 0.4, 0.0}, {0.2, 0.1, -0.5}};

TEST(LearnedHessian, KnowsAQuadraticAfterAsManyStepsAsVariables) {
  LearnedHessian learned(3);
  EXPECT_EQ(learned.matrix(), Eigen::Matrix3d::Zero());
  Eigen::Vector3d x(0.2, -0.3, 0.5);
  learned.learn(x, bend() * x);
  EXPECT_EQ(learned.matrix(), Eigen::Matrix3d::Zero()) << "one gradient says nothing";
  for (const Eigen::Vector3d& step : steps) {
    x += step;
    learned.learn(x, bend() * x);
    // Exact along the step that was just taken.
    EXPECT_LT((learned.matrix() * step - bend() * step).norm(), 1e-12);
  }
  // Rank-one updates of small numbers, divided by steps of 0.1.
  EXPECT_LT((learned.matrix() - bend()).cwiseAbs().maxCoeff(), 1e-10) << learned.matrix();
  EXPECT_EQ(learned.matrix(), learned.matrix().transpose());
}

TEST(LearnedHessian, LearnsNothingFromRoundingOrFromWhatIsNoNumber) {
  LearnedHessian learned(3);
  const Eigen::Vector3d x(0.2, -0.3, 0.5);
  const Eigen::Vector3d noise(1.0, -1.0, 1.0);
  learned.learn(x, bend() * x);
  learned.learn(x, bend() * x + noise);
  learned.learn(x + 5e-8 * Eigen::Vector3d::UnitX(), bend() * x + noise);
  learned.learn(x + steps[0], Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()));
  EXPECT_EQ(learned.matrix(), Eigen::Matrix3d::Zero());
  // None of these became the point from which the next step is measured.
  learned.learn(x + steps[0], bend() * (x + steps[0]));
  EXPECT_LT((learned.matrix() * steps[0] - bend() * steps[0]).norm(), 1e-12);
}

TEST(LearnedHessian, ForgetsWhatItLearnedBeforeALongStep) {
  LearnedHessian learned(3, 1.0);
  Eigen::Vector3d x(0.2, -0.3, 0.5);
  learned.learn(x, bend() * x);
  x += steps[0];
  learned.learn(x, bend() * x);
  EXPECT_NE(learned.matrix(), Eigen::Matrix3d::Zero());
  x += Eigen::Vector3d(0.0, 1.1, 0.0);
  learned.learn(x, bend() * x);
  EXPECT_EQ(learned.matrix(), Eigen::Matrix3d::Zero());
  x += steps[1];
  learned.learn(x, bend() * x);
  EXPECT_LT((learned.matrix() * steps[1] - bend() * steps[1]).norm(), 1e-12);
}

TEST(LearnedHessian, LeavesOutAnUpdateThatWouldExplode) {
  LearnedHessian learned(3);
  const Eigen::Vector3d x(0.2, -0.3, 0.5);
  learned.learn(x, Eigen::Vector3d::Zero());
  // A change of the gradient across the step: the denominator of the update vanishes.
  learned.learn(x + Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY());
  EXPECT_EQ(learned.matrix(), Eigen::Matrix3d::Zero());
  // The point counts all the same.
  learned.learn(x + 2.0 * Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY() + 3.0 * Eigen::Vector3d::UnitX());
  const Eigen::Matrix3d expected = Eigen::Vector3d(3.0, 0.0, 0.0).asDiagonal();
  // The step is one up to rounding.
  EXPECT_LT((learned.matrix() - expected).norm(), 1e-14);
}

}  // namespace

}  // namespace tendril
