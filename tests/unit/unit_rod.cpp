// The rod of a scene without dimensions: every quantity by hand, its knots, and its segments.

#include <gtest/gtest.h>

#include <cmath>

#include "rod/rod.hpp"
#include "scene/make_rod.hpp"
#include "tendril/problem.hpp"

namespace tendril {
namespace {

/// L = 0.5 m, EI0 = 0.02 N m^2: forces come in 0.08 N, moments in 0.04 N m, forces per length in 0.16 N/m.
Scene scene_of_half_a_metre() {
  Scene scene;
  scene.gravity = Vec2{-6.0, 8.0};
  scene.rod.segments = {{0.2, 0.02, 0.05, 3.0}, {0.3, 0.01, 0.04, -4.0}};
  scene.rod.actuators = {{0.0, 0.5, -0.02, 0.06, 0.0}, {0.1, 0.35, 0.0, 0.01, 0.0}};
  scene.rod.base_position = {0.3, -0.2};
  scene.rod.base_angle = 0.7;
  scene.tip_load = {0.012, {0.24, -0.4}};
  return scene;
}

struct Quantity {
  const char* name;
  double (*of)(const Rod&);
  double expected;
};

const Quantity quantities[] = {
    {"first_segment_begins", [](const Rod& r) { return r.segments[0].from; }, 0.0},
    {"first_segment_ends", [](const Rod& r) { return r.segments[0].to; }, 0.4},
    {"second_segment_begins", [](const Rod& r) { return r.segments[1].from; }, 0.4},
    {"second_segment_ends", [](const Rod& r) { return r.segments[1].to; }, 1.0},
    {"first_stiffness", [](const Rod& r) { return r.segments[0].stiffness; }, 1.0},
    {"second_stiffness", [](const Rod& r) { return r.segments[1].stiffness; }, 0.5},
    // rho |g| L^3 / EI0 = rho * 10 / 0.16
    {"first_weight", [](const Rod& r) { return r.segments[0].weight; }, 3.125},
    {"second_weight", [](const Rod& r) { return r.segments[1].weight; }, 2.5},
    {"first_rest_curvature", [](const Rod& r) { return r.segments[0].rest_curvature; }, 1.5},
    {"second_rest_curvature", [](const Rod& r) { return r.segments[1].rest_curvature; }, -2.0},
    {"actuator_begins", [](const Rod& r) { return r.actuators[1].from; }, 0.2},
    {"actuator_ends", [](const Rod& r) { return r.actuators[1].to; }, 0.7},
    {"actuator_of_the_whole_rod_ends", [](const Rod& r) { return r.actuators[0].to; }, 1.0},
    {"least_moment", [](const Rod& r) { return r.actuators[0].minimum; }, -0.5},
    {"largest_moment", [](const Rod& r) { return r.actuators[0].maximum; }, 1.5},
    {"another_largest_moment", [](const Rod& r) { return r.actuators[1].maximum; }, 0.25},
    {"base_x", [](const Rod& r) { return r.base.x; }, 0.6},
    {"base_y", [](const Rod& r) { return r.base.y; }, -0.4},
    {"base_angle", [](const Rod& r) { return r.base_angle; }, 0.7},
    {"gravity_x", [](const Rod& r) { return r.gravity.x; }, -0.6},
    {"gravity_y", [](const Rod& r) { return r.gravity.y; }, 0.8},
    // m |g| / 0.08
    {"payload", [](const Rod& r) { return r.payload; }, 1.5},
    {"tip_force_x", [](const Rod& r) { return r.tip_force.x; }, 3.0},
    {"tip_force_y", [](const Rod& r) { return r.tip_force.y; }, -5.0}};

TEST(Rod, EveryQuantityIsDividedByItsUnit) {
  const Scene scene = scene_of_half_a_metre();
  const Rod rod = make_rod(scene, scale_of(scene));
  // Rounded to 12 digits.
  for (const Quantity& q : quantities) {
    EXPECT_NEAR(q.of(rod), q.expected, 1e-11 * (1.0 + std::abs(q.expected))) << q.name;
  }
}

TEST(Rod, WithoutLoadsHasNone) {
  Scene scene = scene_of_half_a_metre();
  scene.gravity.reset();
  scene.tip_load = {};
  const Rod rod = make_rod(scene, scale_of(scene));
  EXPECT_FALSE(rod.has_gravity());
  EXPECT_FALSE(rod.has_tip_force());
  EXPECT_EQ(rod.gravity, Vec2{});
  EXPECT_EQ(rod.segments[0].weight, 0.0);
}

TEST(Rod, FeelsGravityIfItOrItsTipHasMass) {
  struct Case {
    Vec2 gravity;
    double first, second, payload;
    bool felt;
  };
  Rod rod;
  rod.segments.resize(2);
  for (const Case& c : {Case{{0.0, -1.0}, 1.0, 0.0, 0.0, true}, Case{{0.0, -1.0}, 0.0, 1.0, 0.0, true},
                        Case{{1.0, 0.0}, 0.0, 0.0, 1.0, true}, Case{{0.0, -1.0}, 0.0, 0.0, 0.0, false},
                        Case{{}, 1.0, 1.0, 1.0, false}}) {
    rod.gravity = c.gravity;
    rod.segments[0].weight = c.first;
    rod.segments[1].weight = c.second;
    rod.payload = c.payload;
    EXPECT_EQ(rod.has_gravity(), c.felt) << c.gravity.x << ' ' << c.first << ' ' << c.second << ' ' << c.payload;
  }
}

TEST(Rod, HasATipForceInEitherDirection) {
  Rod rod;
  for (const Vec2 force : {Vec2{1.0, 0.0}, Vec2{0.0, 1.0}}) {
    rod.tip_force = force;
    EXPECT_TRUE(rod.has_tip_force()) << force.x;
  }
}

TEST(Rod, AnActuatorCanDoNothingOnlyIfBothLimitsAreZero) {
  EXPECT_TRUE((Rod::Actuator{0.0, 1.0, 0.0, 0.0}.fixed_at_zero()));
  EXPECT_FALSE((Rod::Actuator{0.0, 1.0, 0.0, 1.0}.fixed_at_zero()));
  EXPECT_FALSE((Rod::Actuator{0.0, 1.0, -1.0, 0.0}.fixed_at_zero()));
  EXPECT_FALSE((Rod::Actuator{0.0, 1.0, 0.5, 0.5}.fixed_at_zero()));
}

TEST(Rod, IsCutWhereSegmentsAndActuatorsEnd) {
  Rod rod;
  rod.segments = {{0.0, 0.4, 1.0, 0.0, 0.0}, {0.4, 1.0, 2.0, 0.0, 0.0}};
  rod.actuators = {{0.3, 0.8}, {0.0, 0.4 + 1e-10}, {0.1, 1.0 - 1e-10}};
  // Two ends within 1e-9 are one, and so are an end and that of the rod.
  const std::vector<double> expected{0.0, 0.1, 0.3, 0.4, 0.8, 1.0};
  EXPECT_EQ(rod.fixed_knots(), expected);
  rod.actuators = {{0.0, 1.0}};
  EXPECT_EQ(rod.fixed_knots(), (std::vector<double>{0.0, 0.4, 1.0}));
}

TEST(Rod, IsCutWherePartsOfProfilesAndLoadsEnd) {
  Rod rod;
  rod.actuators = {{0.1, 0.9}};
  rod.actuators[0].profile = {{0.1, 0.5, {1.0, -1.0}}, {0.5, 0.9, {0.6}}};
  rod.loads = {{0.7, 0.7}, {0.2, 1.0}};
  EXPECT_EQ(rod.fixed_knots(), (std::vector<double>{0.0, 0.1, 0.2, 0.5, 0.7, 0.9, 1.0}));
}

// int p ds / EI with EI = 1 + s by hand; it needs no knots of the one at ends of the other.
TEST(Rod, AUnitOfAProfileTurnsSegmentsByWhatTheirStiffnessLetsIt) {
  Rod rod;
  rod.segments = {{0.0, 0.4, 1.0}, {0.4, 1.0, 1.4}};
  rod.segments[0].more_stiffness = {0.4};
  rod.segments[1].more_stiffness = {0.6};
  const auto turn = [&](const Rod::Actuator& a) {
    return a.compliance(rod.segments[0]) + a.compliance(rod.segments[1]);
  };
  Rod::Actuator actuator;
  EXPECT_NEAR(turn(actuator), std::log(2.0), 1e-14);
  actuator.profile = {{0.0, 1.0, {0.0, 1.0}}};
  EXPECT_NEAR(turn(actuator), 1.0 - std::log(2.0), 1e-14);
  actuator.from = 0.2;
  actuator.to = 0.9;
  actuator.profile = {{0.2, 0.7, {1.2, 1.0}}, {0.7, 0.9, {-3.4, -2.0}}};
  EXPECT_NEAR(turn(actuator), 0.5 - 2.0 * 0.2, 1e-14);
  rod.segments = {{0.0, 0.4, 1.0}, {0.4, 1.0, 0.5}};
  // int p ds from 0.2 to 0.4, from 0.4 to 0.7 and on.
  EXPECT_NEAR(turn(actuator), 0.26 + 2.0 * (0.465 - 0.72), 1e-14);
}

TEST(Rod, AtAJointTheLaterSegmentHolds) {
  Rod rod;
  rod.segments = {{0.0, 0.4, 1.0, 0.0, 0.0}, {0.4, 1.0, 2.0, 0.0, 0.0}};
  EXPECT_EQ(rod.segment_at(0.0).stiffness, 1.0);
  EXPECT_EQ(rod.segment_at(0.39).stiffness, 1.0);
  EXPECT_EQ(rod.segment_at(0.4).stiffness, 2.0);
  EXPECT_EQ(rod.segment_at(1.0).stiffness, 2.0);
  EXPECT_EQ(rod.segment_at(1.5).stiffness, 2.0);
}

TEST(Scale, OfASceneIsItsLengthAndItsFirstStiffness) {
  const Scale scale = scale_of(scene_of_half_a_metre());
  EXPECT_DOUBLE_EQ(scale.length, 0.5);
  EXPECT_DOUBLE_EQ(scale.stiffness, 0.02);
  EXPECT_DOUBLE_EQ(scale.force(), 0.08);
  EXPECT_DOUBLE_EQ(scale.moment(), 0.04);
}

}  // namespace
}  // namespace tendril
