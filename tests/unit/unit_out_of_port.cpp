// What is out of a port is the last part of the rod, unchanged.

#include <gtest/gtest.h>

#include <vector>

#include "tendril/error.hpp"
#include "tendril/scene.hpp"

namespace tendril {
namespace {

/// Two segments that vary along them, with every kind of actuator and load.
RodSpec varied() {
  RodSpec rod;
  rod.segments = {{0.06, 2e-3, 0.1, 1.0}, {0.14, 1e-3, 0.07, -2.0}};
  rod.segments[0].more_bending_stiffness = {-4e-4, 1e-4, 2e-4};
  rod.segments[1].more_bending_stiffness = {-3e-4};
  rod.segments[1].more_linear_density = {-0.02, 0.01};
  rod.segments[1].more_rest_curvature = {3.0, -1.0};
  for (SegmentSpec& s : rod.segments) {
    s.torsional_stiffness = 0.7 * s.bending_stiffness;
    s.thickness = 0.01;
  }
  rod.actuators = {{0.0, 0.2, -0.01, 0.02}, {0.05, 0.2, 0.0, 0.03}};
  rod.actuators[1].kind = ActuatorKind::tendon;
  rod.actuators[1].offset = {{0.05, 0.012}, {0.13, 0.004}, {0.2, 0.006}};
  rod.loads = {{0.03, 0.03, {0.0, -1.0}, 0.01}, {0.02, 0.15, {0.3, 0.0}, 0.0}, {0.16, 0.16, {0.1, 0.2}, 0.0}};
  return rod;
}

double at(double x, double start, const std::vector<double>& more) {
  double power = 1.0;
  for (const double c : more) start += c * (power *= x);
  return start;
}

struct Section {
  double stiffness, density, rest, torsion;
};

Section section(const RodSpec& rod, double s) {
  std::size_t i = 0;
  while (i + 1 < rod.segments.size() && s >= rod.segments[i].length) s -= rod.segments[i++].length;
  const SegmentSpec& own = rod.segments[i];
  const double x = s / own.length;
  const double stiffness = at(x, own.bending_stiffness, own.more_bending_stiffness);
  return {stiffness, at(x, own.linear_density, own.more_linear_density),
          at(x, own.rest_curvature, own.more_rest_curvature),
          own.torsional_stiffness * stiffness / own.bending_stiffness};
}

TEST(OutOfPort, SectionsAreThoseOfTheWholeRod) {
  const RodSpec whole = varied();
  for (const double length : {0.2, 0.17, 0.14, 0.09}) {
    const RodSpec out = out_of_port(whole, length);
    EXPECT_NEAR(out.length(), length, 1e-16);
    EXPECT_EQ(out.segments.size(), length > 0.14 ? 2U : 1U);
    for (double s = 0.003; s < length; s += 0.01) {
      const Section own = section(out, s);
      const Section expected = section(whole, s + 0.2 - length);
      EXPECT_NEAR(own.stiffness, expected.stiffness, 1e-17) << length << ' ' << s;
      EXPECT_NEAR(own.density, expected.density, 1e-15) << length << ' ' << s;
      EXPECT_NEAR(own.rest, expected.rest, 1e-14) << length << ' ' << s;
      EXPECT_NEAR(own.torsion, expected.torsion, 1e-17) << length << ' ' << s;
    }
  }
}

TEST(OutOfPort, ActuatorsAndLoadsAreCut) {
  const RodSpec out = out_of_port(varied(), 0.11);
  EXPECT_EQ(out.actuators[0].from, 0.0);
  EXPECT_NEAR(out.actuators[0].to, 0.11, 1e-16);
  EXPECT_EQ(out.actuators[0].maximum, 0.02);
  // The tendon is 8 mm off where the port is, and is pulled as hard as before.
  const ActuatorSpec& tendon = out.actuators[1];
  ASSERT_EQ(tendon.offset.size(), 3U);
  EXPECT_EQ(tendon.offset[0].arc_length, 0.0);
  EXPECT_NEAR(tendon.offset[0].offset, 0.008, 1e-17);
  EXPECT_NEAR(tendon.offset[1].arc_length, 0.04, 1e-16);
  EXPECT_NEAR(tendon.input_of(tendon.maximum), 0.03 / 0.012, 1e-14);
  // The load at 30 mm is inside.
  ASSERT_EQ(out.loads.size(), 2U);
  EXPECT_EQ(out.loads[0].from, 0.0);
  EXPECT_NEAR(out.loads[0].to, 0.06, 1e-16);
  EXPECT_NEAR(out.loads[1].from, 0.07, 1e-16);
  EXPECT_EQ(out.loads[1].from, out.loads[1].to);
}

TEST(OutOfPort, RefusesWhatTheRodHasNot) {
  const auto path = [](double length) -> std::string {
    RodSpec rod = varied();
    rod.actuators[0].to = 0.08;
    try {
      (void)out_of_port(rod, length);
    } catch (const SceneError& error) {
      return error.path();
    }
    return "";
  };
  EXPECT_EQ(path(0.2), "");
  EXPECT_EQ(path(0.201), "rod.insertion");
  EXPECT_EQ(path(0.0), "rod.insertion");
  EXPECT_EQ(path(0.1), "rod.actuator[0]");
}

}  // namespace
}  // namespace tendril
