// Bodies of any outline: what bounds them, their distance, normal and curvature against a second computation, and what
// is no body.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>
#include <string>

#include "obstacle/part.hpp"
#include "obstacle/room.hpp"
#include "obstacle/rounded_hull.hpp"
#include "obstacle/shape_options.hpp"
#include "raw_values.hpp"
#include "search/sides.hpp"
#include "support/contains.hpp"
#include "support/random_outline.hpp"
#include "tendril/pivot.hpp"

namespace tendril {
namespace {

using support::random_outline;

/// By the angle that a line winds around a point: other code than that of the boundary.
bool surrounds(const ClosedLine& line, Vec2 p) {
  double angle = 0.0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const Vec2 a = line[i] - p;
    const Vec2 b = line[(i + 1) % line.size()] - p;
    angle += std::atan2(cross(a, b), dot(a, b));
  }
  return std::abs(angle) > std::numbers::pi;
}

bool surrounded(const std::vector<ClosedLine>& lines, Vec2 p) {
  int count = 0;
  for (const ClosedLine& line : lines) count += surrounds(line, p) ? 1 : 0;
  return count % 2 == 1;
}

double distance_to(const std::vector<ClosedLine>& lines, Vec2 p) {
  double least = infinity;
  for (const ClosedLine& line : lines) {
    for (std::size_t i = 0; i < line.size(); ++i) {
      const Vec2 side = line[(i + 1) % line.size()] - line[i];
      const double t = std::clamp(dot(p - line[i], side) / dot(side, side), 0.0, 1.0);
      least = std::min(least, norm(p - line[i] - t * side));
    }
  }
  return least;
}

class Dice {
 public:
  explicit Dice(unsigned seed) : engine_(seed) {}
  Vec2 point(double reach) {
    std::uniform_real_distribution<double> d(-reach, reach);
    return {d(engine_), d(engine_)};
  }
  std::mt19937& engine() { return engine_; }

 private:
  std::mt19937 engine_;
};

TEST(Region, IsAllThatLiesInABodyAndInNoHole) {
  Dice dice(1);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<ClosedLine> bodies;
    std::vector<ClosedLine> holes;
    for (int i = 0; i < 1 + trial % 4; ++i) bodies.push_back(random_outline(dice.engine(), dice.point(0.5), 0.6));
    for (int i = 0; i < trial % 3; ++i) holes.push_back(random_outline(dice.engine(), dice.point(0.6), 0.4));
    const std::vector<ClosedLine> boundary = boundary_of(bodies, holes);
    double area = 0.0;
    for (const ClosedLine& line : boundary) {
      EXPECT_FALSE(fault_of(line)) << trial << ": " << fault_of(line)->found;
      area += twice_area(line);
    }
    EXPECT_GT(area, 0.0);
    const auto holds = [](const std::vector<ClosedLine>& lines, Vec2 p) {
      return std::any_of(lines.begin(), lines.end(), [&](const ClosedLine& line) { return surrounds(line, p); });
    };
    for (int i = 0; i < 100; ++i) {
      const Vec2 p = dice.point(1.2);
      EXPECT_EQ(surrounded(boundary, p), holds(bodies, p) && !holds(holes, p)) << trial << ' ' << p.x << ' ' << p.y;
    }
  }
}

const ClosedLine square{{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}};

TEST(Region, HasNoBoundaryWherePartsMeet) {
  // Side by side, a part of a side against a whole one, one over the other, in any order and direction.
  const std::vector<std::vector<ClosedLine>> cuts{
      {{{0.0, 0.0}, {0.3, 0.0}, {0.3, 1.0}, {0.0, 1.0}}, {{0.3, 0.0}, {1.0, 0.0}, {1.0, 1.0}, {0.3, 1.0}}},
      {{{0.0, 0.0}, {1.0, 0.0}, {1.0, 0.4}, {0.0, 0.4}},
       {{0.5, 0.4}, {1.0, 0.4}, {1.0, 1.0}, {0.5, 1.0}},
       {{0.0, 1.0}, {0.5, 1.0}, {0.5, 0.4}, {0.0, 0.4}}},
      {{{0.0, 0.0}, {0.6, 0.0}, {0.6, 1.0}, {0.0, 1.0}}, {{0.2, 0.0}, {1.0, 0.0}, {1.0, 1.0}, {0.2, 1.0}}},
      {{{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}}, {{0.0, 0.0}, {0.0, 1.0}, {1.0, 1.0}}},
      {square, square},
      {square, {{0.0, 0.2}, {0.4, 0.2}, {0.4, 0.7}, {0.0, 0.7}}}};
  for (const std::vector<ClosedLine>& parts : cuts) {
    const std::vector<ClosedLine> whole = boundary_of(parts, {});
    ASSERT_EQ(whole.size(), 1U);
    ClosedLine line = whole[0];
    ASSERT_EQ(line.size(), 4U);
    const auto first = std::find(line.begin(), line.end(), Vec2{0.0, 0.0});
    ASSERT_NE(first, line.end());
    std::rotate(line.begin(), first, line.end());
    for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(norm(line[i] - square[i]), 0.0, 1e-15);
  }
}

TEST(Region, ABodyMayStandInAHole) {
  const auto box = [](double half) { return ClosedLine{{-half, -half}, {half, -half}, {half, half}, {-half, half}}; };
  double area = 0.0;
  for (const ClosedLine& line : boundary_of({box(3.0), box(1.0)}, {box(2.0)}, Overlap::count)) {
    area += 0.5 * twice_area(line);
  }
  EXPECT_NEAR(area, 36.0 - 16.0 + 4.0, 1e-12);
  EXPECT_EQ(boundary_of({box(3.0), box(1.0)}, {box(2.0)}, Overlap::cut).size(), 2U);
}

TEST(Region, BodiesThatMeetInAPointStayApart) {
  const ClosedLine other{{1.0, 1.0}, {2.0, 1.0}, {2.0, 2.0}, {1.0, 2.0}};
  EXPECT_EQ(boundary_of({square, other}, {}).size(), 2U);
  // A hole that reaches a corner of the body: one line, which comes to that corner twice.
  const ClosedLine hole{{0.0, 0.0}, {0.5, 0.2}, {0.2, 0.5}};
  double area = 0.0;
  for (const ClosedLine& line : boundary_of({square}, {hole})) area += 0.5 * twice_area(line);
  EXPECT_NEAR(area, 1.0 - 0.5 * twice_area(hole), 1e-15);
  EXPECT_TRUE(boundary_of({hole}, {square}).empty());
}

// 200 bodies, some with holes: distance, normal and curvature in and around them.
TEST(Part, DistanceIsThatToTheOutline) {
  Dice dice(2);
  constexpr double rounding = 0.07;
  int inward = 0;
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<ClosedLine> holes;
    if (trial % 4 == 0) holes.push_back(random_outline(dice.engine(), dice.point(0.2), 0.3));
    const std::vector<ClosedLine> lines = boundary_of({random_outline(dice.engine(), {}, 1.0)}, holes);
    const Part part(lines, rounding);
    for (int i = 0; i < 100; ++i) {
      const Vec2 p = dice.point(1.5);
      const SurfacePoint s = part.at(p);
      const bool inside = surrounded(lines, p);
      const double away = distance_to(lines, p);
      EXPECT_NEAR(s.distance, (inside ? -away : away) - rounding, 1e-14);
      EXPECT_NEAR(part.core_distance(p), inside ? 0.0 : away, 1e-14);
      // The nearest point of the outline lies at the end of the normal, and the level line bends around it.
      const Vec2 foot = p - (s.distance + rounding) * s.normal;
      EXPECT_NEAR(distance_to(lines, foot), 0.0, 1e-14);
      EXPECT_NEAR(s.curvature * (inside ? -away : away), s.curvature == 0.0 ? 0.0 : 1.0, 1e-11);
      inward += inside && s.curvature != 0.0 ? 1 : 0;
      EXPECT_EQ(s.distance, part.on_patch(part.patch_at(p), p).distance);
    }
    EXPECT_LE(part.at(part.reference_point()).distance, -rounding + 1e-12);
  }
  EXPECT_GT(inward, 100);
}

TEST(Part, OutsideTheNormalJumpsOnlyBetweenSidesThatFaceEachOther) {
  Dice dice(3);
  int seams = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const Part part(boundary_of({random_outline(dice.engine(), {}, 1.0)}, {}), 0.05);
    for (int i = 0; i < 20; ++i) {
      const Vec2 p = dice.point(1.5);
      if (part.core_distance(p) < 0.05) continue;
      const int patch = part.patch_at(p);
      for (const Seam& seam : part.seams(patch)) {
        const double away = dot(seam.normal, p) - seam.offset;
        EXPECT_GE(away, -1e-14);
        const Vec2 on = p - away * seam.normal;
        if (part.patch_at(on + 1e-6 * seam.normal) != patch || part.core_distance(on) < 0.05) continue;
        const int other = part.patch_at(on - 1e-6 * seam.normal);
        EXPECT_NE(other, patch);
        EXPECT_NEAR(part.on_patch(other, on).distance, part.on_patch(patch, on).distance, 1e-14);
        EXPECT_NEAR(dot(part.on_patch(other, on).normal, part.on_patch(patch, on).normal), 1.0, 1e-14);
        ++seams;
      }
    }
  }
  EXPECT_GT(seams, 200);
}

TEST(Part, OfAConvexBodyCutByHandIsTheHull) {
  const std::vector<Vec2> corners{{-0.6, -0.5}, {0.5, -0.7}, {0.9, 0.1}, {0.2, 0.8}, {-0.7, 0.3}};
  const RoundedHull whole(corners, 0.15);
  const Vec2 middle{0.1, 0.05};
  std::vector<ClosedLine> parts;
  for (std::size_t i = 0; i < 5; ++i) parts.push_back({middle, corners[i], corners[(i + 1) % 5]});
  const Part cut(boundary_of(parts, {}), 0.15);
  Dice dice(4);
  for (int i = 0; i < 5000; ++i) {
    const Vec2 p = dice.point(1.5);
    const SurfacePoint a = whole.at(p);
    const SurfacePoint b = cut.at(p);
    EXPECT_NEAR(a.distance, b.distance, 1e-14);
    EXPECT_NEAR(norm(a.normal - b.normal), 0.0, 1e-12);
    EXPECT_NEAR(a.curvature, b.curvature, 1e-11 * (1.0 + a.curvature * a.curvature));
  }
  EXPECT_NEAR(norm(whole.reference_point() - cut.reference_point()), 0.0, 1e-14);
}

TEST(Part, OutlineAndBoxHoldTheBody) {
  Dice dice(5);
  for (int trial = 0; trial < 50; ++trial) {
    const Part part(boundary_of({random_outline(dice.engine(), {}, 1.0)}, {}), 0.02);
    Vec2 low, high;
    part.bounding_box(low, high);
    std::vector<Vec2> points(2000);
    part.outline(points, low, high);
    // Chords of arcs of 15 degrees at most, and of corners that are too narrow to be drawn.
    for (const Vec2 p : points) EXPECT_NEAR(part.at(p).distance, 0.0, 0.02);
    for (int i = 0; i < 100; ++i) {
      const Vec2 p = dice.point(1.5);
      if (part.at(p).distance > 0.0) continue;
      EXPECT_TRUE(p.x >= low.x && p.x <= high.x && p.y >= low.y && p.y <= high.y);
    }
  }
}

using List = RawValue::List;

std::unique_ptr<Obstacle> make(const Component<Obstacle>& component, const RawOptions& options) {
  return component.make(resolve_options(component.options, options, Scale{1.0, 1.0}, {}, "a shape"));
}

std::unique_ptr<Obstacle> polygon(RawOptions options) {
  options["rounding"] = {0.1};
  return make(polygon_component(), options);
}

std::unique_ptr<Obstacle> channel(const std::vector<Vec2>& line, RawOptions options) {
  options["points"] = points(line);
  return make(channel_component(), options);
}

// A wheel of 200 sides is one piece for a rod that cannot get between its teeth; a yard is not.
TEST(Part, HasPocketsWhereARodCanGoIn) {
  const auto wheel = [](double open) {
    ClosedLine line;
    for (int i = 0; i < 200; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / 200;
      const double reach = std::abs(angle - std::numbers::pi) < open ? 0.03 : i % 2 == 0 ? 0.076 : 0.072;
      line.push_back(Vec2{0.6 + reach * std::cos(angle), reach * std::sin(angle)});
    }
    return Part({line}, 0.004);
  };
  const Vec2 outside{0.0, 0.0};
  EXPECT_FALSE(has_pockets(wheel(0.0), outside));
  EXPECT_TRUE(has_pockets(wheel(0.5), outside));
  EXPECT_TRUE(has_pockets(Part({{{0, 0.1}, {0.2, 0.1}, {0.2, 0.3}, {0.1, 0.2}, {0, 0.3}}}, 0.01), outside));
  EXPECT_FALSE(has_pockets(Part({{{0, 0.1}, {0.2, 0.1}, {0.2, 0.3}, {0, 0.3}}}, 0.01), outside));
  // Where the base stands in a yard, whatever bounds it.
  const ClosedLine around{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  const ClosedLine yard{{-0.9, -0.9}, {-0.9, 0.9}, {0.9, 0.9}, {0.9, -0.9}};
  EXPECT_TRUE(has_pockets(Part({around, yard}, 0.01), outside));
}

TEST(PolygonOptions, NeedNotBeConvexAndMayRunEitherWay) {
  const std::vector<Vec2> corners{{0, 0}, {0.5, 0}, {1, 0}, {0.3, 0.3}, {0, 1}};
  const std::vector<Vec2> reversed(corners.rbegin(), corners.rend());
  const auto a = polygon({{"vertices", points(corners)}});
  const auto b = polygon({{"vertices", points(reversed)}});
  EXPECT_FALSE(a->convex());
  EXPECT_NEAR(a->at({0.6, 0.6}).distance, 0.3 / std::hypot(0.7, 0.3) - 0.1, 1e-15);
  Dice dice(6);
  for (int i = 0; i < 500; ++i) {
    const Vec2 p = dice.point(1.5);
    EXPECT_NEAR(a->at(p).distance, b->at(p).distance, 1e-15);
  }
}

TEST(PolygonOptions, OutlinesArePartsAndHoles) {
  const std::vector<Vec2> frame{{0, 0}, {3, 0}, {3, 3}, {0, 3}, {1, 1}, {1, 2}, {2, 2}, {2, 1}};
  const auto ring = polygon({{"vertices", points(frame)}, {"outlines", numbers({4, 4})}});
  EXPECT_NEAR(ring->at({1.5, 1.5}).distance, 0.4, 1e-15);
  EXPECT_NEAR(ring->at({0.5, 1.5}).distance, -0.6, 1e-15);
  EXPECT_NEAR(ring->at({1.5, 3.5}).distance, 0.4, 1e-15);
}

TEST(PolygonOptions, RefuseWhatBoundsNoBody) {
  const auto refused = [](RawOptions options, const char* reason) {
    std::string text = "nothing was refused";
    try {
      polygon(std::move(options));
    } catch (const Error& error) {
      text = error.what();
    }
    EXPECT_TRUE(contains_text(text, reason));
  };
  const std::vector<Vec2> two{{0, 0}, {1, 0}, {0, 1}, {2, 0}, {3, 0}, {2, 1}};
  refused({{"vertices", points({{0, 0}, {1, 0}, {0.3, 0.3}, {0.3, 0.3}, {0, 1}})}}, "found vertex 3 twice in a row");
  refused({{"vertices", points({{0, 0}, {1, 0}, {0.5, 0}, {0.2, 1}})}},
          "found vertex 2, at which the outline turns back on itself");
  refused({{"vertices", points({{0, 0}, {1, 1}, {1, 0}, {0, 1}})}},
          "sides that cross or meet: from vertex 1 to the next, and from vertex 3 to the next");
  refused({{"vertices", points({{0, 0}, {2, 0}, {1, 0.5}, {2, 1}, {0, 1}, {1.0, 0.5}})}}, "sides that cross or meet");
  refused({{"vertices", points(two)}, {"outlines", numbers({4, 3})}}, "found 7 vertices together");
  refused({{"vertices", points(two)}, {"outlines", numbers({3, 2.5})}}, "found 2.5; expected whole numbers from 3 on");
  refused({{"vertices", points({{0, 0}, {0, 1}, {1, 0}, {2, 0}, {2, 1}, {3, 0}})}, {"outlines", numbers({3, 3})}},
          "outlines that run clockwise");
  refused({{"vertices", points({{0, 0}, {1, 0}, {0, 1}, {2, 0}, {3, 0}, {2, 0}})}, {"outlines", numbers({3, 3})}},
          "found vertex 5, at which");
}

TEST(Channel, OfAStraightLineHasItsWidthAndItsEnds) {
  const RawOptions options{{"width", {0.2}}, {"wall", {0.1}}, {"rounding", {0.02}}};
  const auto open = channel({{0, 0}, {0.3, 0}, {1, 0}}, options);
  for (const double x : {0.0, 0.2, 0.5, 1.0}) EXPECT_NEAR(open->at({x, 0.04}).distance, 0.06, 1e-15);
  EXPECT_NEAR(open->at({0.5, 0.25}).distance, 0.05, 1e-15);
  EXPECT_NEAR(open->at({-0.5, 0.15}).distance, 0.48, 1e-15);
  EXPECT_GT(open->at({1.5, 0.0}).distance, 0.4);
  RawOptions shut = options;
  shut["closed"] = {std::string("end")};
  const auto closed = channel({{0, 0}, {1, 0}}, shut);
  EXPECT_NEAR(closed->at({0.95, 0.0}).distance, 0.05, 1e-15);
  EXPECT_NEAR(closed->at({1.2, 0.0}).distance, 0.1, 1e-15);
  EXPECT_NEAR(closed->at({-0.2, 0.0}).distance, std::hypot(0.2, 0.12) - 0.02, 1e-15);
}

// Bends of every kind, tight ones, loops: nothing within half of the width of the line belongs to a wall, and what lies
// a little farther, and nearer to no other part of the line, does.
TEST(Channel, IsFreeWithinHalfOfItsWidth) {
  Dice dice(7);
  constexpr double width = 0.2;
  int beside = 0;
  for (int trial = 0; trial < 100; ++trial) {
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    std::vector<Vec2> line{{0.0, 0.0}};
    double angle = 0.0;
    const double bend = trial % 3 == 0 ? 2.5 : trial % 3 == 1 ? 0.4 : 0.02;
    const double side = trial % 2 == 0 ? 0.4 : 0.05;
    for (int i = 0; i < 20; ++i) {
      line.push_back(line.back() + side * Vec2{std::cos(angle), std::sin(angle)});
      angle += bend * unit(dice.engine());
    }
    const auto walls = channel(line, {{"width", {width}}, {"rounding", {0.02}}});
    const auto away = [&](Vec2 p) {
      double least = infinity;
      for (std::size_t i = 0; i + 1 < line.size(); ++i) {
        const Vec2 way = line[i + 1] - line[i];
        const double t = std::clamp(dot(p - line[i], way) / dot(way, way), 0.0, 1.0);
        least = std::min(least, norm(p - line[i] - t * way));
      }
      return least;
    };
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
      for (int k = 0; k < 20; ++k) {
        const Vec2 p = line[i] + dice.point(0.5 * width);
        // Behind its ends there is no channel.
        const double from_end = std::min(norm(p - line.front()), norm(p - line.back()));
        if (away(p) > 0.5 * width || from_end < width) continue;
        EXPECT_GE(walls->at(p).distance, 0.5 * width - away(p) - 1e-9) << trial;
      }
      const Vec2 across = turned(line[i + 1] - line[i]);
      const Vec2 wall = 0.5 * (line[i] + line[i + 1]) + (0.75 * width / norm(across)) * across;
      if (away(wall) < 0.749 * width) continue;
      EXPECT_LT(walls->at(wall).distance, 0.0) << trial;
      ++beside;
    }
  }
  EXPECT_GT(beside, 500);
}

// A base beside the walls is as deep outside as it is far from the room; one that sees an open end may go in there.
// What is no channel keeps no room.
TEST(Channel, KeepsRoomWithinItsWallsAndInFrontOfOpenEnds) {
  const std::vector<Vec2> line{{0, 0}, {1, 0}};
  RawOptions options{{"width", {0.2}}, {"wall", {0.1}}, {"rounding", {0.02}}};
  for (const char* closed : {"none", "start", "end", "both"}) {
    options["closed"] = {std::string(closed)};
    const auto walls = channel(line, options);
    for (const double x : {0.0, 0.5, 1.0}) EXPECT_EQ(outside_room(*walls, {x, 0.09}), 0.0) << closed;
    EXPECT_NEAR(outside_room(*walls, {0.5, 0.3}), 0.2, 1e-15) << closed;
    EXPECT_NEAR(outside_room(*walls, {0.5, -1.1}), 1.0, 1e-15) << closed;
    const std::string ends = closed;
    const bool start = ends == "start" || ends == "both";
    const bool end = ends == "end" || ends == "both";
    EXPECT_NEAR(outside_room(*walls, {-0.5, 0.0}), start ? 0.5 : 0.0, 1e-15) << closed;
    EXPECT_NEAR(outside_room(*walls, {1.5, 0.05}), end ? 0.5 : 0.0, 1e-15) << closed;
  }
  // Nearer to a wall of the other arm than to the open end that it sees.
  const auto bent = channel({{0, 0}, {1, 0}, {1, 0.6}, {-0.5, 0.6}}, {{"width", {0.2}}, {"wall", {0.05}}});
  EXPECT_EQ(outside_room(*bent, {-0.2, 0.3}), 0.0);
  EXPECT_NEAR(outside_room(*bent, {0.5, -0.3}), 0.2, 1e-12);
  const Vec2 pivot{1.0, 1.0};
  const auto elsewhere = moved_about(channel(line, options), pivot, {2.0, 0.0}, 0.5 * std::numbers::pi);
  EXPECT_NEAR(outside_room(*elsewhere, pivot + Vec2{2.0, 0.0} + turned(Vec2{0.5, 0.3} - pivot)), 0.2, 1e-15);
  EXPECT_EQ(outside_room(RoundedHull({{0, 0}, {1, 0}}, 0.1), {0.5, 0.5}), infinity);
}

TEST(Channel, WidensBetweenItsPoints) {
  const auto cone = channel({{0, 0}, {1, 0}}, {{"widths", numbers({0.2, 0.4})}, {"rounding", {0.01}}});
  const double slope = std::atan2(0.1, 1.0);
  EXPECT_NEAR(cone->at({0.5, 0.0}).distance, (0.15 + 0.01) * std::cos(slope) - 0.01, 1e-12);
}

TEST(Channel, RefusesWhatIsNone) {
  const auto refused = [](const std::vector<Vec2>& line, const RawOptions& options, const char* reason) {
    std::string text = "nothing was refused";
    try {
      channel(line, options);
    } catch (const Error& error) {
      text = error.what();
    }
    EXPECT_TRUE(contains_text(text, reason));
  };
  const std::vector<Vec2> line{{0, 0}, {1, 0}, {1, 1}};
  refused({{0, 0}}, {{"width", {0.2}}}, "at least 2 points");
  refused({{0, 0}, {1, 0}, {1, 0}}, {{"width", {0.2}}}, "found point 2 twice in a row");
  refused({{0, 0}, {1, 0}, {0, 0}}, {{"width", {0.2}}}, "found point 2, at which the line turns back on itself");
  refused(line, {}, "found neither 'width' nor 'widths'");
  refused(line, {{"width", {0.2}}, {"widths", numbers({0.2, 0.2, 0.2})}}, "found 'width' and 'widths'");
  refused(line, {{"widths", numbers({0.2, 0.2})}}, "found 2 entries; expected one for each of the 3 points");
  refused(line, {{"widths", numbers({0.2, 0.0, 0.2})}}, "no width at point 2");
  refused(line, {{"width", {0.2}}, {"wall", {0.02}}, {"rounding", {0.01}}}, "found a wall of 2 times its rounding");
  refused(line, {{"width", {0.2}}, {"closed", {std::string("ends")}}},
          "expected one of 'none', 'start', 'end', 'both'");
}

}  // namespace
}  // namespace tendril
