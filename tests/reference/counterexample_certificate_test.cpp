// Plans that are right but for one thing: half its limit passes, twice the limit is refused by name and number. The
// limits are those of model.md section 7, written out; each number is computed a second time without the library.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include "counterexample_support.hpp"
#include "obstacle/circle.hpp"
#include "obstacle/rounded_hull.hpp"
#include "obstacle/wall.hpp"
#include "tendril/tolerances.hpp"

namespace tendril::support {
namespace {

constexpr double half = 0.5, twice = 2.0;

/// Judges a plan disturbed to half a limit and to twice the limit.
void expect_limit(const std::string& name, double limit, const std::function<Certificate(double)>& disturbed,
                  double tolerance = 0.02) {
  SCOPED_TRACE(name);
  EXPECT_TRUE(certified(disturbed(half * limit)));
  EXPECT_TRUE(refused(disturbed(twice * limit), name, twice * limit, tolerance));
}

TEST(CounterexampleCertificate, TheUndisturbedPlansAreCertified) {
  const auto braced = braced_pose();
  const Certificate c = braced->judge(braced->x);
  EXPECT_TRUE(certified(c));
  EXPECT_GT(braced->x[braced->force()], 0.1) << "the peg is to carry weight";
  EXPECT_LT(std::abs(braced->x[braced->moment()]), 1.9) << "no limit is to be active";
  // A tenth of every limit is left for what is done to it.
  EXPECT_LE(c.equilibrium, 1e-10);
  EXPECT_LE(c.complementarity, 1e-10);
  EXPECT_LE(c.closest_point, 1e-9);
  EXPECT_LE(c.stationarity, 1e-7);
}

/// The largest row of -d(Pi - f d)/dq at frozen knots, by central differences of the energy.
double residual_by_differences(const Pose& pose, const Eigen::VectorXd& x) {
  const PlainRod rod = plain(pose, x);
  const Eigen::VectorXd q = x.head(pose.program->layout().coordinates);
  const double f = x[pose.force()];
  const double s = x[pose.place()];
  // The force is dead along the normal that the obstacle has at the contact.
  const Vec2 center = pose.obstacles[0]->reference_point();
  const Vec2 apart = rod.point(q, s) - center;
  const Vec2 normal = (1.0 / norm(apart)) * apart;
  const auto potential = [&](const Eigen::VectorXd& at) {
    return rod.energy(at, x[pose.moment()]) - f * dot(normal, rod.point(at, s));
  };
  double worst = 0.0;
  constexpr double step = 2e-3;
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const auto shifted = [&](double by) { return potential(q + by * Eigen::VectorXd::Unit(q.size(), i)); };
    const double slope = (45.0 * (shifted(step) - shifted(-step)) - 9.0 * (shifted(2 * step) - shifted(-2 * step)) +
                          (shifted(3 * step) - shifted(-3 * step))) /
                         (60.0 * step);
    worst = std::max(worst, std::abs(slope));
  }
  return worst;
}

TEST(CounterexampleCertificate, Equilibrium) {
  const auto pose = braced_pose();
  const int n = pose->program->layout().coordinates;
  // The first and the last row of each piece, with both signs.
  for (const int row : {0, n / 2 - 1, n / 2, n - 1}) {
    for (const double sign : {1.0, -1.0}) {
      SCOPED_TRACE("equilibrium row " + std::to_string(row));
      expect_limit("equilibrium residual", 1e-9, [&](double size) {
        return pose->judge(pose->meet(pose->x, {{Demand::row, row, sign * size}}));
      });
    }
  }
}

TEST(CounterexampleCertificate, EquilibriumIsTheSlopeOfTheEnergy) {
  const auto pose = braced_pose();
  for (const double size : {0.0, 2e-9, 1e-6}) {
    const Eigen::VectorXd x = pose->meet(pose->x, {{Demand::row, 1, size}});
    // Sixth-order differences of an energy known to 1e-15 leave 1e-12.
    EXPECT_NEAR(pose->judge(x).equilibrium, residual_by_differences(*pose, x), 2e-12) << size;
  }
}

// A rule that is too coarse holds its own equations; the doubled one shows what it missed.
TEST(CounterexampleCertificate, EquilibriumOnTheJudgedRuleAloneIsNone) {
  const auto fine = braced_pose();
  Pose pose;
  pose.rod = fine->rod;
  pose.wish = fine->wish;
  pose.add(std::make_unique<Circle>(Vec2{0.6, 0.0}, 0.08));
  pose.spec.contacts = fine->spec.contacts;
  pose.assemble();
  pose.spec.nodes = 4;
  pose.program = std::make_unique<PoseProgram>(pose.spec);
  pose.program->set_branch(0, Branch::touching);
  const Eigen::VectorXd x = pose.meet(fine->x, {{Demand::variable, pose.moment(), fine->x[fine->moment()]}});
  const int n = pose.program->layout().coordinates;
  ASSERT_LE(pose.program->constraints(x).head(n + 2).cwiseAbs().maxCoeff(), 1e-11);
  const Certificate c = pose.judge(x);
  PoseProgramSpec doubled = pose.spec;
  doubled.nodes = 8;
  PoseProgram other(doubled);
  const Eigen::VectorXd rows = other.constraints(x);
  EXPECT_GT(c.equilibrium, 1e-8);
  EXPECT_DOUBLE_EQ(c.equilibrium, rows.head(n).cwiseAbs().maxCoeff());
  EXPECT_DOUBLE_EQ(c.quadrature, (rows - Eigen::VectorXd(pose.program->constraints(x))).cwiseAbs().maxCoeff());
  ASSERT_FALSE(c.valid());
  EXPECT_EQ(c.failures[0].find("equilibrium residual"), 0U) << c.failures[0];
}

/// The plan moved along its equilibria until `variable` has passed `side` times `size` beyond its value, which is made
/// its limit by `limit`.
void expect_bound(Pose& pose, int variable, double side, const std::function<void(double)>& limit) {
  const double at = pose.x[variable];
  limit(at);
  pose.assemble();
  expect_limit("violation of a limit", 1e-9, [&](double size) {
    return pose.judge(pose.meet(pose.x, {{Demand::variable, variable, at + side * size}}));
  });
  // To the other side there is no limit, though there the plan is no minimum any more; so far it may go.
  EXPECT_TRUE(certified(pose.judge(pose.meet(pose.x, {{Demand::variable, variable, at - side * 5e-9}}))));
}

TEST(CounterexampleCertificate, MomentAboveItsLimit) {
  const auto pose = braced_pose();
  expect_bound(*pose, pose->moment(), 1.0, [&](double at) { pose->rod.actuators[0].maximum = at; });
}

TEST(CounterexampleCertificate, MomentBelowItsLimit) {
  const auto pose = braced_pose();
  expect_bound(*pose, pose->moment(), -1.0, [&](double at) { pose->rod.actuators[0].minimum = at; });
}

TEST(CounterexampleCertificate, ForceAboveItsLimit) {
  const auto pose = braced_pose();
  expect_bound(*pose, pose->force(), 1.0, [&](double at) { pose->spec.max_force = at; });
}

TEST(CounterexampleCertificate, ForceBelowWhatIsRequired) {
  const auto pose = braced_pose();
  expect_bound(*pose, pose->force(), -1.0, [&](double at) { pose->spec.min_force = at; });
}

TEST(CounterexampleCertificate, TipBeyondTheTargetsTolerance) {
  const auto pose = braced_pose();
  (void)pose->program->constraints(pose->x);
  const Vec2 tip = pose->program->backbone().tip();
  const double angle = pose->program->backbone().tip_angle();
  const double off = 0.01;
  pose->spec.target.position = tip + Vec2{0.6 * off, -0.8 * off};
  pose->spec.target.angle = angle - off;
  const auto with = [&](TargetTolerance tolerance) {
    pose->spec.tolerance = tolerance;
    pose->assemble();
    return pose->judge(pose->x);
  };
  // The row of the position is not the distance, but falls by 1 / sqrt(2) of the tolerance's growth.
  expect_limit("violation of a limit", tolerance::bounds, [&](double e) {
    return with({off - std::sqrt(2.0) * e, infinity});
  });
  expect_limit("violation of a limit", tolerance::bounds, [&](double e) { return with({infinity, off - e}); });
}

// The limits are those of the scene whatever branch the program is on.
TEST(CounterexampleCertificate, ABranchThatHoldsAForceAtZeroIsNoLimit) {
  const auto pose = braced_pose();
  for (const Branch branch : {Branch::open, Branch::separated, Branch::touching}) {
    pose->program->set_branch(0, branch);
    EXPECT_LE(pose->judge(pose->x).bounds, 1e-12);
  }
}

// A joint of two equal segments bounds the stretch that the contact is planned on, 1e-5 away from it (model.md
// section 2).
TEST(CounterexampleCertificate, ArcLengthBeyondItsStretch) {
  for (const bool upper : {true, false}) {
    SCOPED_TRACE(upper ? "before the joint" : "behind the joint");
    const auto free = braced_pose();
    const double joint = free->x[free->place()] + (upper ? 2e-3 : -2e-3);
    const double side = upper ? 1.0 : -1.0;
    Pose pose;
    pose.rod = free->rod;
    Rod::Segment second = pose.rod.segments[0];
    pose.rod.segments[0].to = second.from = joint;
    pose.rod.segments.push_back(second);
    pose.add(std::make_unique<Circle>(Vec2{0.6, 0.0}, 0.08));
    pose.spec.contacts = {{0, false, upper ? 0 : 1}};
    pose.assemble();
    const double limit = joint - side * 1e-5;
    StartShape start = constant_curvature(0.4);
    start.moments = {free->x[free->moment()]};
    start.arc_lengths = {limit};
    start.forces = {1.0};
    const auto at_place = [&](double s, const Eigen::VectorXd& from) {
      Eigen::VectorXd x = from;
      for (int i = 0; i < 3; ++i) x = pose.meet(x, {{Demand::variable, pose.place(), s}});
      return x;
    };
    pose.x = at_place(limit, pose.program->start_from(start));
    // The moment that brings the contact there is the one that is wanted, so that nothing else is wrong.
    pose.wish.moment = pose.x[pose.moment()];
    pose.wish.moment_weight = 1.0;
    pose.assemble();
    ASSERT_TRUE(certified(pose.judge(pose.x)));
    expect_limit("violation of a limit", 1e-9,
                 [&](double size) { return pose.judge(at_place(limit + side * size, pose.x)); });
  }
}

/// Each kind of obstacle, with its surface `depth` behind a point of the rod that it would touch along `normal`.
std::vector<std::unique_ptr<Obstacle>> every_shape(Vec2 point, Vec2 normal, double depth) {
  const Vec2 surface = point + depth * normal;
  const auto inside = [&](double by, double along) { return surface - by * normal + along * turned(normal); };
  std::vector<std::unique_ptr<Obstacle>> shapes;
  shapes.push_back(std::make_unique<Circle>(inside(0.05, 0.0), 0.05));
  shapes.push_back(std::make_unique<Circle>(inside(1e-4, 0.0), 1e-4));
  // A capsule across the rod, and a triangle with a rounded corner on it.
  shapes.push_back(std::make_unique<RoundedHull>(std::vector<Vec2>{inside(0.02, 0.0), inside(0.3, 0.0)}, 0.02));
  shapes.push_back(
      std::make_unique<RoundedHull>(std::vector<Vec2>{inside(0.01, 0.0), inside(0.2, 0.1), inside(0.2, -0.1)}, 0.01));
  return shapes;
}

TEST(CounterexampleCertificate, PenetrationOfAnObstacleWithoutAContact) {
  const auto braced = braced_pose();
  const PlainRod rod = plain(*braced, braced->x);
  for (const double s : {0.3, 0.83, 1.0}) {
    const double angle = rod.angle(braced->x, s);
    const Vec2 tangent{std::cos(angle), std::sin(angle)};
    // Beside the rod above and below, and ahead of its tip.
    for (const Vec2 normal : {turned(tangent), -turned(tangent), -tangent}) {
      if (s < 1.0 && normal == -tangent) continue;
      for (std::size_t shape = 0; shape < 4; ++shape) {
        SCOPED_TRACE("shape " + std::to_string(shape) + " at " + std::to_string(s));
        // The bound is sharp to 1e-10 of L (model.md section 7: certified depth).
        expect_limit(
            "penetration", 1e-9,
            [&](double depth) {
              std::vector<std::unique_ptr<Obstacle>> shapes = every_shape(rod.point(braced->x, s), normal, depth);
              braced->obstacles.resize(1);
              braced->add(std::move(shapes[shape]));
              braced->assemble();
              const Certificate c = braced->judge(braced->x);
              EXPECT_GE(c.penetration, depth * (1.0 - 1e-3));
              return c;
            },
            0.06);
      }
    }
  }
}

TEST(CounterexampleCertificate, PenetrationOfAWall) {
  // The lowest point of a straight rod that points down is its tip.
  for (const double angle : {-0.3, -1.2}) {
    expect_limit(
        "penetration", 1e-9,
        [&](double depth) {
          Pose pose(4);
          pose.rod.actuators.clear();
          pose.rod.base_angle = angle;
          pose.add(std::make_unique<Wall>(Vec2{0.0, std::sin(angle) + depth}, Vec2{0.0, 1.0}));
          pose.assemble();
          return pose.judge(pose.x);
        },
        0.06);
  }
}

// A gap under force, and a force at a gap.
TEST(CounterexampleCertificate, Complementarity) {
  const auto pose = braced_pose();
  expect_limit("complementarity", 1e-9, [&](double gap) {
    const Eigen::VectorXd x = pose->meet(pose->x, {{Demand::row, pose->gap(), gap}});
    const PlainRod rod = plain(*pose, x);
    const double distance = norm(rod.point(x, x[pose->place()]) - Vec2{0.6, 0.0}) - 0.08;
    const Certificate c = pose->judge(x);
    EXPECT_NEAR(c.complementarity, distance, 1e-13);
    return c;
  });
}

TEST(CounterexampleCertificate, ForceAcrossAGap) {
  // The arm stands well above the peg, and the closest point is where it belongs.
  const auto pose = braced_pose();
  pose->wish.per_moment = 0.0;
  expect_limit("complementarity", 1e-9, [&](double force) {
    const Eigen::VectorXd x =
        pose->meet(pose->x, {{Demand::row, pose->gap(), 0.05}, {Demand::variable, pose->force(), force}});
    pose->wish.tip_weight = 0.0;
    pose->wish.moment = x[pose->moment()];
    pose->assemble();
    pose->program->set_branch(0, Branch::separated);
    const Certificate c = pose->judge(x);
    EXPECT_NEAR(c.complementarity, force, 1e-13);
    return c;
  });
}

// Overlap under force is both: the obstacle is entered, and the gap is not zero.
TEST(CounterexampleCertificate, OverlapUnderForceIsPenetrationAndComplementarity) {
  const auto pose = braced_pose();
  const Certificate c = pose->judge(pose->meet(pose->x, {{Demand::row, pose->gap(), -2e-9}}));
  ASSERT_EQ(c.failures.size(), 2U);
  EXPECT_EQ(c.failures[0].find("penetration 2."), 0U) << c.failures[0];
  EXPECT_EQ(c.failures[1].find("complementarity 2.00e-09 is above 1e-09"), 0U) << c.failures[1];
}

TEST(CounterexampleCertificate, ClosestPoint) {
  const auto pose = braced_pose();
  for (const double sign : {1.0, -1.0}) {
    expect_limit("closest point", 1e-8, [&](double slope) {
      const Eigen::VectorXd x = pose->meet(pose->x, {{Demand::row, pose->closest(), sign * slope}});
      const PlainRod rod = plain(*pose, x);
      const double s = x[pose->place()];
      const Vec2 apart = rod.point(x, s) - Vec2{0.6, 0.0};
      const double angle = rod.angle(x, s);
      const Certificate c = pose->judge(x);
      EXPECT_NEAR(c.closest_point, std::abs(dot(apart, {std::cos(angle), std::sin(angle)})) / norm(apart), 1e-13);
      return c;
    });
  }
}

// At the tip the rod may run into the obstacle (t.n < 0) but not away from it: then a point before the tip is closer.
TEST(CounterexampleCertificate, ClosestPointAtTheTip) {
  Pose pose;
  pose.rod.actuators[0] = {0.0, 1.0, -4.0, 4.0};
  pose.add(std::make_unique<Circle>(Vec2{0.79, 0.48}, 0.1));
  pose.spec.contacts = {{0, true, 0}};
  pose.assemble();
  StartShape start = constant_curvature(0.9);
  start.moments = {1.2};
  start.forces = {0.3};
  const auto at_slope = [&](double slope) {
    Eigen::VectorXd x = pose.x;
    x = pose.meet(x, {{Demand::row, pose.closest(), slope}});
    pose.wish.moment = x[pose.moment()];
    pose.wish.moment_weight = 1.0;
    pose.assemble();
    return pose.judge(x);
  };
  pose.x = pose.program->start_from(start);
  pose.x = pose.meet(pose.x, {{Demand::row, pose.closest(), 0.0}});
  ASSERT_GT(pose.x[pose.force()], 0.01) << "the circle is to hold the tip";
  expect_limit("closest point", 1e-8, at_slope);
  EXPECT_TRUE(certified(at_slope(-2e-8)));
  EXPECT_TRUE(certified(at_slope(-0.1)));
  EXPECT_EQ(at_slope(-0.1).closest_point, 0.0);
}

// A contact with less force than 1e-9 does not hold the rod: nothing has to be closest there.
TEST(CounterexampleCertificate, WithoutForceNoPointHasToBeClosest) {
  const auto pose = braced_pose();
  for (const double force : {0.5e-9, 2e-9}) {
    const Eigen::VectorXd x = pose->meet(pose->x, {{Demand::row, pose->gap(), 0.05},
                                                   {Demand::row, pose->closest(), 0.1},
                                                   {Demand::variable, pose->force(), force}});
    pose->program->set_branch(0, Branch::separated);
    const Certificate c = pose->judge(x);
    EXPECT_NEAR(c.closest_point, force > 1e-9 ? 0.1 : 0.0, 1e-12) << force;
  }
}

TEST(CounterexampleCertificate, WhatIsNotFiniteIsNoPlan) {
  const auto pose = braced_pose();
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    for (Eigen::Index i = 0; i < pose->x.size(); ++i) {
      Eigen::VectorXd x = pose->x;
      x[i] = bad;
      const Certificate c = pose->judge(x);
      ASSERT_EQ(c.failures, std::vector<std::string>{"the plan is not finite"}) << "variable " << i;
      EXPECT_EQ(c.equilibrium, infinity) << "variable " << i;
      EXPECT_EQ(c.stability, -infinity) << "variable " << i;
    }
  }
}

}  // namespace
}  // namespace tendril::support
