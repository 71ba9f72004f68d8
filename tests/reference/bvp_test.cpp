#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "support/reference_table.hpp"
#include "support/rod_bvp.hpp"

namespace tendril::support {
namespace {

// The printed values are rounded, and the two methods behind them agree "to the digits shown": one unit of the last
// digit.
void expect_printed(const ReferenceTable& table, std::size_t row, const std::string& column, double value) {
  EXPECT_NEAR(value, table.value(row, column), 2.0 * table.rounding(row, column)) << column << " of row " << row;
}

// The shooting method is meant to be exact to rounding; 1e-12 leaves room for the conditioning of the problem.
constexpr double kExact = 1e-12;

TEST(BvpReference, TipMomentGivesACircularArc) {
  for (double m : {-4.0, -0.7, 1.0, 3.0, 6.0, 12.0}) {
    const BvpSolution s = solve(RodBvp{}, {m});
    EXPECT_NEAR(s.tip_x, std::sin(m) / m, kExact) << m;
    EXPECT_NEAR(s.tip_y, (1.0 - std::cos(m)) / m, kExact) << m;
    EXPECT_NEAR(s.tip_angle, m, 1e1 * kExact) << m;
  }
}

TEST(BvpReference, TipForceTable) {
  const ReferenceTable table("tip_force");
  for (std::size_t i = 0; i < table.rows(); ++i) {
    RodBvp rod;
    rod.tip_force = {0.0, table.value(i, "alpha")};
    BvpGuess guess;
    guess.curvature = 1.0;
    const BvpSolution s = solve(rod, {0.0}, {}, guess);
    expect_printed(table, i, "theta", s.tip_angle);
    expect_printed(table, i, "u", 1.0 - s.tip_x);
    expect_printed(table, i, "w", s.tip_y);
  }
}

// Energy integral of the elastica without weight: kappa^2/2 + F . t is constant along the rod.
TEST(BvpReference, TipForceKeepsTheEnergyIntegral) {
  RodBvp rod;
  rod.tip_force = {-1.5, 7.0};
  BvpGuess guess;
  guess.curvature = 1.5;
  const BvpSolution s = solve(rod, {0.4}, {}, guess);
  const auto integral = [&](double at) {
    const BvpState z = s.at(at);
    return 0.5 * z.curvature * z.curvature + rod.tip_force.x * std::cos(z.angle) + rod.tip_force.y * std::sin(z.angle);
  };
  for (double at : {0.1, 0.37, 0.5, 0.93, 1.0}) EXPECT_NEAR(integral(at), integral(0.0), 1e1 * kExact) << at;
  EXPECT_NEAR(s.at(1.0).curvature, 0.4, kExact);
}

TEST(BvpReference, SelfWeightTable) {
  const ReferenceTable table("self_weight");
  for (std::size_t i = 0; i < table.rows(); ++i) {
    RodBvp rod;
    rod.sections[0].density = table.value(i, "weight");
    rod.gravity = {0.0, -1.0};
    const double moment = table.value(i, "moment");
    BvpGuess guess;
    guess.curvature = moment;
    const BvpSolution s = solve(rod, {moment}, {}, guess);
    expect_printed(table, i, "x", s.tip_x);
    expect_printed(table, i, "y", s.tip_y);
    expect_printed(table, i, "theta", s.tip_angle);
  }
}

TEST(BvpReference, CircleContactTable) {
  const ReferenceTable table("circle_contact");
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const BvpContact circle{{table.value(i, "x"), table.value(i, "y")}, table.value(i, "radius")};
    const double moment = table.value(i, "moment");
    BvpGuess guess;
    guess.curvature = 0.7;
    guess.arc_lengths = {circle.center.x};
    guess.forces = {0.0};
    const BvpSolution s = follow(RodBvp{}, {0.7}, {moment}, {circle}, guess);
    expect_printed(table, i, "force", s.forces[0]);
    expect_printed(table, i, "arc_length", s.arc_lengths[0]);
    expect_printed(table, i, "tip_x", s.tip_x);
    expect_printed(table, i, "tip_y", s.tip_y);
    const BvpState at = s.at(s.arc_lengths[0]);
    EXPECT_NEAR(std::hypot(at.x - circle.center.x, at.y - circle.center.y), circle.radius, kExact);
  }
}

// At moment 0.7 the free arc does not reach the circles, so the closed contact would have to pull.
TEST(BvpReference, UntouchedCirclesWouldHaveToPull) {
  const ReferenceTable table("circle_contact");
  for (std::size_t i : {std::size_t{0}, std::size_t{2}}) {
    const BvpContact circle{{table.value(i, "x"), table.value(i, "y")}, table.value(i, "radius")};
    BvpGuess guess;
    guess.curvature = 0.7;
    guess.arc_lengths = {0.6};
    guess.forces = {0.0};
    EXPECT_LT(solve(RodBvp{}, {0.7}, {circle}, guess).forces[0], 0.0);
  }
}

/// The braced arm of the reference data, in SI units.
struct BracedArm {
  RodBvp rod;
  BvpContact circle{{0.06, 0.0}, 0.008};
  BracedArm() {
    rod.sections = {{0.1, 4.9e-4, 0.084, 0.0}};
    rod.actuators = {{0.0, 0.1}};
    rod.gravity = {0.0, -9.81};
  }
  BvpSolution brace(double moment) const {
    BvpGuess guess;
    guess.curvature = 4.0;
    guess.arc_lengths = {0.06};
    guess.forces = {0.07};
    return solve(rod, {moment}, {circle}, guess);
  }
};

TEST(BvpReference, BracedArmTable) {
  const ReferenceTable table("braced_arm");
  const BracedArm arm;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const BvpSolution s = arm.brace(table.value(i, "moment"));
    expect_printed(table, i, "arc_length", s.arc_lengths[0]);
    expect_printed(table, i, "force", s.forces[0]);
    expect_printed(table, i, "tip_x", s.tip_x);
    expect_printed(table, i, "tip_y", s.tip_y);
    expect_printed(table, i, "tip_angle", s.tip_angle);
  }
}

// model.md section 6: positions to 1e-3 mm, arc length and force to the digits shown there.
TEST(BvpReference, WorkedNumbersOfTheArm) {
  const BracedArm arm;
  const BvpSolution free = solve(arm.rod, {2.5e-3});
  EXPECT_NEAR(free.tip_x, 99.569e-3, 0.6e-6);
  EXPECT_NEAR(free.tip_y, 4.509e-3, 0.6e-6);
  const BvpSolution braced = arm.brace(2.5e-3);
  EXPECT_NEAR(braced.tip_x, 96.703e-3, 0.6e-6);
  EXPECT_NEAR(braced.tip_y, 22.002e-3, 0.6e-6);
  EXPECT_NEAR(braced.arc_lengths[0], 58.62167e-3, 0.6e-8);
  EXPECT_NEAR(braced.forces[0], 61.78405e-3, 0.6e-8);
}

// A contact that needs no force is where the free rod just touches.
TEST(BvpReference, ArmClearsThePegFromAbout4Point9NewtonMillimetres) {
  const BracedArm arm;
  EXPECT_GT(arm.brace(4.8e-3).forces[0], 0.0);
  EXPECT_LT(arm.brace(5.0e-3).forces[0], 0.0);
}

// Without loads every stretch between section and actuator ends is a circular arc of its own curvature.
TEST(BvpReference, SectionsAndSpannedMomentsGiveArcs) {
  RodBvp rod;
  rod.sections = {{0.4, 1.0, 0.0, 0.5}, {0.6, 2.5, 0.0, -1.0}};
  rod.actuators = {{0.0, 0.7}, {0.7, 1.0}, {0.2, 0.5}};
  rod.base = {0.3, -0.2};
  rod.base_angle = 0.25;
  const BvpSolution s = solve(rod, {1.2, -2.0, 0.9});
  struct Arc {
    double length, curvature;
  };
  const Arc arcs[] = {{0.2, 0.5 + 1.2},
                      {0.2, 0.5 + 1.2 + 0.9},
                      {0.1, -1.0 + (1.2 + 0.9) / 2.5},
                      {0.2, -1.0 + 1.2 / 2.5},
                      {0.3, -1.0 - 2.0 / 2.5}};
  double x = rod.base.x, y = rod.base.y, angle = rod.base_angle, at = 0.0;
  for (const Arc& a : arcs) {
    EXPECT_NEAR(s.at(at + 0.5 * a.length).curvature, a.curvature, kExact);
    x += (std::sin(angle + a.curvature * a.length) - std::sin(angle)) / a.curvature;
    y -= (std::cos(angle + a.curvature * a.length) - std::cos(angle)) / a.curvature;
    angle += a.curvature * a.length;
    at += a.length;
  }
  EXPECT_NEAR(s.tip_x, x, kExact);
  EXPECT_NEAR(s.tip_y, y, kExact);
  EXPECT_NEAR(s.tip_angle, angle, kExact);
}

// Turning base and gravity together turns the solution.
TEST(BvpReference, GravityMayPointAnywhere) {
  RodBvp down;
  down.sections = {{0.5, 1.0, 3.0, 0.0}, {0.5, 0.6, 1.0, 0.0}};
  down.payload = 0.7;
  down.gravity = {0.0, -1.0};
  const BvpSolution a = solve(down, {1.0});
  const double turn = 2.1;
  RodBvp turned = down;
  turned.base_angle = turn;
  turned.gravity = {std::sin(turn), -std::cos(turn)};
  const BvpSolution b = solve(turned, {1.0});
  EXPECT_NEAR(b.tip_x, std::cos(turn) * a.tip_x - std::sin(turn) * a.tip_y, kExact);
  EXPECT_NEAR(b.tip_y, std::sin(turn) * a.tip_x + std::cos(turn) * a.tip_y, kExact);
  EXPECT_NEAR(b.tip_angle, a.tip_angle + turn, kExact);
}

TEST(BvpReference, PayloadIsATipForce) {
  RodBvp mass;
  mass.gravity = {0.0, -1.0};
  mass.payload = 2.0;
  RodBvp force;
  force.tip_force = {0.0, -2.0};
  EXPECT_NEAR(solve(mass, {0.3}).tip_y, solve(force, {0.3}).tip_y, kExact);
}

// A tip contact acts like the dead force that it exerts.
TEST(BvpReference, TipContactIsATipForceAlongTheNormal) {
  BvpContact circle{{0.2, 0.77}, 0.3, true};
  BvpGuess guess;
  guess.curvature = 1.8;
  guess.arc_lengths = {1.0};
  guess.forces = {0.1};
  const BvpSolution touched = solve(RodBvp{}, {2.0}, {circle}, guess);
  const double dx = touched.tip_x - circle.center.x;
  const double dy = touched.tip_y - circle.center.y;
  EXPECT_NEAR(std::hypot(dx, dy), circle.radius, kExact);
  EXPECT_GT(touched.forces[0], 0.0);
  RodBvp pushed;
  pushed.tip_force = {touched.forces[0] * dx / circle.radius, touched.forces[0] * dy / circle.radius};
  BvpGuess same_shape;
  same_shape.angle = touched.guess().angle;
  const BvpSolution same = solve(pushed, {2.0}, {}, same_shape);
  EXPECT_NEAR(same.tip_x, touched.tip_x, kExact);
  EXPECT_NEAR(same.tip_y, touched.tip_y, kExact);
  EXPECT_NEAR(same.tip_angle, touched.tip_angle, kExact);
}

// Global balance of the whole rod: base force and moment carry weight, tip load and both contact forces.
TEST(BvpReference, TwoContactsBalanceTheWholeRod) {
  constexpr double kWeight = 20.0;
  RodBvp rod;
  rod.sections[0].density = kWeight;
  rod.gravity = {0.0, -1.0};
  // The rod sags over a peg onto a floor.
  const std::vector<BvpContact> contacts{{{0.4, -0.12}, 0.1}, {{0.0, -0.1}, 0.0, false, {0.0, 1.0}}};
  BvpGuess guess;
  guess.angle = [](double s) { return s < 0.75 ? -0.25 * std::sin(s * 4.19) : 2.0 * (s - 0.75); };
  guess.arc_lengths = {0.4, 0.75};
  guess.forces = {5.0, 5.0};
  const BvpSolution s = solve(rod, {1.0}, contacts, guess);
  const BvpState base = s.at(0.0);
  double fx = 0.0, fy = -kWeight, moment = 0.0;
  constexpr int kPoints = 2000;
  for (int i = 0; i < kPoints; ++i) moment -= kWeight / kPoints * s.at((i + 0.5) / kPoints).x;
  const BvpState pegged = s.at(s.arc_lengths[0]);
  const Point normals[] = {{(pegged.x - 0.4) / 0.1, (pegged.y + 0.12) / 0.1}, {0.0, 1.0}};
  EXPECT_NEAR(std::hypot(normals[0].x, normals[0].y), 1.0, 1e1 * kExact);
  EXPECT_NEAR(s.at(s.arc_lengths[1]).y, -0.1, kExact);
  for (std::size_t k = 0; k < 2; ++k) {
    const BvpState at = s.at(s.arc_lengths[k]);
    const Point n = normals[k];
    EXPECT_GT(s.forces[k], 0.0) << k;
    EXPECT_NEAR(std::cos(at.angle) * n.x + std::sin(at.angle) * n.y, 0.0, 1e1 * kExact) << k;
    fx += s.forces[k] * n.x;
    fy += s.forces[k] * n.y;
    moment += s.forces[k] * (at.x * n.y - at.y * n.x);
  }
  EXPECT_NEAR(base.force.x, fx, 1e2 * kExact);
  EXPECT_NEAR(base.force.y, fy, 1e2 * kExact);
  // The midpoint rule over the weight is good to about 1e-7.
  EXPECT_NEAR(base.moment, moment, 1e-6);
}

TEST(BvpReference, ReportsWhenNewtonCannotConverge) {
  // The circle lies out of reach of the rod.
  BvpGuess guess;
  guess.arc_lengths = {0.9};
  guess.forces = {1.0};
  EXPECT_THROW(solve(RodBvp{}, {0.0}, {BvpContact{{3.0, 0.5}, 0.1}}, guess), BvpError);
  EXPECT_THROW(solve(RodBvp{}, {}), BvpError);
  EXPECT_THROW(solve(RodBvp{}, {0.0}, {BvpContact{{0.5, 0.5}, 0.1}}), BvpError);
}

/// A root of f between a and b by bisection and secants (Illinois).
double root(const std::function<double(double)>& f, double a, double b) {
  double fa = f(a), fb = f(b);
  EXPECT_LT(fa * fb, 0.0);
  for (int i = 0; i < 100 && std::abs(b - a) > 1e-14; ++i) {
    const double c = (a * fb - b * fa) / (fb - fa);
    const double fc = f(c);
    if (fc * fb < 0.0) {
      a = b;
      fa = fb;
    } else {
      fa *= 0.5;
    }
    b = c;
    fb = fc;
    if (fc == 0.0) break;
  }
  return b;
}

RodBvp upright_bvp(double weight) {
  RodBvp rod;
  rod.base_angle = std::acos(0.0);
  rod.sections[0].density = weight;
  rod.gravity = {0.0, -1.0};
  return rod;
}

TEST(BvpReference, MomentRateIsTheDerivativeOfTheMoment) {
  const RodBvp rod = upright_bvp(5.0);
  const double step = 1e-4;
  const auto at = [&](double angle) {
    BvpGuess guess;
    guess.curvature = -0.8;
    return solve_tip_angle(rod, {0.0}, 0, angle, {}, guess);
  };
  const BvpSolution s = at(0.8);
  // Central differences of a smooth function with step 1e-4: 1e-8 of truncation, 1e-9 of rounding.
  EXPECT_NEAR(s.moment_rate, (at(0.8 + step).moments[0] - at(0.8 - step).moments[0]) / (2.0 * step), 1e-7);
  EXPECT_NEAR(solve(rod, s.moments, {}, s.guess()).tip_angle, 0.8, 1e1 * kExact);
}

// A rod buckles where its tip turns without a moment (model.md section 8).
TEST(BvpReference, EulerLoad) {
  const auto stiffness = [](double load) {
    RodBvp rod = upright_bvp(0.0);
    rod.tip_force = {0.0, -load};
    return solve_tip_angle(rod, {0.0}, 0, rod.base_angle).moment_rate;
  };
  const double critical = root(stiffness, 2.0, 3.0);
  EXPECT_NEAR(critical, std::acos(0.0) * std::acos(0.0), 1e-11);
  EXPECT_NEAR(critical, 2.4674011003, 0.6e-10);
}

TEST(BvpReference, CriticalSelfWeight) {
  const auto stiffness = [](double weight) {
    return solve_tip_angle(upright_bvp(weight), {0.0}, 0, std::acos(0.0)).moment_rate;
  };
  EXPECT_NEAR(root(stiffness, 7.0, 8.5), 7.8373474389, 0.6e-10);
}

// Snap-through: the moment has an extremum over the tip angle (model.md section 8, other branch by symmetry).
TEST(BvpReference, SnapThroughOfAnUprightRod) {
  struct Fold {
    double weight, moment, lean;
  };
  for (const Fold& fold : {Fold{10.0, -0.24017224, 0.7272}, Fold{12.0, -0.59941729, 0.8253}}) {
    const RodBvp rod = upright_bvp(fold.weight);
    const auto at = [&](double lean) {
      BvpGuess guess;
      guess.angle = [&rod, lean](double s) { return rod.base_angle + lean * std::sin(std::acos(0.0) * s); };
      return solve_tip_angle(rod, {0.0}, 0, rod.base_angle + lean, {}, guess);
    };
    const double lean = root([&](double l) { return at(l).moment_rate; }, fold.lean - 0.1, fold.lean + 0.1);
    EXPECT_NEAR(at(lean).moments[0], fold.moment, 0.6e-8) << fold.weight;
    EXPECT_NEAR(lean, fold.lean, 0.6e-4) << fold.weight;
  }
}

// A hanging rod is stiff and heavy: shooting over the whole length would lose exp(sqrt(weight)) digits.
TEST(BvpReference, HeavyRodKeepsItsAccuracy) {
  RodBvp rod;
  rod.gravity = {0.0, -1.0};
  BvpGuess guess;
  guess.angle = [](double s) { return -s; };
  for (double weight : {5.0, 20.0, 80.0, 300.0}) {
    rod.sections[0].density = weight;
    guess = solve(rod, {0.0}, {}, guess).guess();
  }
  rod.sections[0].density = 1000.0;
  const BvpSolution coarse = solve(rod, {0.0}, {}, guess);
  BvpOptions fine;
  fine.intervals = 40;
  const BvpSolution again = solve(rod, {0.0}, {}, guess, fine);
  EXPECT_NEAR(coarse.tip_x, again.tip_x, kExact);
  EXPECT_NEAR(coarse.tip_y, again.tip_y, kExact);
  EXPECT_NEAR(coarse.at(1.0).curvature, 0.0, 1e-9);
}

}  // namespace
}  // namespace tendril::support
