// Rods whose sections vary, and loads along rods, against reference values and against what they must equal.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "execute_support.hpp"
#include "support/reference_table.hpp"

namespace tendril::support {
namespace {

/// A rod whose diameter falls along its length to 1 - taper of what it is at the base.
ForwardScene tapered(double taper, double weight) {
  ForwardScene s;
  s.weight(weight);
  SegmentSpec& rod = s.scene.rod.segments[0];
  const double a = taper;
  rod.more_bending_stiffness = {-4.0 * a, 6.0 * a * a, -4.0 * a * a * a, a * a * a * a};
  rod.more_linear_density = {-2.0 * a * weight, a * a * weight};
  return s;
}

TEST(ExecuteSections, TaperTable) {
  const ReferenceTable table("taper");
  for (std::size_t row = 0; row < table.rows(); ++row) {
    SCOPED_TRACE("row " + std::to_string(row));
    const ForwardScene s = tapered(table.value(row, "taper"), table.value(row, "weight"));
    const Execution e = s.run({table.value(row, "moment")});
    ASSERT_EQ(e.result.status, PlanStatus::solved) << e.result.message;
    EXPECT_NEAR(e.result.tip_x, table.value(row, "tip_x"), 1e-9);
    EXPECT_NEAR(e.result.tip_y, table.value(row, "tip_y"), 1e-9);
    EXPECT_NEAR(e.result.tip_angle, table.value(row, "tip_angle"), 1e-8);
    EXPECT_LT(e.result.certificate.moment_balance, 1e-8);
  }
}

// The same rod in two segments that continue each other.
TEST(ExecuteSections, ATaperMayBeCutAnywhere) {
  const double a = 0.5;
  const ForwardScene whole = tapered(a, 2.0);
  ForwardScene cut;
  cut.scene.gravity = Vec2{0.0, -1.0};
  const double at = 0.37;
  std::vector<SegmentSpec>& segments = cut.scene.rod.segments;
  segments.assign(2, {});
  for (const std::size_t i : {std::size_t{0}, std::size_t{1}}) {
    const double start = i == 0 ? 0.0 : at;
    const double length = i == 0 ? at : 1.0 - at;
    const double d = 1.0 - a * start;
    const double t = -a * length;  // the diameter is d + t x
    segments[i].length = length;
    segments[i].bending_stiffness = d * d * d * d;
    segments[i].more_bending_stiffness = {4.0 * d * d * d * t, 6.0 * d * d * t * t, 4.0 * d * t * t * t, t * t * t * t};
    segments[i].linear_density = 2.0 * d * d;
    segments[i].more_linear_density = {4.0 * d * t, 2.0 * t * t};
  }
  const Execution one = whole.run({0.3});
  const Execution two = cut.run({0.3});
  ASSERT_EQ(one.result.status, PlanStatus::solved) << one.result.message;
  ASSERT_EQ(two.result.status, PlanStatus::solved) << two.result.message;
  EXPECT_NEAR(one.result.tip_x, two.result.tip_x, 1e-9);
  EXPECT_NEAR(one.result.tip_y, two.result.tip_y, 1e-9);
  EXPECT_NEAR(one.result.certificate.stability, two.result.certificate.stability, 1e-6);
}

// A start that is bent has to be held on the way, and rest curvature is what a rod returns to.
TEST(ExecuteSections, AVaryingRestCurvatureIsTheShapeOfAnUnloadedRod) {
  ForwardScene s = tapered(0.4, 0.0);
  s.scene.rod.segments[0].rest_curvature = 0.8;
  s.scene.rod.segments[0].more_rest_curvature = {-1.0, 0.6};
  for (const double start : {0.0, 0.7}) {
    s.scene.start_tip_angle = start;
    const Execution e = s.run({0.0});
    ASSERT_EQ(e.result.status, PlanStatus::solved) << e.result.message;
    EXPECT_NEAR(e.result.tip_angle, 0.8 - 0.5 + 0.2, 1e-9);
  }
}

// At the tip it is the tip load.
TEST(ExecuteSections, ALoadAtTheEndIsATipLoad) {
  ForwardScene along, at_tip;
  for (ForwardScene* s : {&along, &at_tip}) s->weight(1.0);
  along.scene.rod.loads = {{1.0, 1.0, {0.2, -0.7}, 0.3}};
  at_tip.scene.tip_load = {0.3, {0.2, -0.7}};
  const Execution a = along.run({0.4});
  const Execution b = at_tip.run({0.4});
  ASSERT_EQ(a.result.status, PlanStatus::solved) << a.result.message;
  EXPECT_NEAR(a.result.tip_x, b.result.tip_x, 1e-11);
  EXPECT_NEAR(a.result.tip_y, b.result.tip_y, 1e-11);
}

// Weight is a force per length, and so is any other direction of it.
TEST(ExecuteSections, ASpreadForceIsWeight) {
  ForwardScene heavy, spread;
  heavy.weight(3.0);
  spread.scene.rod.loads = {{0.0, 0.6, {0.0, -3.0}, 0.0}, {0.6, 1.0, {0.0, -3.0}, 0.0}};
  for (ForwardScene* s : {&heavy, &spread}) s->circle(0.6, -0.16, 0.1);
  const Execution a = heavy.run({0.2});
  const Execution b = spread.run({0.2});
  ASSERT_EQ(a.result.status, PlanStatus::solved) << a.result.message;
  ASSERT_EQ(b.result.status, PlanStatus::solved) << b.result.message;
  ASSERT_EQ(a.result.contacts.size(), 1U);
  ASSERT_EQ(b.result.contacts.size(), 1U);
  EXPECT_NEAR(a.result.tip_x, b.result.tip_x, 1e-9);
  EXPECT_NEAR(a.result.tip_y, b.result.tip_y, 1e-9);
  EXPECT_NEAR(a.result.contacts[0].force, b.result.contacts[0].force, 1e-8);
  EXPECT_NEAR(a.result.certificate.stability, b.result.certificate.stability, 1e-6);
}

// Behind a point load the rod hangs freely: up to it, it is a shorter rod with a tip force.
TEST(ExecuteSections, APointLoadBendsWhatIsBeforeIt) {
  ForwardScene loaded, shorter;
  loaded.scene.rod.loads = {{0.6, 0.6, {0.3, -4.0}, 0.0}};
  shorter.scene.rod.segments[0].length = 0.6;
  shorter.scene.rod.actuators[0].to = 0.6;
  shorter.scene.tip_load.force = {0.3, -4.0};
  const Execution a = loaded.run({0.0});
  const Execution b = shorter.run({0.0});
  ASSERT_EQ(a.result.status, PlanStatus::solved) << a.result.message;
  ASSERT_EQ(b.result.status, PlanStatus::solved) << b.result.message;
  EXPECT_NEAR(a.result.tip_angle, b.result.tip_angle, 1e-9);
  EXPECT_NEAR(a.result.tip_x, b.result.tip_x + 0.4 * std::cos(b.result.tip_angle), 1e-9);
  EXPECT_NEAR(a.result.tip_y, b.result.tip_y + 0.4 * std::sin(b.result.tip_angle), 1e-9);
}

// A tendon in the skin of a tapered rod, which is bent by it alone: EI kappa = T h(s), h and the diameter fall alike.
TEST(ExecuteSections, ATendonInTheSkinOfATaperBendsItMoreTowardsTheTip) {
  const double a = 0.5;
  const double offset = 0.1;
  const double tension = 3.0;
  ForwardScene s = tapered(a, 0.0);
  ActuatorSpec& tendon = s.scene.rod.actuators[0];
  tendon.kind = ActuatorKind::tendon;
  tendon.minimum = 0.0;
  tendon.offset = {{0.0, offset}, {1.0, (1.0 - a) * offset}};
  const Execution e = s.run({tension * offset});
  ASSERT_EQ(e.result.status, PlanStatus::solved) << e.result.message;
  // Integrals of h / EI and of h^2 / EI, which go with (1 - a s)^-3 and (1 - a s)^-2.
  const double end = 1.0 - a;
  EXPECT_NEAR(e.result.tip_angle, tension * offset * (1.0 / (end * end) - 1.0) / (2.0 * a), 1e-9);
  EXPECT_NEAR(e.result.turns[0] * offset, tension * offset * offset * (1.0 / end - 1.0) / a, 1e-9);
  EXPECT_LT(e.result.certificate.moment_balance, 1e-8);
}

/// The braced arm in units of L and EI, around a rod with a body.
ForwardScene braced(double obstacle_radius) {
  ForwardScene s;
  s.weight(1.68);
  s.circle(0.6, 0.0, obstacle_radius);
  s.scene.start_tip_angle = 0.5;
  return s;
}

// A body of one thickness is an obstacle that is grown by its radius.
TEST(ExecuteSections, AnEvenBodyIsAGrownObstacle) {
  constexpr double radius = 0.05;
  ForwardScene thick = braced(0.08);
  thick.scene.rod.segments[0].thickness = 2.0 * radius;
  const ForwardScene grown = braced(0.08 + radius);
  for (const double moment : {0.3, 0.51, 0.8}) {
    const Execution a = thick.run({moment});
    const Execution b = grown.run({moment});
    ASSERT_EQ(a.result.status, PlanStatus::solved) << a.result.message;
    ASSERT_EQ(b.result.status, PlanStatus::solved) << b.result.message;
    ASSERT_EQ(a.result.contacts.size(), 1U);
    ASSERT_EQ(b.result.contacts.size(), 1U);
    EXPECT_NEAR(a.result.tip_x, b.result.tip_x, 1e-12);
    EXPECT_NEAR(a.result.tip_y, b.result.tip_y, 1e-12);
    EXPECT_NEAR(a.result.contacts[0].arc_length, b.result.contacts[0].arc_length, 1e-12);
    EXPECT_NEAR(a.result.contacts[0].force, b.result.contacts[0].force, 1e-12);
    EXPECT_NEAR(a.result.certificate.stability, b.result.certificate.stability, 1e-9);
    EXPECT_NEAR(a.result.certificate.contact_convexity, b.result.certificate.contact_convexity, 1e-9);
  }
}

/// The side of a body made of discs around every point of the backbone, which faces below.
std::vector<Vec2> lower_side(const Plan& plan, double radius, double slope, int points) {
  const std::vector<BackbonePoint>& b = plan.backbone;
  std::vector<Vec2> side;
  std::size_t i = 0;
  for (int k = 0; k <= points; ++k) {
    const double s = static_cast<double>(k) / points;
    while (i + 2 < b.size() && b[i + 1].s < s) ++i;
    // Hermite's interpolation of fifth order between two samples.
    const double h = b[i + 1].s - b[i].s;
    const double t = (s - b[i].s) / h;
    const auto curve = [&](Vec2 p, Vec2 v, Vec2 a, Vec2 q, Vec2 w, Vec2 c) {
      const double t3 = t * t * t, t4 = t3 * t, t5 = t4 * t;
      return (1 - 10 * t3 + 15 * t4 - 6 * t5) * p + (h * (t - 6 * t3 + 8 * t4 - 3 * t5)) * v +
             (h * h * 0.5 * (t * t - 3 * t3 + 3 * t4 - t5)) * a + (10 * t3 - 15 * t4 + 6 * t5) * q +
             (h * (-4 * t3 + 7 * t4 - 3 * t5)) * w + (h * h * 0.5 * (t3 - 2 * t4 + t5)) * c;
    };
    const auto tangent = [](const BackbonePoint& p) { return Vec2{std::cos(p.angle), std::sin(p.angle)}; };
    const auto bend = [&](const BackbonePoint& p) { return p.curvature * turned(tangent(p)); };
    const Vec2 at =
        curve(b[i].position(), tangent(b[i]), bend(b[i]), b[i + 1].position(), tangent(b[i + 1]), bend(b[i + 1]));
    const double angle = b[i].angle + t * h * (b[i].curvature + 0.5 * t * (b[i + 1].curvature - b[i].curvature));
    const Vec2 along{std::cos(angle), std::sin(angle)};
    const double r = radius + slope * s;
    side.push_back(at - (r * slope) * along - (r * std::sqrt(1.0 - slope * slope)) * turned(along));
  }
  return side;
}

// The sides of a tapered body touch the obstacle and do not enter it.
TEST(ExecuteSections, ATaperedBodyTouchesWithItsSide) {
  constexpr double radius = 0.06;
  constexpr double slope = -0.04;
  ForwardScene s = braced(0.08);
  s.scene.rod.segments[0].thickness = 2.0 * radius;
  s.scene.rod.segments[0].more_thickness = {2.0 * slope};
  const Execution e = s.run({0.51});
  ASSERT_EQ(e.result.status, PlanStatus::solved) << e.result.message;
  ASSERT_EQ(e.result.contacts.size(), 1U);
  EXPECT_LT(e.result.certificate.penetration, 1e-9);
  EXPECT_LT(e.result.certificate.closest_point, 1e-10);
  constexpr int points = 20000;
  const std::vector<Vec2> side = lower_side(e.result, radius, slope, points);
  double least = 1.0;
  double place = 0.0;
  for (std::size_t k = 0; k < side.size(); ++k) {
    const double gap = norm(side[k] - Vec2{0.6, 0.0}) - 0.08;
    if (gap >= least) continue;
    least = gap;
    place = static_cast<double>(k) / points;
  }
  // The angle is interpolated to 1e-7 between samples.
  EXPECT_NEAR(least, 0.0, 3e-8);
  EXPECT_NEAR(place, e.result.contacts[0].arc_length, 2e-3);
  // The force acts along the normal of the obstacle, which the backbone crosses at the slope of its side.
  const BackbonePoint& near = *std::min_element(
      e.result.backbone.begin(), e.result.backbone.end(), [&](const BackbonePoint& a, const BackbonePoint& b) {
        return std::abs(a.s - e.result.contacts[0].arc_length) < std::abs(b.s - e.result.contacts[0].arc_length);
      });
  EXPECT_NEAR(dot(e.result.contacts[0].normal, {std::cos(near.angle), std::sin(near.angle)}), slope, 1e-7);
}

}  // namespace
}  // namespace tendril::support
