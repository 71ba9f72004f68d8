// Certified depth and closest approaches on circular arcs, whose distance to a point is known exactly.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "certificate/clearance.hpp"
#include "core_support.hpp"
#include "obstacle/circle.hpp"
#include "obstacle/part.hpp"
#include "obstacle/rounded_hull.hpp"
#include "obstacle/wall.hpp"
#include "support/random_outline.hpp"

namespace tendril::support {
namespace {

using std::numbers::pi;

/// A rod bent to an arc of angle `turn`, cut into pieces that a random shape of the same program would have.
struct Arc {
  explicit Arc(double angle, int order = 6, int pieces = 1, const Rod& rod = {})
      : turn(angle),
        basis(order, pieces),
        chain(rod, basis, {}, suggested_nodes(order, angle)),
        backbone(chain, {}, 0.0),
        curve(std::make_shared<CurveTables>(chain.rule())) {
    Eigen::VectorXd q = Eigen::VectorXd::Zero(chain.coordinate_count());
    for (int j = 0; j < pieces; ++j) q[j * order] = turn / pieces;
    backbone.move(q, {});
    curve.follow(backbone);
  }
  Vec2 at(double s) const {
    return {std::sin(turn * s) / turn, 2.0 * std::sin(0.5 * turn * s) * std::sin(0.5 * turn * s) / turn};
  }
  Vec2 tangent(double s) const { return {std::cos(turn * s), std::sin(turn * s)}; }
  Vec2 center() const { return {0.0, 1.0 / turn}; }

  /// Distance of a point to the arc, and where: the foot lies on the ray from the centre, or at an end.
  double distance(Vec2 point, double* place = nullptr) const {
    double best = norm(point - at(0.0));
    double where = 0.0;
    if (norm(point - at(1.0)) < best) {
      best = norm(point - at(1.0));
      where = 1.0;
    }
    const Vec2 ray = point - center();
    // The angle of the ray, as the angle of the backbone there.
    double angle = turn > 0.0 ? std::atan2(ray.x, -ray.y) : std::atan2(-ray.x, ray.y);
    if (angle * turn < 0.0) angle += turn > 0.0 ? 2.0 * pi : -2.0 * pi;
    for (; std::abs(angle) <= std::abs(turn); angle += turn > 0.0 ? 2.0 * pi : -2.0 * pi) {
      const double s = angle / turn;
      const double foot = std::abs(norm(ray) - 1.0 / std::abs(turn));
      if (foot < best) {
        best = foot;
        where = s;
      }
    }
    if (place != nullptr) *place = where;
    return best;
  }

  double turn;
  LegendreBasis basis;
  Chain chain;
  Backbone backbone;
  Curve curve;
};

// model.md section 4: the depth reported is never less than the true one, and sharp to 1e-10.
void expect_depth(const Arc& arc, Vec2 center, double radius) {
  const Circle circle(center, radius);
  const double exact = std::max(0.0, radius - arc.distance(center));
  const double depth = certified_depth(arc.curve, circle);
  // Distances up to 1e3 are rounded to 1e-13.
  const double rounding = 4e-16 * (1.0 + radius + norm(center));
  EXPECT_GE(depth, exact - rounding) << "centre " << center.x << ' ' << center.y << " radius " << radius << " turn "
                                     << arc.turn;
  EXPECT_LE(depth, exact + 1e-9) << "centre " << center.x << ' ' << center.y << " radius " << radius << " turn "
                                 << arc.turn;
}

TEST(CoreClearanceReference, DepthOfCirclesOfAllSizes) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (const double turn : {-3.0, -0.4, 0.02, 1.0, 2.5, 7.0}) {
    for (const int pieces : {1, 3}) {
      const Arc arc(turn, 6, pieces);
      for (const double radius : {1e-6, 1e-4, 1e-2, 0.15, 1.0, 30.0, 1e3}) {
        for (int trial = 0; trial < 6; ++trial) {
          const double s = unit(random);
          const double side = trial % 2 == 0 ? 1.0 : -1.0;
          // From well outside through touching to the centre on the rod.
          const double depths[] = {-0.1 * radius, 0.0, 1e-9, 1e-4 * radius, 0.3 * radius, radius};
          const double offset = radius - std::min(radius, depths[trial]);
          expect_depth(arc, arc.at(s) + (side * offset) * turned(arc.tangent(s)), radius);
        }
      }
    }
  }
}

// Any shape: the exact depth of an arc, by sampling that leaves less than 1e-7 and a search within the deepest cell.
double sampled_depth(const Arc& arc, const Obstacle& shape, double thick = 0.0, double taper = 0.0) {
  constexpr int samples = 4000;
  double deepest = 0.0;
  const auto depth = [&](double s) { return thick - taper * s - shape.at(arc.at(s)).distance; };
  for (int i = 0; i <= samples; ++i) deepest = std::max(deepest, depth(static_cast<double>(i) / samples));
  for (int i = 0; i <= samples; ++i) {
    const double s = static_cast<double>(i) / samples;
    if (depth(s) < deepest - 2.0 / samples) continue;
    double low = std::max(0.0, s - 1.0 / samples);
    double high = std::min(1.0, s + 1.0 / samples);
    for (int step = 0; step < 80; ++step) {
      const double a = low + (high - low) / 3.0;
      const double b = high - (high - low) / 3.0;
      (depth(a) < depth(b) ? low : high) = depth(a) < depth(b) ? a : b;
    }
    deepest = std::max(deepest, depth(0.5 * (low + high)));
  }
  return deepest;
}

TEST(CoreClearanceReference, DepthOfWallsCapsulesAndPolygons) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const auto offset = [&](double size) { return size * Vec2{2.0 * unit(random) - 1.0, 2.0 * unit(random) - 1.0}; };
  int deep = 0;
  for (const double turn : {-3.0, 0.02, 2.5}) {
    const Arc arc(turn, 6, 2);
    for (int trial = 0; trial < 60; ++trial) {
      const Vec2 near = arc.at(unit(random)) + offset(0.1);
      const double size = std::pow(10.0, -2.0 + 2.0 * unit(random));
      std::unique_ptr<Obstacle> shape;
      if (trial % 3 == 0) {
        shape = std::make_unique<Wall>(near, offset(1.0));
      } else if (trial % 3 == 1) {
        shape = std::make_unique<RoundedHull>(std::vector<Vec2>{near, near + offset(size)}, 0.2 * size);
      } else {
        // Mostly core: the rod goes right through it.
        const double start = unit(random);
        std::vector<Vec2> corners;
        for (int i = 0; i < 5; ++i) {
          const double angle = 2.0 * pi * (start + 0.2 * i);
          corners.push_back(near + size * Vec2{std::cos(angle), 0.7 * std::sin(angle)});
        }
        shape = std::make_unique<RoundedHull>(corners, 1e-3 * size);
      }
      const double exact = sampled_depth(arc, *shape);
      const double depth = certified_depth(arc.curve, *shape);
      deep += exact > 1e-3 * size ? 1 : 0;
      EXPECT_GE(depth, exact - 1e-14) << trial << " turn " << turn;
      EXPECT_LE(depth, exact + 1e-9) << trial << " turn " << turn;
    }
  }
  EXPECT_GT(deep, 50);
}

// 200 bodies of any outline, some with holes, from far away through touching to right through the core, beside rods
// that are lines, or thick and tapered. Inside of the core the bound is sharp to a thousandth of the depth.
TEST(CoreClearanceReference, DepthOfBodiesOfAnyOutline) {
  std::mt19937 random(12);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  int touching = 0;
  int deep = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const double thick = trial % 2 == 0 ? 0.0 : 0.01 + 0.03 * unit(random);
    const double taper = 0.8 * thick * unit(random);
    Rod rod;
    rod.segments[0].radius = thick;
    if (thick > 0.0) rod.segments[0].more_radius = {-taper};
    const Arc arc(trial % 3 == 0 ? -3.0 : trial % 3 == 1 ? 0.02 : 2.5, 6, 2, rod);
    const double size = std::pow(10.0, -1.5 + 1.5 * unit(random));
    const double rounding = size * (trial % 5 == 0 ? 1e-3 : 0.2);
    const Vec2 center = arc.at(unit(random)) + (1.2 * size * (2.0 * unit(random) - 1.0)) * turned(arc.tangent(0.5));
    std::vector<ClosedLine> holes;
    if (trial % 4 == 0) holes.push_back(random_outline(random, center, 0.4 * size));
    const Part part(boundary_of({random_outline(random, center, size)}, holes), rounding);
    const double exact = sampled_depth(arc, part, thick, taper);
    const double depth = certified_depth(arc.curve, part);
    (exact > rounding ? deep : touching) += exact > 0.0 ? 1 : 0;
    EXPECT_GE(depth, exact - 1e-14) << trial;
    // Sides of a notch make several valleys between two samples, of which the search finds one.
    constexpr double between_samples = 0.5 / 4000;
    EXPECT_LE(depth, exact > rounding ? 1.001 * exact + between_samples : exact + 1e-9) << trial;
    // What comes nearest is found by sampling, too.
    for (const ClosestApproach& at : closest_approaches(arc.curve, part, infinity)) {
      EXPECT_GE(at.distance, -exact - 1e-9) << trial;
      EXPECT_LE(-at.distance, depth + 1e-14) << trial;
    }
  }
  EXPECT_GT(touching, 20);
  EXPECT_GT(deep, 50);
}

// Small pegs and notched bodies beside the rod: what is passed over far away hides no approach below the level. Without
// a level nothing is passed over.
TEST(CoreClearanceReference, EveryApproachBelowTheLevelIsFoundWithoutALookAtAllPlaces) {
  std::mt19937 random(21);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  constexpr double level = 0.02;
  std::size_t approaches = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const Arc arc(trial % 3 == 0 ? -3.0 : trial % 3 == 1 ? 0.02 : 5.0, 6, 1 + trial % 2);
    const Vec2 center = arc.at(unit(random)) + (0.3 * (2.0 * unit(random) - 1.0)) * turned(arc.tangent(0.5));
    std::unique_ptr<Obstacle> shape;
    if (trial % 4 == 0) {
      shape = std::make_unique<Part>(boundary_of({random_outline(random, center, 0.2)}, {}), 0.01);
    } else {
      shape = std::make_unique<Circle>(center, std::pow(10.0, -3.0 + 2.0 * unit(random)));
    }
    std::vector<ClosestApproach> every = closest_approaches(arc.curve, *shape, infinity);
    std::erase_if(every, [](const ClosestApproach& a) { return a.distance > level; });
    const std::vector<ClosestApproach> found = closest_approaches(arc.curve, *shape, level);
    ASSERT_EQ(found.size(), every.size()) << trial;
    for (std::size_t i = 0; i < found.size(); ++i) EXPECT_EQ(found[i].arc_length, every[i].arc_length) << trial;
    approaches += found.size();
  }
  EXPECT_GT(approaches, 100U);
}

TEST(CoreClearanceReference, DepthAtTheEndsOfTheRod) {
  const Arc arc(1.0);
  for (const double radius : {1e-5, 0.05, 2.0}) {
    for (const double depth : {-0.01 * radius, 1e-7 * radius, 0.5 * radius}) {
      expect_depth(arc, arc.at(1.0) + (radius - depth) * arc.tangent(1.0), radius);
      expect_depth(arc, arc.at(0.0) - (radius - depth) * arc.tangent(0.0), radius);
    }
  }
}

// The tip against bodies of hundreds of sides, on a side, over an edge and in a notch: the bound is never below the
// depth of the tip itself, and sharp where it is shallow. Many bodies: each is bounded on its own.
TEST(CoreClearanceReference, DepthAtTheTipInBodiesOfManySides) {
  std::mt19937 random(31);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  int touched = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const Arc arc(trial % 2 == 0 ? 1.0 : -2.0);
    constexpr double rounding = 1e-3;
    const double radius = 0.05 + 0.1 * unit(random);
    const double turn = 2.0 * pi * unit(random);
    ClosedLine line;
    for (int i = 0; i < 400; ++i) {
      const double angle = turn + 2.0 * pi * i / 400;
      line.push_back((i % 2 == 0 ? 1.0 : 0.97) * radius * Vec2{std::cos(angle), std::sin(angle)});
    }
    // Ahead of the tip, so that it alone comes near; no deeper than the rounding.
    const Vec2 tip = arc.at(1.0);
    const double depth = rounding * (2.0 * unit(random) - 1.0);
    const auto body_at = [&](double away) {
      ClosedLine there = line;
      for (Vec2& p : there) p = p + tip + away * arc.tangent(1.0);
      return Part({there}, rounding);
    };
    double near = 0.5 * radius;
    double far = 2.0 * radius;
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (near + far);
      (body_at(middle).at(tip).distance < -depth ? near : far) = middle;
    }
    const Part body = body_at(far);
    const double exact = std::max(0.0, -body.at(tip).distance);
    EXPECT_NEAR(exact, std::max(0.0, depth), 1e-12) << trial;
    const double bound = certified_depth(arc.curve, body);
    EXPECT_GE(bound, exact - 1e-15) << trial;
    EXPECT_LE(bound, exact + 1e-9) << trial;
    const std::vector<ClosestApproach> approaches = closest_approaches(arc.curve, body, infinity);
    EXPECT_TRUE(std::any_of(approaches.begin(), approaches.end(), [](const auto& a) { return a.arc_length == 1.0; }));
    touched += depth > 0.0 ? 1 : 0;
  }
  EXPECT_GT(touched, 15);
}

// The hardest case: every point of the rod is equally near, outside and inside of the bend.
TEST(CoreClearanceReference, DepthOfACircleThatTheRodFollows) {
  for (const double turn : {0.5, 2.0, 5.0}) {
    const Arc arc(turn);
    for (const double depth : {-1e-3, -1e-8, 1e-8, 1e-3}) expect_depth(arc, arc.center(), 1.0 / turn + depth);
  }
}

// A penetration narrower than any spacing of samples.
TEST(CoreClearanceReference, DepthOfAGrazedCircleIsNotMissed) {
  const Arc arc(2.0);
  for (const double depth : {1e-8, 1e-7, 1e-6}) {
    for (const double radius : {1e-6, 1e-3, 0.1, 100.0}) {
      const double s = 0.3217;
      expect_depth(arc, arc.at(s) + (radius - std::min(depth, radius)) * turned(arc.tangent(s)), radius);
      expect_depth(arc, arc.at(s) - (radius - std::min(depth, radius)) * turned(arc.tangent(s)), radius);
    }
  }
}

TEST(CoreClearanceReference, DepthUnderAHalfPlane) {
  for (const double turn : {-2.0, 0.3, 1.5, 6.0}) {
    const Arc arc(turn);
    for (const double direction : {0.1, 1.3, 2.9, 4.4, 5.7}) {
      const Vec2 n{std::cos(direction), std::sin(direction)};
      // Lowest where the tangent is along the plane, or at an end.
      double low = std::min(dot(arc.at(0.0), n), dot(arc.at(1.0), n));
      for (int k = -4; k <= 4; ++k) {
        const double s = (direction + 0.5 * pi + k * pi) / turn;
        if (s > 0.0 && s < 1.0) low = std::min(low, dot(arc.at(s), n));
      }
      for (const double depth : {-0.1, -1e-9, 1e-9, 1e-3, 0.2}) {
        const HalfPlane plane((low + depth) * n, n);
        const double exact = std::max(0.0, depth);
        EXPECT_GE(certified_depth(arc.curve, plane), exact - 1e-15) << turn << ' ' << direction;
        EXPECT_LE(certified_depth(arc.curve, plane), exact + 1e-9) << turn << ' ' << direction;
      }
    }
  }
}

/// A circle that answers with no number in one of its ways.
class NoNumber : public Circle {
 public:
  NoNumber(bool core, bool rounding) : Circle({0.5, 2.0}, 0.1), core_(core), rounding_(rounding) {}
  double core_distance(Vec2 point) const override { return core_ ? std::nan("") : Circle::core_distance(point); }
  double rounding() const override { return rounding_ ? std::nan("") : Circle::rounding(); }

 private:
  bool core_, rounding_;
};

TEST(CoreClearanceReference, NoNumberIsNoClearance) {
  const Arc arc(1.0);
  EXPECT_EQ(certified_depth(arc.curve, NoNumber(false, false)), 0.0);
  EXPECT_EQ(certified_depth(arc.curve, NoNumber(true, false)), infinity);
  EXPECT_EQ(certified_depth(arc.curve, NoNumber(false, true)), infinity);
}

// Against dense sampling on shapes that no formula knows: the certified depth is an upper bound and not much more.
TEST(CoreClearanceReference, DepthOfRandomShapesBoundsWhatSamplingFinds) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const LegendreBasis basis(8);
  const Rod rod;
  const Chain chain(rod, basis, {}, 40);
  Backbone backbone(chain, {0.1, -0.2}, 0.4);
  Curve curve(std::make_shared<CurveTables>(chain.rule()));
  for (int trial = 0; trial < 20; ++trial) {
    Eigen::VectorXd q(8);
    for (int i = 0; i < 8; ++i) q[i] = 4.0 * unit(random) / (1.0 + i * i);
    backbone.move(q, {});
    curve.follow(backbone);
    const Vec2 near = curve.position(0, 0.5 + 0.4 * unit(random));
    constexpr double radius = 0.12;
    const Circle circle(near + Vec2{0.1 * unit(random), 0.1 * unit(random)}, radius);
    constexpr int samples = 20000;
    double deepest = 0.0;
    for (int i = 0; i <= samples; ++i) {
      deepest = std::max(deepest, -circle.at(curve.position(0, static_cast<double>(i) / samples)).distance);
    }
    const double depth = certified_depth(curve, circle);
    EXPECT_GE(depth, deepest - 1e-15);
    // Between samples at most half a spacing away the distance c to the centre falls by no more than the spacing, and
    // where the rod bends less than the circle by its square over c.
    const double spacing = 0.5 / samples;
    EXPECT_LE(depth, deepest + std::min(spacing, spacing * spacing / (radius - deepest)) + 1e-9);
  }
}

TEST(CoreClearanceReference, ClosestApproachIsThePlaceAndDistanceOfTheArc) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (const double turn : {-2.0, 0.5, 3.0}) {
    const Arc arc(turn, 6, 2);
    for (const double radius : {1e-6, 1e-3, 0.1, 10.0, 1e3}) {
      for (int trial = 0; trial < 6; ++trial) {
        const double s = 0.1 + 0.8 * unit(random);
        const double side = trial % 2 == 0 ? 1.0 : -1.0;
        const double gap = (trial / 2 - 1) * 0.3 * std::min(radius, 0.1);
        const Vec2 center = arc.at(s) + (side * (radius + gap)) * turned(arc.tangent(s));
        double place = 0.0;
        const double exact = arc.distance(center, &place) - radius;
        const auto found = closest_approaches(arc.curve, Circle(center, radius), 0.05);
        ASSERT_FALSE(found.empty()) << radius << ' ' << gap;
        const auto best = std::min_element(
            found.begin(), found.end(),
            [](const ClosestApproach& a, const ClosestApproach& b) { return a.distance < b.distance; });
        EXPECT_NEAR(best->distance, exact, 1e-12 * (1.0 + radius)) << radius << ' ' << gap;
        // A minimum of a distance that is known to 1e-16 (1 + radius) is found to the root of that over its curvature.
        EXPECT_NEAR(best->arc_length, place, 1e-8 + 4.0 * std::sqrt(1e-15 * (1.0 + radius))) << radius << ' ' << gap;
        EXPECT_NEAR(arc.chain.start(best->piece, {}) + best->sigma * arc.chain.length(best->piece, {}),
                    best->arc_length, 1e-14);
      }
    }
  }
}

TEST(CoreClearanceReference, EveryValleyBelowTheLevelIsFound) {
  // A closed loop and a half: two turns of the rod pass by a small circle beside the centre, at the same angle.
  const Arc arc(3.0 * pi, 10);
  const double radius = 1.0 / arc.turn;
  const Vec2 center = arc.center() + Vec2{0.0, -0.6 * radius};
  const Circle circle(center, 0.1 * radius);
  const auto found = closest_approaches(arc.curve, circle, 0.5 * radius);
  ASSERT_EQ(found.size(), 2u);
  // The base itself, and one turn later.
  EXPECT_NEAR(found[0].arc_length, 0.0, 1e-7);
  EXPECT_NEAR(found[1].arc_length, 2.0 / 3.0, 1e-7);
  for (const ClosestApproach& a : found) EXPECT_NEAR(a.distance, 0.3 * radius, 1e-13);
  EXPECT_TRUE(closest_approaches(arc.curve, circle, 0.29 * radius).empty());
}

TEST(CoreClearanceReference, ExchangeSeesWhatTheCertificateSees) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const Arc arc(2.0, 6, 3);
  for (int trial = 0; trial < 40; ++trial) {
    const double radius = std::pow(10.0, -3.0 + 1.5 * (unit(random) + 1.0));
    const double s = 0.5 + 0.45 * unit(random);
    const Circle circle(arc.at(s) + (radius * (1.0 - 0.1 * unit(random))) * turned(arc.tangent(s)), radius);
    double deepest = 0.0;
    for (const ClosestApproach& a : closest_approaches(arc.curve, circle, 0.0))
      deepest = std::max(deepest, -a.distance);
    EXPECT_NEAR(certified_depth(arc.curve, circle), deepest, 1e-9) << trial;
  }
}

// A body is as deep in an obstacle as the deepest of the discs that it is made of.
TEST(Clearance, ABodyIsAsDeepAsItsDiscs) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> d(-1.0, 1.0);
  Rod rod;
  rod.segments[0].radius = 0.05;
  for (const std::vector<double>& more : {std::vector<double>{}, {-0.04}, {0.06, -0.1}}) {
    rod.segments[0].more_radius = more;
    for (int trial = 0; trial < 30; ++trial) {
      const Arc arc(2.5 * d(random), 6, 2, rod);
      const Vec2 place = arc.at(0.5 + 0.5 * d(random)) + 0.12 * Vec2{d(random), d(random)};
      const Circle circle(place, 0.05 + 0.04 * d(random));
      const Wall wall(place, {d(random), d(random)});
      const RoundedHull hull({place, place + Vec2{0.1, 0.02}, place + Vec2{0.05, 0.1}}, 0.01);
      for (const Obstacle* obstacle : {static_cast<const Obstacle*>(&circle), static_cast<const Obstacle*>(&wall),
                                       static_cast<const Obstacle*>(&hull)}) {
        double deepest = 0.0;
        constexpr int samples = 20000;
        for (int i = 0; i <= samples; ++i) {
          const double s = static_cast<double>(i) / samples;
          deepest = std::max(deepest, rod.radius_at(s).value - obstacle->at(arc.at(s)).distance);
        }
        const double depth = certified_depth(arc.curve, *obstacle);
        EXPECT_GE(depth, deepest - 1e-13);
        // Near a centre the distance changes as fast as the place, and the radius by a tenth of that.
        EXPECT_LE(depth, deepest + 0.6 / samples);
        double lowest = infinity;
        for (const ClosestApproach& at : closest_approaches(arc.curve, *obstacle, 0.0))
          lowest = std::min(lowest, at.distance);
        if (!(deepest > 1e-6)) continue;
        EXPECT_NEAR(-lowest, depth, 1e-8);
      }
    }
  }
}

}  // namespace
}  // namespace tendril::support
