// Planar rods that may leave their plane: critical loads and margins of model.md section 12.

#include "certificate/out_of_plane.hpp"

#include <gtest/gtest.h>

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
