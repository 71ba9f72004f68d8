// The obstacle shapes as geometry: distances, normals and curvatures against a second computation, and bad input.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>
#include <string>

#include "obstacle/circle.hpp"
#include "obstacle/part.hpp"
#include "obstacle/rounded_hull.hpp"
#include "obstacle/wall.hpp"
#include "raw_values.hpp"
#include "support/contains.hpp"
#include "tendril/pivot.hpp"
#include "tendril/plugins/registry.hpp"

namespace tendril {
namespace {

constexpr double pi = std::numbers::pi;

struct ShapeCase {
  const char* name;
  std::shared_ptr<const Obstacle> shape;
};

std::ostream& operator<<(std::ostream& os, const ShapeCase& c) { return os << c.name; }

class Shape : public testing::TestWithParam<ShapeCase> {
 protected:
  const Obstacle& shape() const { return *GetParam().shape; }
  Vec2 random_point(std::mt19937& random) const {
    std::uniform_real_distribution<double> d(-1.5, 1.5);
    return {d(random), d(random)};
  }
  /// Whether at() is one smooth formula within `reach` of the point, in which differences then make sense: no seam, no
  /// point that is nearest to two places of the boundary.
  bool smooth_around(Vec2 p, double reach) const {
    const int patch = shape().patch_at(p);
    const Vec2 n = shape().at(p).normal;
    for (int i = 0; i < 16; ++i) {
      const Vec2 q = p + reach * Vec2{std::cos(i * pi / 8), std::sin(i * pi / 8)};
      if (shape().patch_at(q) != patch || dot(shape().at(q).normal, n) < 0.9) return false;
    }
    return true;
  }
};

// The outline is drawn by other code than the distance: its points must lie on the boundary, and no point of the plane
// may be nearer to them than the distance says.
TEST_P(Shape, DistanceIsThatToTheNearestPointOfTheBoundary) {
  std::vector<Vec2> boundary(20001);
  shape().outline(boundary, {-6.0, -6.0}, {6.0, 6.0});
  double spacing = 0.0;
  std::vector<Vec2> on;
  for (std::size_t i = 0; i < boundary.size(); ++i) {
    // A wall's outline also runs along the box.
    if (std::max(std::abs(boundary[i].x), std::abs(boundary[i].y)) > 6.0 - 1e-9) continue;
    if (!on.empty()) spacing = std::max(spacing, norm(boundary[i] - on.back()));
    on.push_back(boundary[i]);
  }
  ASSERT_GT(on.size(), 1000U);
  // Arcs are drawn as chords of 7.5 degrees at most: they stay within r (1 - cos 3.75 deg) = 0.0022 r of the arc.
  const double chord = 0.0022 * (std::isfinite(shape().smallest_radius()) ? shape().smallest_radius() : 0.0);
  for (const Vec2 p : on) EXPECT_NEAR(shape().at(p).distance, -0.5 * chord, 0.5 * chord + 1e-12);
  std::mt19937 random(5);
  for (int trial = 0; trial < 200; ++trial) {
    const Vec2 p = random_point(random);
    double nearest = infinity;
    for (const Vec2 q : on) nearest = std::min(nearest, norm(p - q));
    EXPECT_NEAR(std::abs(shape().at(p).distance), nearest, spacing + chord) << p.x << ' ' << p.y;
  }
}

TEST_P(Shape, IsInsideWhereTheDistanceIsNegative) {
  // From the reference point, which lies inside or on the boundary, to far outside along the normal there.
  const Vec2 inside = shape().reference_point();
  EXPECT_LE(shape().at(inside).distance, 0.0);
  const Vec2 far = inside + 50.0 * shape().at(inside).normal;
  EXPECT_GT(shape().at(far).distance, 40.0);
}

TEST_P(Shape, NormalAndCurvaturesAreTheDerivativesOfTheDistance) {
  std::mt19937 random(3);
  // Fourth-order differences of functions whose fifth derivatives reach 24 / (0.04)^4 near a corner: 1e-3^4 / 30 times
  // that is 3e-7.
  constexpr double h = 1e-3;
  constexpr double tolerance = 1e-6;
  const auto difference = [&](Vec2 p, Vec2 along, auto&& f) {
    return (8.0 * (f(p + h * along) - f(p - h * along)) - (f(p + 2 * h * along) - f(p - 2 * h * along))) / (12.0 * h);
  };
  int inside = 0;
  int tested = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const Vec2 p = random_point(random);
    const SurfacePoint s = shape().at(p);
    // Level sets near a corner turn too fast for the differences.
    if (!smooth_around(p, 3 * h) || s.curvature > 25.0) continue;
    ++tested;
    inside += s.distance < 0.0 ? 1 : 0;
    EXPECT_NEAR(norm(s.normal), 1.0, 1e-14);
    const Vec2 tau = turned(s.normal);
    const auto distance = [&](Vec2 q) { return shape().at(q).distance; };
    EXPECT_NEAR(difference(p, s.normal, distance), 1.0, tolerance);
    EXPECT_NEAR(difference(p, tau, distance), 0.0, tolerance);
    const auto turn = [&](Vec2 q) { return dot(shape().at(q).normal, tau); };
    EXPECT_NEAR(difference(p, tau, turn), s.curvature, tolerance * (1.0 + s.curvature));
    EXPECT_NEAR(difference(p, s.normal, turn), 0.0, tolerance);
    // The tangential rate follows the level set: its tangent turns on the way, which matters in second order only.
    EXPECT_NEAR(difference(p, tau, [&](Vec2 q) { return shape().at(q).curvature; }), s.curvature_rate,
                tolerance * (1.0 + s.curvature * s.curvature));
  }
  EXPECT_GT(tested, 500);
  EXPECT_GT(inside, 5);
}

// The clearance bound stands on this.
TEST_P(Shape, IsItsConvexCoreGrownByTheRounding) {
  std::mt19937 random(9);
  for (int trial = 0; trial < 2000; ++trial) {
    const Vec2 a = random_point(random);
    const Vec2 b = random_point(random);
    const SurfacePoint s = shape().at(a);
    EXPECT_NEAR(shape().core_distance(a),
                std::isfinite(shape().smallest_radius()) ? std::max(0.0, s.distance + shape().rounding()) : s.distance,
                1e-14);
    // The signed distance is convex: it lies above each of its tangents.
    EXPECT_GE(shape().at(b).distance, s.distance + dot(s.normal, b - a) - 1e-14);
    EXPECT_LE(std::abs(shape().at(b).distance - s.distance), norm(b - a) + 1e-14);
  }
}

TEST_P(Shape, PatchesAgreeWithTheWholeOnTheirSideOfTheSeams) {
  std::mt19937 random(4);
  for (int trial = 0; trial < 2000; ++trial) {
    const Vec2 p = random_point(random);
    if (shape().core_distance(p) <= 0.0) continue;
    const int patch = shape().patch_at(p);
    const SurfacePoint whole = shape().at(p);
    EXPECT_EQ(shape().on_patch(patch, p).distance, whole.distance);
    for (const Seam& seam : shape().seams(patch)) {
      EXPECT_GE(dot(seam.normal, p), seam.offset - 1e-14);
      // On the seam both sides have the same distance and normal.
      const double away = dot(seam.normal, p) - seam.offset;
      const Vec2 on = p - away * seam.normal;
      if (shape().core_distance(on) <= 0.05) continue;
      const Vec2 beyond = on - 1e-9 * seam.normal;
      const int other = shape().patch_at(beyond);
      if (shape().patch_at(on + 1e-9 * seam.normal) != patch) continue;  // another seam comes first
      EXPECT_NE(other, patch);
      EXPECT_NEAR(shape().on_patch(other, on).distance, shape().on_patch(patch, on).distance, 1e-14);
      EXPECT_NEAR(dot(shape().on_patch(other, on).normal, shape().on_patch(patch, on).normal), 1.0, 1e-14);
    }
  }
}

TEST_P(Shape, LiesInItsBox) {
  Vec2 low, high;
  shape().bounding_box(low, high);
  std::mt19937 random(6);
  for (int trial = 0; trial < 2000; ++trial) {
    const Vec2 p = random_point(random);
    if (shape().at(p).distance > 0.0) continue;
    EXPECT_TRUE(p.x >= low.x && p.x <= high.x && p.y >= low.y && p.y <= high.y);
  }
}

std::vector<ShapeCase> shapes() {
  return {
      {"circle", std::make_shared<Circle>(Vec2{0.3, -0.2}, 0.4)},
      {"wall", std::make_shared<Wall>(Vec2{0.1, -0.3}, Vec2{0.6, 1.9})},
      {"table", std::make_shared<Wall>(Vec2{0.0, -0.4}, Vec2{0.0, 2.0})},
      {"ceiling", std::make_shared<Wall>(Vec2{0.0, 0.3}, Vec2{0.0, -1.0})},
      {"left_side", std::make_shared<Wall>(Vec2{-0.2, 0.0}, Vec2{3.0, 0.0})},
      {"right_side", std::make_shared<Wall>(Vec2{0.3, 0.0}, Vec2{-1.0, 0.0})},
      {"capsule", std::make_shared<RoundedHull>(std::vector<Vec2>{{-0.4, 0.1}, {0.6, 0.5}}, 0.2)},
      {"slim_capsule", std::make_shared<RoundedHull>(std::vector<Vec2>{{0.0, -0.9}, {0.0, 0.8}}, 0.04)},
      {"triangle", std::make_shared<RoundedHull>(std::vector<Vec2>{{-0.5, -0.4}, {0.7, -0.3}, {0.1, 0.6}}, 0.1)},
      {"square",
       std::make_shared<RoundedHull>(std::vector<Vec2>{{0.0, 0.0}, {0.8, 0.0}, {0.8, 0.8}, {0.0, 0.8}}, 0.05)},
      {"square_of_any_outline",
       std::make_shared<Part>(std::vector<ClosedLine>{{{0.0, 0.0}, {0.8, 0.0}, {0.8, 0.8}, {0.0, 0.8}}}, 0.05)},
      {"pentagon", std::make_shared<RoundedHull>(
                       std::vector<Vec2>{{-0.6, -0.5}, {0.5, -0.7}, {0.9, 0.1}, {0.2, 0.8}, {-0.7, 0.3}}, 0.15)},
      {"moved_circle", moved(std::make_unique<Circle>(Vec2{0.3, -0.2}, 0.4), {-0.5, 0.1}, 0.0)},
      {"turned_wall", moved(std::make_unique<Wall>(Vec2{0.1, -0.3}, Vec2{0.6, 1.9}), {0.2, 0.1}, 2.0)},
      {"shifted_wall", moved(std::make_unique<Wall>(Vec2{0.0, -0.4}, Vec2{0.0, 2.0}), {0.3, 0.2}, 0.0)},
      {"turned_capsule",
       moved(std::make_unique<RoundedHull>(std::vector<Vec2>{{-0.4, 0.1}, {0.6, 0.5}}, 0.2), {-0.2, -0.3}, 0.8)},
      {"turned_triangle",
       moved(std::make_unique<RoundedHull>(std::vector<Vec2>{{-0.5, -0.4}, {0.7, -0.3}, {0.1, 0.6}}, 0.1), {}, -2.5)},
      {"turned_square_of_any_outline",
       moved(std::make_unique<Part>(std::vector<ClosedLine>{{{0.0, 0.0}, {0.8, 0.0}, {0.8, 0.8}, {0.0, 0.8}}}, 0.05),
             {-0.5, -0.5}, 0.6)}};
}

INSTANTIATE_TEST_SUITE_P(All, Shape, testing::ValuesIn(shapes()),
                         [](const auto& each) { return std::string(each.param.name); });

// What it is moved to is what its options could have said.
TEST(MovedShape, IsThatOfItsOwnPlace) {
  const double turn = 0.7;
  const Vec2 shift{0.2, -0.1};
  const std::vector<Vec2> corners{{-0.5, -0.4}, {0.7, -0.3}, {0.1, 0.6}};
  const Vec2 middle = RoundedHull(corners, 0.1).reference_point();
  std::vector<Vec2> there;
  for (const Vec2 c : corners) {
    const Vec2 d = c - middle;
    there.push_back(middle + shift +
                    Vec2{std::cos(turn) * d.x - std::sin(turn) * d.y, std::sin(turn) * d.x + std::cos(turn) * d.y});
  }
  const RoundedHull expected(there, 0.1);
  const std::unique_ptr<Obstacle> made = moved(std::make_unique<RoundedHull>(corners, 0.1), shift, turn);
  EXPECT_NEAR(norm(made->reference_point() - expected.reference_point()), 0.0, 1e-15);
  std::mt19937 random(8);
  std::uniform_real_distribution<double> d(-1.5, 1.5);
  for (int trial = 0; trial < 500; ++trial) {
    const Vec2 p{d(random), d(random)};
    const SurfacePoint a = made->at(p);
    const SurfacePoint b = expected.at(p);
    EXPECT_NEAR(a.distance, b.distance, 1e-14);
    if (b.distance > -0.1) {
      EXPECT_NEAR(norm(a.normal - b.normal), 0.0, 1e-12);
    }
    EXPECT_NEAR(made->core_distance(p), expected.core_distance(p), 1e-14);
  }
}

TEST(MovedShape, TurnsAboutItsPivotWhereItHasOne) {
  const Vec2 center{0.3, -0.2};
  const Vec2 pivot{-0.4, 0.5};
  const Vec2 shift{0.1, 0.7};
  const double turn = 1.1;
  const Vec2 d = center - pivot;
  const Vec2 there =
      pivot + shift + Vec2{std::cos(turn) * d.x - std::sin(turn) * d.y, std::sin(turn) * d.x + std::cos(turn) * d.y};
  const auto made = moved_about(std::make_unique<Circle>(center, 0.4), pivot, shift, turn);
  EXPECT_NEAR(norm(made->reference_point() - there), 0.0, 1e-15);
  EXPECT_NEAR(norm(pivot_of(*made) - pivot - shift), 0.0, 1e-15);
  for (const Vec2 p : {Vec2{}, Vec2{1.0, 2.0}, Vec2{-3.0, 0.1}}) {
    EXPECT_NEAR(made->at(p).distance, norm(p - there) - 0.4, 1e-14);
  }
  EXPECT_EQ(norm(pivot_of(Circle(center, 0.4)) - center), 0.0);
}

TEST(MovedShape, IsTheShapeItselfWhereItDoesNotMove) {
  auto circle = std::make_unique<Circle>(Vec2{0.3, -0.2}, 0.4);
  const Obstacle* itself = circle.get();
  EXPECT_EQ(moved(std::move(circle), {}, 0.0).get(), itself);
}

// A capsule from (0, 0) to (2, 0): its patches are both sides of the line, then both ends.
TEST(RoundedHull, SeamsOfACapsuleStandAtItsEnds) {
  const RoundedHull capsule({{0.0, 0.0}, {2.0, 0.0}}, 0.5);
  const auto expect_seams = [&](int patch, double from, double to) {
    SCOPED_TRACE("patch " + std::to_string(patch));
    double low = -infinity;
    double high = infinity;
    for (const Seam& seam : capsule.seams(patch)) {
      EXPECT_EQ(seam.normal.y, 0.0);
      if (seam.normal.x > 0.0) low = std::max(low, seam.offset);
      if (seam.normal.x < 0.0) high = std::min(high, -seam.offset);
    }
    EXPECT_DOUBLE_EQ(low, from);
    EXPECT_DOUBLE_EQ(high, to);
  };
  expect_seams(0, 0.0, 2.0);
  expect_seams(1, 0.0, 2.0);
  expect_seams(2, -infinity, 0.0);
  expect_seams(3, 2.0, infinity);
}

TEST(RoundedHull, ReferencePointIsTheMiddleOrTheCentroid) {
  EXPECT_NEAR(norm(RoundedHull({{-1.0, 0.5}, {3.0, 1.5}}, 0.1).reference_point() - Vec2{1.0, 1.0}), 0.0, 1e-15);
  // A triangle's centroid is the mean of its corners; far from the origin it keeps its digits.
  for (const Vec2 away : {Vec2{}, Vec2{1e5, -1e5}}) {
    const RoundedHull triangle({away, away + Vec2{0.3, 0.0}, away + Vec2{0.0, 0.6}}, 0.1);
    EXPECT_NEAR(norm(triangle.reference_point() - away - Vec2{0.1, 0.2}), 0.0, 1e-10);
  }
}

using List = RawValue::List;

std::unique_ptr<Obstacle> make(const std::string& shape, const RawOptions& options, double length = 1.0) {
  plugins::Registry registry{plugins::Catalog(plugins::search_places({}))};
  const ObstacleComponent& component = registry.obstacle(shape);
  return component.make(resolve_options(component.options, options, Scale{length, 1.0}, {}, "shape '" + shape + "'"));
}

std::string refusal(const std::string& shape, const RawOptions& options) {
  try {
    make(shape, options);
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing was refused";
}

void expect_refused(const std::string& shape, const RawOptions& options, const std::string& reason) {
  const std::string text = refusal(shape, options);
  EXPECT_TRUE(contains_text(text, reason));
}

TEST(ShapeOptions, AreInUnitsOfTheRod) {
  // The rod is 0.1 m long.
  const auto wall = make("wall", {{"point", numbers({0.02, -0.01})}, {"normal", numbers({0.0, 5.0})}}, 0.1);
  EXPECT_NEAR(wall->at({0.7, 0.4}).distance, 0.5, 1e-14);
  const auto capsule =
      make("capsule", {{"from", numbers({0.0, 0.0})}, {"to", numbers({0.05, 0.0})}, {"radius", {0.01}}}, 0.1);
  EXPECT_NEAR(capsule->at({0.25, 0.4}).distance, 0.3, 1e-14);
  EXPECT_NEAR(capsule->at({0.8, 0.4}).distance, 0.4, 1e-14);
  const auto square =
      make("polygon", {{"vertices", points({{0, 0}, {0.02, 0}, {0.02, 0.02}, {0, 0.02}})}, {"rounding", {0.001}}}, 0.1);
  EXPECT_NEAR(square->at({0.3, 0.1}).distance, 0.09, 1e-14);
  EXPECT_NEAR(square->at({0.1, 0.1}).distance, -0.11, 1e-14);
  EXPECT_NEAR(norm(square->reference_point() - Vec2{0.1, 0.1}), 0.0, 1e-14);
}

TEST(ShapeOptions, AWallIsTurnedByItsNormalOrItsAngle) {
  const auto by_normal = make("wall", {{"point", numbers({0.0, 0.2})}, {"normal", numbers({-1.0, 1.0})}});
  const auto by_angle = make("wall", {{"point", numbers({0.0, 0.2})}, {"angle", {pi / 4}}});
  for (const Vec2 p : {Vec2{0.3, 0.9}, Vec2{-2.0, 0.1}}) {
    EXPECT_NEAR(by_angle->at(p).distance, by_normal->at(p).distance, 1e-11);
  }
  const auto table = make("wall", {{"point", numbers({0.0, 0.2})}, {"angle", {0.0}}});
  EXPECT_NEAR(table->at({3.0, 0.5}).distance, 0.3, 1e-14);
}

TEST(ShapeOptions, VerticesMayRunEitherWay) {
  const std::vector<Vec2> corners{{0, 0}, {1, 0}, {1, 1}, {0.2, 0.9}};
  const std::vector<Vec2> reversed(corners.rbegin(), corners.rend());
  const auto a = make("polygon", {{"vertices", points(corners)}, {"rounding", {0.1}}});
  const auto b = make("polygon", {{"vertices", points(reversed)}, {"rounding", {0.1}}});
  std::mt19937 random(8);
  std::uniform_real_distribution<double> d(-1.0, 2.0);
  for (int trial = 0; trial < 200; ++trial) {
    const Vec2 p{d(random), d(random)};
    EXPECT_NEAR(a->at(p).distance, b->at(p).distance, 1e-14);
  }
}

TEST(ShapeOptions, RefuseWhatIsNoWall) {
  const double nan = std::nan("");
  expect_refused("wall", {{"point", numbers({0, 0})}, {"normal", numbers({0, 0})}}, "length 0");
  expect_refused("wall", {{"point", numbers({0, 0})}, {"normal", numbers({nan, 1})}}, "not a finite number");
  expect_refused("wall", {{"point", numbers({0, infinity})}, {"normal", numbers({0, 1})}}, "not a finite number");
  expect_refused("wall", {{"point", numbers({0, 0})}}, "neither 'normal' nor 'angle'");
  expect_refused("wall", {{"point", numbers({0, 0})}, {"normal", numbers({0, 1})}, {"angle", {1.0}}},
                 "expected one of them");
  expect_refused("wall", {{"normal", numbers({0, 1})}}, "needs option 'point'");
  expect_refused("wall", {{"point", numbers({0, 0, 0})}, {"angle", {1.0}}}, "3 entries");
  expect_refused("wall", {{"point", numbers({0, 0})}, {"angel", {1.0}}}, "did you mean 'angle'");
}

TEST(ShapeOptions, RefuseWhatIsNoCapsule) {
  expect_refused("capsule", {{"from", numbers({1, 2})}, {"to", numbers({1, 2})}, {"radius", {0.1}}}, "the same point");
  expect_refused("capsule", {{"from", numbers({1, 2})}, {"to", numbers({2, 2})}, {"radius", {0.0}}}, "out of range");
  expect_refused("capsule", {{"from", numbers({1, 2})}, {"to", numbers({2, 2})}, {"radius", {std::nan("")}}},
                 "not a finite");
  expect_refused("capsule", {{"from", numbers({1, 2})}, {"to", numbers({2, 2})}}, "needs option 'radius'");
}

TEST(ShapeOptions, RefuseWhatIsNoPolygon) {
  const auto refused = [](const std::vector<Vec2>& vertices, const char* reason) {
    expect_refused("polygon", {{"vertices", points(vertices)}, {"rounding", {0.1}}}, reason);
  };
  refused({{0, 0}, {1, 0}}, "2 entries");
  refused({{0, 0}, {1, 0}, {0.5, 0}}, "vertex");
  refused({{0, 0}, {1, 0}, {1, 0}, {0, 1}}, "vertex 2 twice");
  refused({{0, 0}, {1, 1}, {1, 0}, {0, 1}}, "sides that cross");
  refused({{0, 0}, {std::nan(""), 0}, {0, 1}}, "not a finite number");
  std::vector<Vec2> star;
  star.reserve(5);
  for (int i = 0; i < 5; ++i) star.push_back({std::cos(0.8 * pi * i), std::sin(0.8 * pi * i)});
  refused(star, "sides that cross");
  expect_refused("polygon", {{"vertices", points({{0, 0}, {1, 0}, {0, 1}})}, {"rounding", {0.0}}}, "out of range");
  expect_refused("polygon", {{"vertices", {List{{1.0}, {2.0}, {3.0}}}}, {"rounding", {0.1}}}, "no point");
  expect_refused("polygon", {{"vertices", {3.0}}, {"rounding", {0.1}}}, "a list of at least 3 points [x, y] in m");
}

// The distance to a circle of radius R whose top is at the origin is y + x^2 / (2 R) - ..., to the last digits of y.
TEST(Circle, FarLargerThanTheRodItKeepsItsDigits) {
  constexpr double radius = 1e4;
  const Circle circle({0.0, -radius}, radius);
  for (const double y : {1e-9, 1e-6, 1e-3}) {
    EXPECT_NEAR(circle.at({0.0, y}).distance, y, 1e-15 + 4e-16 * y);
    const double x = 0.5;
    const double exact = (x * x + y * y + 2.0 * y * radius) / (std::hypot(x, y + radius) + radius);
    EXPECT_NEAR(circle.at({x, y}).distance, exact, 1e-15);
  }
}

}  // namespace
}  // namespace tendril
