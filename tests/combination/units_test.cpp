// The same arm written in other units, or made of another size, is the same dimensionless problem and the same plan.

#include <cmath>
#include <cstdio>

#include "support.hpp"

namespace tendril::combination {
namespace {

/// Names of units as scenes write them, and their sizes in SI.
struct UnitSystem {
  const char* length_name;
  double length;
  const char* force_name;
  double force;
  const char* mass_name;
  double mass;
};

constexpr UnitSystem metre{"m", 1.0, "N", 1.0, "kg", 1.0};
constexpr UnitSystem millimetre{"mm", 1e-3, "N", 1.0, "g", 1e-3};
constexpr UnitSystem inch{"inch", 0.0254, "lbf", 4.4482216152605, "lb", 0.45359237};

/// Size of an arm, SI. The braced arm by default.
struct Size {
  double length = 0.1;
  double stiffness = 4.9e-4;
  double gravity = 9.81;
};

/// The scene brace.toml of another size, with every quantity in `units` and `digits` significant digits.
std::string brace_text(const UnitSystem& units, int digits, const Size& size = {}) {
  const Size own;
  const double length = size.length / own.length;
  const double force = size.stiffness / own.stiffness / (length * length);
  const auto quantity = [&](double si, double unit, const std::string& name) {
    char text[40];
    std::snprintf(text, sizeof text, "%.*g", digits, si / unit);
    return "\"" + std::string(text) + " " + name + "\"";
  };
  const std::string l = units.length_name;
  const std::string f = units.force_name;
  const auto meters = [&](double si) { return quantity(si * length, units.length, l); };
  // The weight per length is what counts: 84 g/m at 9.81 m/s^2.
  const double density = 0.084 * 9.81 / size.gravity * force / length;
  return "gravity = [\"0 " + l + "/s^2\", " + quantity(-size.gravity, units.length, l + "/s^2") +
         "]\n[rod]\nlength = " + meters(0.1) + "\nbending_stiffness = " +
         quantity(size.stiffness, units.force * units.length * units.length, f + " " + l + "^2") +
         "\nlinear_density = " + quantity(density, units.mass / units.length, std::string(units.mass_name) + "/" + l) +
         "\n[[rod.actuator]]\nlimit = " + quantity(2.5e-3 * force * length, units.force * units.length, f + " " + l) +
         "\n[coordinates]\norder = 6\n[start]\ntip_angle = 0.5\n[[obstacle]]\nshape = \"circle\"\ncenter = [" +
         meters(0.06) + ", " + meters(0.0) + "]\nradius = " + meters(0.008) +
         "\n[contact]\nmax_force = " + quantity(1.0 * force, units.force, f) + "\n[target]\nposition = [" +
         meters(0.097) + ", " + meters(0.02) +
         "]\n[[objective]]\nplugin = \"tip_pose\"\nweight = 100\n[[objective]]\nplugin = \"actuation_effort\"\nweight "
         "= 1e-4\n";
}

/// Not one bit differs in what is computed without units.
void expect_same_dimensionless(const Plan& a, const Plan& b) {
  ASSERT_TRUE(certified(a));
  ASSERT_TRUE(certified(b));
  EXPECT_EQ(a.coordinates, b.coordinates);
  EXPECT_EQ(a.objective, b.objective);
  EXPECT_EQ(a.terms, b.terms);
  EXPECT_EQ(a.solver.iterations, b.solver.iterations);
  EXPECT_EQ(a.solver.evaluations.values, b.solver.evaluations.values);
  EXPECT_EQ(a.solver.evaluations.first_derivatives, b.solver.evaluations.first_derivatives);
  EXPECT_EQ(a.certificate.equilibrium, b.certificate.equilibrium);
  EXPECT_EQ(a.certificate.stability, b.certificate.stability);
  ASSERT_EQ(a.modes.size(), b.modes.size());
  for (std::size_t i = 0; i < a.modes.size(); ++i) EXPECT_EQ(a.modes[i].outcome, b.modes[i].outcome);
}

/// `scale` is the size of b's lengths, `force` of b's forces, relative to a's.
void expect_scaled(const Plan& a, const Plan& b, double length, double force) {
  // Numbers of a scene are read to 12 digits of the dimensionless problem; 15 digits of text leave 1e-15.
  const auto near = [](double value, double expected, double least, const char* what) {
    EXPECT_NEAR(value, expected, 1e-9 * std::max(std::abs(expected), least)) << what;
  };
  near(b.tip_x, length * a.tip_x, 0.0, "tip x");
  near(b.tip_y, length * a.tip_y, 0.0, "tip y");
  near(b.tip_angle, a.tip_angle, 0.0, "tip angle");
  ASSERT_TRUE(a.target_error && b.target_error);
  near(*b.target_error, length * *a.target_error, 0.0, "target error");
  ASSERT_EQ(a.moments.size(), b.moments.size());
  for (std::size_t i = 0; i < a.moments.size(); ++i) near(b.moments[i], length * force * a.moments[i], 0.0, "moment");
  ASSERT_EQ(a.contacts.size(), b.contacts.size());
  for (std::size_t i = 0; i < a.contacts.size(); ++i) {
    near(b.contacts[i].arc_length, length * a.contacts[i].arc_length, 0.0, "arc length");
    near(b.contacts[i].force, force * a.contacts[i].force, 0.0, "force");
    near(b.contacts[i].point.x, length * a.contacts[i].point.x, 0.0, "contact x");
    near(b.contacts[i].point.y, length * a.contacts[i].point.y, 0.0, "contact y");
  }
  ASSERT_EQ(a.backbone.size(), b.backbone.size());
  for (std::size_t i = 0; i < a.backbone.size(); ++i) {
    near(b.backbone[i].x, length * a.backbone[i].x, length * 0.1, "backbone x");
    near(b.backbone[i].y, length * a.backbone[i].y, length * 0.1, "backbone y");
    near(b.backbone[i].curvature, a.backbone[i].curvature / length, 1.0 / length, "curvature");
  }
}

class Units : public testing::TestWithParam<int> {};

TEST_P(Units, ChangeNoBitOfTheDimensionlessPlan) {
  const Plan shipped = plan(scene("brace"));
  for (const UnitSystem& units : {metre, millimetre, inch}) {
    SCOPED_TRACE(units.length_name);
    const Plan other = plan(scene_from_text(brace_text(units, GetParam())));
    expect_same_dimensionless(shipped, other);
    expect_scaled(shipped, other, 1.0, 1.0);
  }
}

INSTANTIATE_TEST_SUITE_P(Digits, Units, testing::Values(15, 17),
                         [](const testing::TestParamInfo<int>& digits) { return std::to_string(digits.param); });

TEST(Size, ChangesNoBitOfTheDimensionlessPlan) {
  const Plan shipped = plan(scene("brace"));
  for (const Size& size :
       {Size{1e-3, 1e-12, 9.81}, Size{100.0, 1e6, 9.81}, Size{100.0, 1e6, 1.62}, Size{1e-3, 1e6, 9.81}}) {
    for (const UnitSystem& units : {metre, inch}) {
      SCOPED_TRACE(std::to_string(size.length) + " m in " + units.length_name);
      const Plan other = plan(scene_from_text(brace_text(units, 17, size)));
      expect_same_dimensionless(shipped, other);
      const double length = size.length / 0.1;
      expect_scaled(shipped, other, length, size.stiffness / 4.9e-4 / (length * length));
    }
  }
}

}  // namespace
}  // namespace tendril::combination
