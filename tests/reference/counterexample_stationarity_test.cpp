// Plans that hold every equation and are no minimum: by how much, of which kind, and by which row that was dropped.

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>
#include <string>

#include "counterexample_support.hpp"
#include "obstacle/circle.hpp"
#include "tendril/error.hpp"

namespace tendril::support {
namespace {

/// What least-squares multipliers of the planned equations leave of the cost's slope. The slope by differences, the
/// multipliers from singular values.
double slope_left(Pose& pose, const Eigen::VectorXd& x) {
  const PoseProgram::Layout& at = pose.program->layout();
  const Eigen::MatrixXd rows = pose.program->jacobian(x).topRows(at.coordinates + 2 * at.forces);
  Eigen::VectorXd slope(x.size());
  constexpr double step = 1e-3;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const auto cost = [&](double by) {
      return pose.program->cost(Eigen::VectorXd(x + by * Eigen::VectorXd::Unit(x.size(), i)));
    };
    slope[i] = (8.0 * (cost(step) - cost(-step)) - (cost(2.0 * step) - cost(-2.0 * step))) / (12.0 * step);
  }
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(rows.transpose(), Eigen::ComputeThinU | Eigen::ComputeThinV);
  return (slope + rows.transpose() * svd.solve(-slope)).lpNorm<Eigen::Infinity>();
}

/// The plan moved along its equilibria by a change of the moment.
Eigen::VectorXd with_moment(Pose& pose, double by) {
  return pose.meet(pose.x, {{Demand::variable, pose.moment(), pose.x[pose.moment()] + by}});
}

TEST(CounterexampleStationarity, HalfTheLimitPassesAndTwiceIsRefused) {
  const auto pose = braced_pose();
  // What is left grows with the distance to the minimum.
  const double rate = slope_left(*pose, with_moment(*pose, 1e-3)) / 1e-3;
  ASSERT_GT(rate, 1e-3);
  for (const double sign : {1.0, -1.0}) {
    EXPECT_TRUE(certified(pose->judge(with_moment(*pose, sign * 0.5e-6 / rate))));
    EXPECT_TRUE(refused(pose->judge(with_moment(*pose, sign * 2e-6 / rate)), "stationarity", 2e-6));
  }
}

TEST(CounterexampleStationarity, TheNumberIsWhatNoMultiplierTakesAway) {
  const auto pose = braced_pose();
  for (const double by : {1e-5, 1e-3, 0.1, -0.1}) {
    const Eigen::VectorXd x = with_moment(*pose, by);
    const Certificate c = pose->judge(x);
    // Fourth-order differences of a cost known to 1e-16, of step 1e-3.
    EXPECT_NEAR(c.stationarity, slope_left(*pose, x), 1e-10) << by;
    EXPECT_EQ(c.stationarity_kind, c.stationarity <= 1e-6 ? "S" : "none") << by;
  }
}

// The multipliers that a solver hands over are tried, not believed.
TEST(CounterexampleStationarity, MultipliersHandedOverChangeNoVerdict) {
  const auto pose = braced_pose();
  const Eigen::VectorXd& rows = pose->multipliers;
  const Eigen::VectorXd& bounds = pose->bound_multipliers;
  EXPECT_TRUE(certified(pose->judge(pose->x, &rows, &bounds)));
  const Eigen::VectorXd wrong = -rows;
  EXPECT_TRUE(certified(pose->judge(pose->x, &wrong, &bounds)));
  const Eigen::VectorXd moved = with_moment(*pose, 0.1);
  const Certificate alone = pose->judge(moved);
  const Certificate given = pose->judge(moved, &rows, &bounds);
  EXPECT_EQ(given.stationarity, alone.stationarity);
  EXPECT_EQ(given.failures, alone.failures);
  // A slope that a multiplier of an inactive limit would take away stays.
  Eigen::VectorXd invented = bounds;
  invented[pose->moment()] = -pose->program->gradient(moved)[pose->moment()];
  EXPECT_FALSE(pose->judge(moved, &rows, &invented).valid());
}

/// A plan whose moment is at its upper limit and would go on.
std::unique_ptr<Pose> limited_pose() {
  auto pose = braced_pose();
  pose->rod.actuators[0].maximum = pose->x[pose->moment()] - 0.2;
  pose->assemble();
  pose->plan();
  EXPECT_NEAR(pose->x[pose->moment()], pose->rod.actuators[0].maximum, 1e-12);
  return pose;
}

TEST(CounterexampleStationarity, ALimitHoldsAPlanFromItsOwnSideOnly) {
  const auto pose = limited_pose();
  EXPECT_TRUE(certified(pose->judge(pose->x)));
  const double left = slope_left(*pose, pose->x);
  ASSERT_GT(left, 1e-3);
  // Without the limit, and with one to the other side, the plan falls.
  pose->rod.actuators[0].maximum = 2.0;
  pose->assemble();
  EXPECT_TRUE(refused(pose->judge(pose->x), "stationarity", left));
  pose->rod.actuators[0].minimum = pose->x[pose->moment()];
  pose->assemble();
  EXPECT_TRUE(refused(pose->judge(pose->x), "stationarity", left));
}

TEST(CounterexampleStationarity, AForceLimitHoldsAPlanFromItsOwnSideOnly) {
  const auto pose = limited_pose();
  // What the moment's limit held the force's limit may hold instead: less force is what the plan wants there.
  const double left = slope_left(*pose, pose->x);
  pose->rod.actuators[0].maximum = 2.0;
  int holding = 0;
  for (const bool upper : {true, false}) {
    pose->spec.min_force = upper ? 0.0 : pose->x[pose->force()];
    pose->spec.max_force = upper ? pose->x[pose->force()] : infinity;
    pose->assemble();
    const Certificate c = pose->judge(pose->x);
    if (c.valid()) {
      ++holding;
      EXPECT_FALSE(upper) << "a rising moment lifts the arm off its peg";
    } else {
      EXPECT_TRUE(refused(c, "stationarity", left));
    }
  }
  EXPECT_EQ(holding, 1);
}

// A limit that is farther away than 1e-8 holds nothing.
TEST(CounterexampleStationarity, ALimitNearbyHoldsNothing) {
  const auto pose = limited_pose();
  const double left = slope_left(*pose, pose->x);
  pose->rod.actuators[0].maximum = pose->x[pose->moment()] + 0.5e-8;
  pose->assemble();
  EXPECT_TRUE(certified(pose->judge(pose->x)));
  pose->rod.actuators[0].maximum = pose->x[pose->moment()] + 2e-8;
  pose->assemble();
  EXPECT_TRUE(refused(pose->judge(pose->x), "stationarity", left));
}

// A plan that a check point keeps out of an obstacle is no minimum of the program without that row.
TEST(CounterexampleStationarity, ADroppedCheckPointLeavesItsMultiplierOver) {
  Pose pose;
  pose.rod.actuators[0] = {0.0, 1.0, -2.0, 2.0};
  pose.add(std::make_unique<Circle>(Vec2{0.97, 0.43}, 0.1));
  pose.wish.tip = {0.897, 0.379};
  pose.wish.tip_weight = 1.0;
  pose.spec.checks = {{0, 1.0, 0}};
  pose.assemble();
  pose.x = pose.program->start_from(constant_curvature(0.74));
  pose.plan();
  // The tip is the nearest point, and touches.
  ASSERT_NEAR(pose.program->constraints(pose.x)[pose.program->layout().first_check], 0.0, 1e-11);
  EXPECT_TRUE(certified(pose.judge(pose.x)));
  const double left = slope_left(pose, pose.x);
  ASSERT_GT(left, 1e-3);
  pose.spec.checks = {};
  pose.assemble();
  EXPECT_TRUE(refused(pose.judge(pose.x), "stationarity", left));
  // A row of another place does not carry it.
  pose.spec.checks = {{0, 0.5, 0}};
  pose.assemble();
  EXPECT_TRUE(refused(pose.judge(pose.x), "stationarity", left));
  // A judge of other rows than the program's says so.
  PoseProgramSpec unchecked = pose.spec;
  unchecked.checks.clear();
  Certifier other(unchecked);
  EXPECT_THROW((void)other.certify(*pose.program, pose.x), Error);
  pose.spec.checks = {{0, 1.0, 0}};
  // Nor would one that holds the rod to the obstacle instead of out of it.
  pose.wish.tip = {0.8, 0.1};
  pose.assemble();
  EXPECT_FALSE(pose.judge(pose.x).valid());
}

/// An arc that grazes a circle without force: gap and force are both zero.
struct Grazing : Pose {
  Grazing() {
    rod.actuators[0] = {0.0, 1.0, -2.0, 2.0};
    add(std::make_unique<Circle>(Vec2{0.55, 0.05}, 0.04));
    spec.contacts = {{0, false, 0}};
    assemble();
    StartShape start = constant_curvature(0.6);
    start.moments = {0.6};
    start.arc_lengths = {0.6};
    x = program->start_from(start);
    x = meet(x, {{Demand::variable, force(), 0.0}});
  }
  /// The wish whose slope is balanced by these multipliers of gap >= 0 and force >= 0 (positive: the plan would enter
  /// the obstacle, or pull).
  Certificate judge_with(double of_gap, double of_force) {
    // Unknown: both slopes of the wish, and the multipliers of equilibrium and closest point.
    const PoseProgram::Layout& at = program->layout();
    const auto size = x.size();
    Eigen::MatrixXd system = Eigen::MatrixXd::Zero(size, size);
    const Eigen::MatrixXd jacobian = program->jacobian(x);
    system.leftCols(at.coordinates) = jacobian.topRows(at.coordinates).transpose();
    system.col(at.coordinates) = jacobian.row(at.first_closest).transpose();
    system(moment(), size - 2) = 1.0;
    system(force(), size - 1) = 1.0;
    Eigen::VectorXd right = of_gap * jacobian.row(at.first_gap).transpose();
    right[force()] += of_force;
    const Eigen::VectorXd found = system.fullPivLu().solve(right);
    wish.per_moment = found[size - 2];
    wish.per_force = found[size - 1];
    assemble();
    return judge(x);
  }
};

TEST(CounterexampleStationarity, WhereGapAndForceVanishBothMultipliersDecide) {
  Grazing pose;
  ASSERT_NEAR(pose.program->constraints(pose.x)[pose.gap()], 0.0, 1e-13);
  EXPECT_TRUE(certified(pose.judge_with(1.0, 1.0)));
  EXPECT_TRUE(certified(pose.judge_with(1.0, 0.0)));
  EXPECT_TRUE(certified(pose.judge_with(0.0, 1.0)));
  // The gap would open, and the force stay zero: no first-order way down only if one may not leave both branches.
  Certificate c = pose.judge_with(-1.0, 0.0);
  EXPECT_LE(c.stationarity, 1e-6);
  EXPECT_EQ(c.stationarity_kind, "M");
  EXPECT_EQ(c.failures, std::vector<std::string>{"the point is M-stationary, not S-stationary"});
  // Opposite signs: not even C-stationary.
  c = pose.judge_with(-1.0, 1.0);
  EXPECT_LE(c.stationarity, 1e-6);
  EXPECT_EQ(c.stationarity_kind, "none");
  EXPECT_EQ(c.failures, std::vector<std::string>{"the point is not even C-stationary, not S-stationary"});
  // A force that the plan wants: the slope is left over.
  for (const double of_gap : {1.0, -1.0}) {
    c = pose.judge_with(of_gap, -1.0);
    EXPECT_GT(c.stationarity, 1e-3);
    EXPECT_EQ(c.stationarity_kind, "none");
    ASSERT_EQ(c.failures.size(), 1U);
    EXPECT_EQ(c.failures[0].find("stationarity "), 0U) << c.failures[0];
  }
}

// A multiplier counts as zero up to the limit of the stationarity.
TEST(CounterexampleStationarity, TheKindIsDecidedAtTheLimitOfTheStationarity) {
  Grazing pose;
  EXPECT_EQ(pose.judge_with(-1.0, 0.5e-6).stationarity_kind, "M");
  EXPECT_EQ(pose.judge_with(-1.0, 2e-6).stationarity_kind, "none");
}

// Multipliers of a contact that neither gaps nor presses are looked for whatever is handed over.
TEST(CounterexampleStationarity, GivenMultipliersDoNotMakeAGrazingPlanStrong) {
  Grazing pose;
  (void)pose.judge_with(-1.0, 0.0);
  const Eigen::VectorXd rows = Eigen::VectorXd::Zero(pose.program->row_count());
  const Eigen::VectorXd bounds = Eigen::VectorXd::Zero(pose.x.size());
  EXPECT_EQ(pose.judge(pose.x, &rows, &bounds).stationarity_kind, "M");
}

// A force of 2e-9 presses, one of half of 1e-9 does not: there both multipliers decide.
TEST(CounterexampleStationarity, AContactThatBarelyPressesIsOneThatTouches) {
  Grazing pose;
  (void)pose.judge_with(-1.0, 0.0);
  EXPECT_TRUE(certified(pose.judge(pose.meet(pose.x, {{Demand::variable, pose.force(), 2e-9}}))));
  EXPECT_EQ(pose.judge(pose.meet(pose.x, {{Demand::variable, pose.force(), 0.5e-9}})).stationarity_kind, "M");
}

}  // namespace
}  // namespace tendril::support
