// States that are in equilibrium and do not stay there, contacts that spread, and rows that hold a plan back from both.

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "core_support.hpp"
#include "counterexample_support.hpp"
#include "execute_support.hpp"
#include "obstacle/circle.hpp"
#include "obstacle/wall.hpp"

namespace tendril::support {
namespace {

constexpr double half_turn = 0.5 * std::numbers::pi;

/// A straight rod that stands under a load on its tip: its margin is 1 - load / euler exactly.
Certificate upright_under(double load) {
  Pose pose(14);
  pose.rod = upright_rod(0.0, load);
  pose.rod.actuators.clear();
  pose.assemble();
  return pose.judge(pose.x);
}

TEST(CounterexampleStability, AMarginOfHalfTheLimitIsRefusedAndTwiceTheLimitPasses) {
  EXPECT_TRUE(certified(upright_under((1.0 - 2e-6) * euler)));
  EXPECT_TRUE(refused(upright_under((1.0 - 0.5e-6) * euler), "unstable: the stability margin is", 0.5e-6, 1e-3));
}

TEST(CounterexampleStability, ASaddleIsRefusedWithItsMargin) {
  for (const double beyond : {1e-6, 1e-3, 0.5}) {
    EXPECT_TRUE(refused(upright_under((1.0 + beyond) * euler), "unstable: the stability margin is", -beyond, 1e-3));
  }
}

/// A heavy rod that stands upright beside a peg, which presses on it.
std::unique_ptr<Pose> leaning_on_peg(double weight, double force = 0.01) {
  auto pose = std::make_unique<Pose>(12);
  pose->rod.segments[0].weight = weight;
  pose->rod.gravity = {0.0, -1.0};
  pose->rod.base_angle = half_turn;
  pose->add(std::make_unique<Circle>(Vec2{-0.1, 0.6}, 0.1));
  pose->spec.contacts = {{0, false, 0}};
  pose->assemble();
  pose->x[pose->place()] = 0.6;
  pose->x = pose->meet(pose->x, {{Demand::variable, pose->force(), force}});
  return pose;
}

// Without the peg it would fall at a weight of 7.84 (model.md section 8); with it the next mode does, later.
TEST(CounterexampleStability, AContactHoldsTheRodAgainstOneModeOnly) {
  const auto held = leaning_on_peg(20.0);
  EXPECT_TRUE(certified(held->judge(held->x)));
  const auto falls = leaning_on_peg(60.0);
  const Certificate c = falls->judge(falls->x);
  ASSERT_LT(c.stability, -1e-2);
  EXPECT_TRUE(refused(c, "unstable: the stability margin is", c.stability, 1e-3));
}

// model.md section 7: a contact with no force is not projected.
TEST(CounterexampleStability, AContactWithoutForceHoldsNothing) {
  for (const double force : {0.5e-9, 2e-9}) {
    const auto pose = leaning_on_peg(20.0, force);
    const Certificate c = pose->judge(pose->x);
    if (force > 1e-9) {
      EXPECT_TRUE(certified(c));
    } else {
      ASSERT_LT(c.stability, -1.0);
      EXPECT_TRUE(refused(c, "unstable: the stability margin is", c.stability, 1e-3));
    }
  }
}

/// Pi less the work of the contact's force, which stays where the rod is nearest to the circle: what H is the second
/// derivative of (model.md section 7).
double held_energy(const PlainRod& rod, const Circle& circle, const Eigen::VectorXd& q, double moment, double force,
                   double s, bool at_tip) {
  const Vec2 center = circle.reference_point();
  for (int i = 0; i < 30 && !at_tip; ++i) {
    const Vec2 apart = rod.point(q, s) - center;
    const double distance = norm(apart);
    const double angle = rod.angle(q, s);
    const Vec2 tangent{std::cos(angle), std::sin(angle)};
    const double slope = dot(tangent, apart) / distance;
    const double bend = rod.curvature(q, s) * dot(turned(tangent), apart) / distance + (1.0 - slope * slope) / distance;
    s -= slope / bend;
    if (std::abs(slope) < 1e-15) break;
  }
  return rod.energy(q, moment) - force * (norm(rod.point(q, s) - center) - circle.rounding());
}

TEST(CounterexampleStability, TheSecondVariationIsTheSecondDifferenceOfTheEnergy) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (const bool at_tip : {false, true}) {
    Pose pose(6);
    pose.rod.segments[0].weight = 3.0;
    pose.rod.gravity = {0.0, -1.0};
    pose.rod.tip_force = {0.4, -0.3};
    pose.rod.base_angle = 0.2;
    const Circle circle({0.55, 0.6}, 0.2);
    pose.add(std::make_unique<Circle>(circle));
    pose.spec.contacts = {{0, at_tip, 0}};
    pose.spec.split = false;
    pose.assemble();
    const int n = pose.program->layout().coordinates;
    for (int trial = 0; trial < 4; ++trial) {
      StartShape start;
      const double a = unit(random);
      start.curvature = [a](double s) { return a + 0.8 * s; };
      start.moments = {unit(random)};
      start.forces = {2.0 + unit(random)};
      Eigen::VectorXd x = pose.program->start_from(start);
      if (!at_tip) {
        // To the nearest point, at the coordinates as they are.
        for (int i = 0; i < 30; ++i) {
          const double slope = pose.program->constraints(x)[pose.closest()];
          x[pose.place()] -= slope / pose.program->jacobian(x)(pose.closest(), pose.place());
        }
        ASSERT_NEAR(pose.program->constraints(x)[pose.closest()], 0.0, 1e-13);
      }
      const PlainRod rod = plain(pose, x);
      const Eigen::MatrixXd h = Certifier(pose.spec).second_variation(x);
      for (int direction = 0; direction < 3; ++direction) {
        const Eigen::VectorXd v = Eigen::VectorXd::NullaryExpr(n, [&] { return unit(random); });
        const auto energy = [&](double by) {
          return held_energy(rod, circle, x.head(n) + by * v, x[pose.moment()], x[pose.force()],
                             at_tip ? 1.0 : x[pose.place()], at_tip);
        };
        constexpr double step = 4e-3;
        const double second =
            (2.0 * (energy(3 * step) + energy(-3 * step)) - 27.0 * (energy(2 * step) + energy(-2 * step)) +
             270.0 * (energy(step) + energy(-step)) - 490.0 * energy(0.0)) /
            (180.0 * step * step);
        // Sixth-order differences: 4e-15 times eighth derivatives, and 1e-14 / 2e-5 of rounding.
        EXPECT_NEAR(v.dot(h * v), second, 2e-8 * (1.0 + std::abs(second))) << "at tip: " << at_tip;
      }
    }
  }
}

// The margin is the least eigenvalue against the bending energy: along its eigenvector the energy of the rod that no
// contact holds falls by that share of what bending gains.
TEST(CounterexampleStability, TheMarginIsTheShareOfTheBendingEnergyThatIsLeft) {
  for (const double weight : {3.0, 12.0}) {
    Pose pose(10);
    pose.rod = upright_rod(weight, 0.0);
    pose.assemble();
    const int n = pose.program->layout().coordinates;
    const PlainRod heavy = plain(pose, pose.x);
    PlainRod light = heavy;
    light.weight = 0.0;
    Eigen::MatrixXd h(n, n), k(n, n);
    constexpr double step = 1e-2;
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        const auto bent = [&](const PlainRod& rod, double a, double b) {
          return rod.energy(a * Eigen::VectorXd::Unit(n, i) + b * Eigen::VectorXd::Unit(n, j), 0.0);
        };
        const auto mixed = [&](const PlainRod& rod) {
          return (bent(rod, step, step) - bent(rod, step, -step) - bent(rod, -step, step) + bent(rod, -step, -step)) /
                 (4.0 * step * step);
        };
        h(i, j) = mixed(heavy);
        k(i, j) = mixed(light);
      }
    }
    const double margin = Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd>(h, k).eigenvalues()[0];
    // Second-order differences of an even energy: step^2 times fourth derivatives of the order of the weight.
    EXPECT_NEAR(pose.judge(pose.x).stability, margin, 2e-3) << weight;
    EXPECT_EQ(margin > 0.0, weight < 7.8373474389) << weight;
  }
}

// model.md section 7: a contact within 2e-5 L of the end has to hold the rod as one at the tip, too.
TEST(CounterexampleStability, AContactAtTheEndHasToHoldAsOneAtTheTip) {
  const Circle circle({0.9, 0.35}, 0.2);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-0.5, 0.5);
  int decided = 0;
  for (int trial = 0; trial < 20; ++trial) {
    Pose inside(5), outside(5);
    for (Pose* pose : {&inside, &outside}) {
      pose->add(std::make_unique<Circle>(circle));
      pose->spec.split = false;
      pose->spec.contacts = {{0, pose == &outside, 0}};
      pose->assemble();
    }
    for (int i = 0; i < 5; ++i) inside.x[i] = outside.x[i] = unit(random) / (1.0 + i);
    inside.x[inside.force()] = outside.x[outside.force()] = 30.0;
    const auto margin = [&](double from_end) {
      inside.x[inside.place()] = 1.0 - from_end;
      return inside.judge(inside.x).stability;
    };
    const double sliding = margin(1e-4);
    const double held = outside.judge(outside.x).stability;
    if (!(std::abs(sliding) < 1e3 && sliding > held + 0.015)) continue;
    ++decided;
    // 1e-5 of the length moves a margin by far less than the two differ.
    EXPECT_NEAR(margin(1.9e-5), held, 2e-3);
    EXPECT_NEAR(margin(2.1e-5), sliding, 2e-3);
  }
  EXPECT_GT(decided, 3);
}

/// A rod that bends down to a wall and stands on it at a point, beyond which it is an arc of curvature `moment`: d_ss
/// is the moment, exactly.
std::unique_ptr<Pose> standing_on_wall(double moment) {
  auto pose = std::make_unique<Pose>(12);
  pose->rod.base_angle = -0.3;
  pose->add(std::make_unique<Wall>(Vec2{0.0, -0.06}, Vec2{0.0, 1.0}));
  pose->spec.contacts = {{0, false, 0}};
  pose->assemble();
  StartShape start;
  start.curvature = [](double s) { return std::max(0.0, 1.0 - s / 0.6); };
  start.moments = {moment};
  start.arc_lengths = {0.6};
  start.forces = {1.67};
  pose->x = pose->meet(pose->program->start_from(start), {{Demand::variable, pose->moment(), moment}});
  EXPECT_GT(pose->x[pose->force()], 1.0) << "the wall is to hold the rod";
  EXPECT_LT(pose->program->constraints(pose->x).cwiseAbs().maxCoeff(), 1e-12);
  return pose;
}

TEST(CounterexampleStability, AContactSpreadsBelowTheLeastConvexity) {
  const std::string spreads = "contact spreads: the rod lies along the obstacle, a point contact does not hold it";
  for (const double d_ss : {2e-9, 1e-6, 1e-2}) {
    const auto pose = standing_on_wall(d_ss);
    const Certificate c = pose->judge(pose->x);
    EXPECT_TRUE(certified(c)) << d_ss;
    EXPECT_NEAR(c.contact_convexity, d_ss, 1e-11 + 1e-6 * d_ss);
  }
  for (const double d_ss : {0.5e-9, 0.0}) {
    const auto pose = standing_on_wall(d_ss);
    const Certificate c = pose->judge(pose->x);
    EXPECT_EQ(c.failures, std::vector<std::string>{spreads}) << d_ss;
    EXPECT_NEAR(c.contact_convexity, d_ss, 1e-11);
    EXPECT_EQ(c.stability, -infinity);
  }
}

// Bent away from the wall beyond the contact, the rod also enters it.
TEST(CounterexampleStability, AContactThatBendsIntoTheObstacleSpreads) {
  const auto pose = standing_on_wall(-1e-6);
  const Certificate c = pose->judge(pose->x);
  EXPECT_NEAR(c.contact_convexity, -1e-6, 1e-11);
  EXPECT_NE(std::find_if(c.failures.begin(), c.failures.end(),
                         [](const std::string& line) { return line.find("contact spreads") == 0; }),
            c.failures.end());
}

// A contact without force spreads nothing.
TEST(CounterexampleStability, OnlyContactsWithForceSpread) {
  Pose pose(4);
  pose.rod.actuators.clear();
  pose.add(std::make_unique<Wall>(Vec2{0.0, -0.1}, Vec2{0.0, 1.0}));
  pose.spec.contacts = {{0, false, 0}};
  pose.assemble();
  pose.program->set_branch(0, Branch::separated);
  pose.x[pose.place()] = 0.5;
  const Certificate c = pose.judge(pose.x);
  EXPECT_EQ(c.contact_convexity, infinity);
  EXPECT_NEAR(c.stability, 1.0, 1e-12);
}

/// The upright rod of weight 10 whose moment falls along stable states up to the fold of model.md section 8, stopped
/// where the margin is `margin`.
std::unique_ptr<Pose> before_the_fold(double margin) {
  auto pose = std::make_unique<Pose>(10);
  pose->rod = upright_rod(10.0, 0.0);
  pose->rod.actuators[0] = {0.0, 1.0, -3.0, 3.0};
  pose->wish.per_moment = 1.0;
  pose->assemble();
  Equilibrium at(upright_rod(10.0, 0.0), legendre(10), {});
  Certifier certifier(at.spec);
  StartShape start = constant_curvature(0.8);
  start.moments = {-0.2};
  Eigen::VectorXd from = at.program->start_from(start);
  // The margin grows with the lean.
  double low = 0.7272 - 0.01;
  double high = 0.7272 + 0.05;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    EXPECT_LE(at.solve_at_tip_angle(from, half_turn + middle), 1e-11);
    (certifier.stability(at.x) < margin ? low : high) = middle;
  }
  pose->x = at.x;
  EXPECT_NEAR(certifier.stability(at.x), margin, 1e-9);
  return pose;
}

TEST(CounterexampleStability, APlanThatIsHeldAtItsMarginStandsOnThatRow) {
  const auto pose = before_the_fold(1e-3);
  // The row dropped: the moment may fall on.
  const Certificate dropped = pose->judge(pose->x);
  EXPECT_GT(dropped.stationarity, 1e-5);
  EXPECT_TRUE(refused(dropped, "stationarity", dropped.stationarity));
  pose->spec.least_margin = 1e-3;
  pose->assemble();
  EXPECT_NEAR(pose->program->constraints(pose->x)[pose->program->layout().first_margin], 1e-3, 1e-9);
  EXPECT_TRUE(certified(pose->judge(pose->x)));
  // It holds a plan from falling below the margin, not above.
  pose->wish.per_moment = -1.0;
  pose->assemble();
  EXPECT_TRUE(refused(pose->judge(pose->x), "stationarity", dropped.stationarity));
}

TEST(CounterexampleStability, AtTwiceItsMarginTheRowHoldsNothing) {
  const auto pose = before_the_fold(2e-3);
  pose->spec.least_margin = 1e-3;
  pose->assemble();
  const Certificate c = pose->judge(pose->x);
  EXPECT_GT(c.stationarity, 1e-5);
  EXPECT_TRUE(refused(c, "stationarity", c.stationarity));
}

TEST(CounterexampleStability, APlanThatIsKeptFromSpreadingStandsOnThatRow) {
  const auto pose = standing_on_wall(1e-6);
  pose->wish.per_moment = 1.0;
  pose->assemble();
  const Certificate dropped = pose->judge(pose->x);
  EXPECT_GT(dropped.stationarity, 1e-3);
  EXPECT_TRUE(refused(dropped, "stationarity", dropped.stationarity));
  pose->spec.least_convexity = 1e-6;
  pose->assemble();
  for (int side = 0; side < 2; ++side) {
    EXPECT_NEAR(pose->program->constraints(pose->x)[pose->program->layout().first_convexity + side], 1e-6, 1e-10);
  }
  EXPECT_TRUE(certified(pose->judge(pose->x)));
  pose->wish.per_moment = -1.0;
  pose->assemble();
  EXPECT_TRUE(refused(pose->judge(pose->x), "stationarity", dropped.stationarity));
  const auto farther = standing_on_wall(2e-6);
  farther->wish.per_moment = 1.0;
  farther->spec.least_convexity = 1e-6 - 1e-8;
  farther->assemble();
  EXPECT_TRUE(refused(farther->judge(farther->x), "stationarity", dropped.stationarity));
}

}  // namespace
}  // namespace tendril::support
