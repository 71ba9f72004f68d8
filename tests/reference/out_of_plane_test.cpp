// Planar rods that may leave their plane: critical loads and margins of model.md section 12.

#include "certificate/out_of_plane.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>

#include "execute_support.hpp"
#include "tendril/coordinate_model.hpp"

namespace tendril::support {
namespace {

constexpr double digits = 1e-7;
constexpr double poisson = 0.3;

/// The margin of a straight rod under loads, by programs with so many pieces.
double margin_of_straight(Rod rod, int pieces) {
  const LegendreBasis model(6, pieces);
  PoseProgramSpec spec;
  spec.rod = &rod;
  spec.model = &model;
  spec.nodes = 24;
  PoseProgram program(spec);
  program.constraints(Eigen::VectorXd::Zero(program.variable_count()));
  Curve curve(program.chain().curve_tables());
  curve.follow(program.backbone());
  return OutOfPlane().margin(program, curve);
}

Rod round_rod(double torsion) {
  Rod rod;
  rod.segments[0].torsion = torsion;
  return rod;
}

TEST(OutOfPlane, AStraightColumnBucklesAtEulersLoad) {
  for (const int pieces : {1, 3}) {
    Rod rod = round_rod(1.0 / (1.0 + poisson));
    rod.tip_force = {-std::numbers::pi * std::numbers::pi / 4.0, 0.0};
    EXPECT_NEAR(margin_of_straight(rod, pieces), 0.0, digits);
    rod.tip_force = {};
    EXPECT_NEAR(margin_of_straight(rod, pieces), 1.0, 1e-13);
    // It is the stiffness out of the plane that counts.
    rod.segments[0].across = 2.0;
    rod.tip_force = {-std::numbers::pi * std::numbers::pi / 4.0, 0.0};
    EXPECT_NEAR(margin_of_straight(rod, pieces), 0.5, digits);
  }
}

/// The margin of a rod under loads, bent and stretched evenly, whether or not it is in equilibrium so.
double margin_of_bent(Rod rod, double stretch) {
  const LegendreBasis model(6, 2);
  if (stretch != 0.0) {
    rod.stretch_order = 1;
    rod.segments[0].axial = 1.0;
  }
  PoseProgramSpec spec;
  spec.rod = &rod;
  spec.model = &model;
  spec.nodes = 24;
  PoseProgram program(spec);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(program.variable_count());
  const int own = program.chain().bends() + program.chain().stretches();
  for (int j = 0; j < 2; ++j) {
    for (int k = 0; k < 6; ++k) x[j * own + k] = 0.3 / (1.0 + k + j);
    if (stretch != 0.0) x[j * own + 6] = stretch;
  }
  program.constraints(x);
  if (stretch != 0.0) {
    EXPECT_NEAR(program.backbone().stretch(1, 3), 1.0 + stretch, 1e-14);
  }
  Curve curve(program.chain().curve_tables());
  curve.follow(program.backbone());
  return OutOfPlane().margin(program, curve);
}

// Its forces do so much more work as it is longer.
TEST(OutOfPlane, ForcesWorkOnARodAsLongAsItIs) {
  for (const double stretch : {-0.3, 0.2}) {
    Rod rod = round_rod(0.6);
    rod.tip_force = {-0.7, 1.3};
    rod.gravity = {0.0, -1.0};
    rod.segments[0].weight = 2.0;
    const double margin = margin_of_bent(rod, stretch);
    EXPECT_GT(std::abs(margin - margin_of_bent(rod, 0.0)), 1e-3);
    rod.tip_force = (1.0 + stretch) * rod.tip_force;
    rod.segments[0].weight *= 1.0 + stretch;
    EXPECT_NEAR(margin, margin_of_bent(rod, 0.0), 1e-13);
  }
}

TEST(OutOfPlane, AStiffCantileverTipsOverSideways) {
  for (const int pieces : {1, 2, 5}) {
    for (const double torsion : {0.2, 1.0 / (1.0 + poisson), 3.0}) {
      Rod rod = round_rod(torsion);
      rod.tip_force = {0.0, 4.012599 * std::sqrt(torsion)};
      EXPECT_NEAR(margin_of_straight(rod, pieces), 0.0, digits) << torsion;
      rod.tip_force = {};
      rod.gravity = {0.0, -1.0};
      rod.segments[0].weight = 12.853763 * std::sqrt(torsion);
      EXPECT_NEAR(margin_of_straight(rod, pieces), 0.0, digits) << torsion;
    }
  }
}

TEST(OutOfPlane, WhatHangsOnTheRodCountsWhereverItIsStated) {
  Rod tip = round_rod(0.5);
  tip.tip_force = {0.3, -1.5};
  Rod loads = round_rod(0.5);
  loads.loads = {{1.0, 1.0, {0.3, -1.0}}, {1.0, 1.0, {}, 0.3}};
  loads.gravity = {0.0, -1.0};
  loads.payload = 0.2;
  EXPECT_NEAR(margin_of_straight(tip, 1), margin_of_straight(loads, 1), 1e-13);
  Rod line = round_rod(0.5);
  line.loads = {{0.0, 1.0, {0.0, -2.0}}};
  Rod weight = round_rod(0.5);
  weight.gravity = {0.0, -1.0};
  weight.segments[0].weight = 2.0;
  EXPECT_NEAR(margin_of_straight(line, 1), margin_of_straight(weight, 1), 1e-13);
  // A load halfway acts on half of the rod: the same as on a rod that ends there, which is as stiff as two of four.
  Rod half = round_rod(0.5);
  half.loads = {{0.5, 0.5, {0.0, -8.0}}};
  Rod whole = round_rod(0.5);
  whole.tip_force = {0.0, -2.0};
  EXPECT_NEAR(margin_of_straight(half, 2), margin_of_straight(whole, 1), 1e-10);
}

ForwardScene round_forward() {
  ForwardScene s;
  s.scene.rod.segments[0].torsional_stiffness = 1.0 / (1.0 + poisson);
  return s;
}

double margin_of(const Execution& e) {
  EXPECT_EQ(e.result.status, PlanStatus::solved) << e.result.message;
  return e.result.certificate.out_of_plane.value_or(-infinity);
}

TEST(OutOfPlane, ExecutedRodsHaveTheMarginsOfTheModel) {
  for (const double moment : {0.4, 2.0, -5.0}) {
    EXPECT_NEAR(margin_of(round_forward().run({moment})), 1.0, digits) << moment;
  }
  ForwardScene pulled = round_forward();
  pulled.scene.tip_load.force = {0.0, 2.0};
  EXPECT_NEAR(margin_of(pulled.run({0.0})), 0.69742736, digits);
  EXPECT_NEAR(margin_of(round_forward().weight(5.0).run({0.0})), 0.73474985, digits);
}

/// The margin once more, on powers of s and sums over the samples of a result, of a rod whose numbers are 1 beside its
/// torsion, under a weight, a moment and contacts: its moment is the curvature less that of its actuator.
double margin_of_samples(const Plan& plan, double torsion, double weight, double moment) {
  constexpr int powers = 8;
  Eigen::MatrixXd stiff = Eigen::MatrixXd::Zero(2 * powers, 2 * powers);
  Eigen::MatrixXd all = stiff;
  const std::vector<BackbonePoint>& line = plan.backbone;
  // Up to where its neighbours begin: halfway, or at a contact in between, where force and moment jump.
  std::vector<double> lengths(line.size(), 0.0);
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    double cut = 0.5 * (line[i].s + line[i + 1].s);
    for (const PlannedContact& c : plan.contacts) {
      if (c.arc_length > line[i].s && c.arc_length <= line[i + 1].s) cut = c.arc_length;
    }
    lengths[i] += cut - line[i].s;
    lengths[i + 1] += line[i + 1].s - cut;
  }
  for (std::size_t i = 0; i < line.size(); ++i) {
    const double s = line[i].s;
    const double h = lengths[i];
    const Vec2 t{std::cos(line[i].angle), std::sin(line[i].angle)};
    Vec2 force = (1.0 - s) * weight * Vec2{0.0, -1.0};
    for (const PlannedContact& c : plan.contacts) {
      if (c.arc_length > s) force = force + c.force * c.normal + c.tangential * c.tangent;
    }
    // Rows: w and w' at s by the powers of both components.
    Eigen::MatrixXd w = Eigen::MatrixXd::Zero(2, 2 * powers), slope = w;
    for (int p = 0; p < powers; ++p) {
      for (int axis = 0; axis < 2; ++axis) {
        w(axis, axis * powers + p) = std::pow(s, p + 1);
        slope(axis, axis * powers + p) = (p + 1) * std::pow(s, p);
      }
    }
    const Eigen::RowVectorXd twist = t.x * slope.row(0) + t.y * slope.row(1);
    const Eigen::RowVectorXd bend = -t.y * slope.row(0) + t.x * slope.row(1);
    const Eigen::MatrixXd elastic = torsion * twist.transpose() * twist + bend.transpose() * bend;
    const Eigen::MatrixXd turning = w.row(0).transpose() * slope.row(1) - w.row(1).transpose() * slope.row(0);
    const Eigen::MatrixXd pulled =
        (-t.y * w.row(0) + t.x * w.row(1)).transpose() * (force.y * w.row(0) - force.x * w.row(1));
    const Eigen::MatrixXd loads = (line[i].curvature - moment) * turning + pulled;
    stiff += h * elastic;
    all += h * (elastic - 0.5 * (loads + loads.transpose()));
  }
  return Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd>(all, stiff, Eigen::EigenvaluesOnly).eigenvalues()[0];
}

// Friction pushes on the surface of a body, whether its contact was given a ratio, slips or sticks.
TEST(OutOfPlane, TangentialForcesCountWithTheirCouples) {
  for (const double ratio : {-0.8, 0.0, 0.8}) {
    ForwardScene s;
    s.weight(6.0).circle(0.7, -0.22, 0.1);
    s.scene.rod.segments[0].torsional_stiffness = 0.5;
    s.scene.rod.segments[0].thickness = 0.2;
    ExecuteControl control;
    control.friction = {ratio};
    const Execution given = execute(s.scene, s.obstacles, {0.3}, control);
    ASSERT_EQ(given.result.contacts.size(), 1U);
    EXPECT_GT(given.result.contacts[0].force, 0.5);
    EXPECT_NEAR(margin_of(given), margin_of_samples(given.result, 0.5, 6.0, 0.3), 5e-3) << ratio;
  }
  ForwardScene s = braced_arm();
  s.scene.rod.segments[0].torsional_stiffness = 0.5 * s.scene.rod.segments[0].bending_stiffness;
  s.scene.rod.segments[0].thickness = 0.006;
  s.scene.contact.friction = 0.3;
  const Execution up = s.run({2e-3});
  const Execution sticks = s.run({1.99e-3}, &up.result);
  ASSERT_EQ(sticks.result.contacts.size(), 1U);
  const PlannedContact& c = sticks.result.contacts[0];
  ASSERT_TRUE(c.sticks);
  ASSERT_GT(std::abs(c.tangential), 0.01 * c.force);
  ExecuteControl control;
  control.friction = {c.tangential / c.force};
  control.start = &sticks.result;
  const Execution same = execute(s.scene, s.obstacles, {1.99e-3}, control);
  EXPECT_NEAR(same.result.tip_y, sticks.result.tip_y, 1e-9);
  EXPECT_NEAR(margin_of(sticks), margin_of(same), 1e-7);
}

// It may turn about its axis, buckled as it is.
TEST(OutOfPlane, ARodThatBuckledUnderThrustAloneIsNeutral) {
  for (const double thrust : {2.6, 4.0}) {
    ForwardScene s = round_forward();
    s.scene.tip_load.force = {-thrust, 0.0};
    EXPECT_NEAR(margin_of(s.run({0.0})), 0.0, digits) << thrust;
  }
}

TEST(OutOfPlane, AnExecutionThatBucklesSidewaysIsRefusedUnlessTheRobotIsGuided) {
  // A ribbon on its edge, under more than twice the force that 4.0126 sqrt(EI_o GJ) makes critical.
  ForwardScene s;
  s.scene.rod.segments[0].torsional_stiffness = 0.05;
  s.scene.rod.segments[0].out_of_plane_stiffness = 0.05;
  s.scene.tip_load.force = {0.0, 0.5};
  const Execution free = s.run({0.0});
  EXPECT_EQ(free.result.status, PlanStatus::unstable);
  EXPECT_NE(free.result.message.find("out of its plane"), std::string::npos) << free.result.message;
  EXPECT_LT(free.result.certificate.out_of_plane.value_or(infinity), -0.1);
  s.scene.guided_in_plane = true;
  const Execution guided = s.run({0.0});
  EXPECT_EQ(guided.result.status, PlanStatus::solved) << guided.result.message;
  EXPECT_EQ(guided.result.certificate.out_of_plane, free.result.certificate.out_of_plane);
  s.scene.rod.segments[0].torsional_stiffness = 0.0;
  const Execution unknown = s.run({0.0});
  EXPECT_FALSE(unknown.result.certificate.out_of_plane);
  EXPECT_EQ(unknown.result.coordinates, guided.result.coordinates);
}

}  // namespace
}  // namespace tendril::support
