#include <algorithm>
#include <cmath>
#include <numbers>

#include "obstacle/rounded_hull.hpp"
#include "obstacle/shape_options.hpp"

namespace tendril {
namespace {

/// A corner that turns by less than this (rad) is none: rounding of the input could turn it the other way.
constexpr double least_turn = 1e-6;

[[noreturn]] void refuse(const std::string& found, const std::string& expected) {
  throw OptionError("vertices", {}, "option 'vertices' of a polygon: found " + found + "; expected " + expected);
}

/// The vertices counterclockwise, if they are those of a convex polygon.
std::vector<Vec2> convex(std::vector<Vec2> vertices) {
  const std::size_t n = vertices.size();
  double area = 0.0;
  for (std::size_t i = 1; i + 1 < n; ++i) area += cross(vertices[i] - vertices[0], vertices[i + 1] - vertices[0]);
  const bool clockwise = area < 0.0;
  double around = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec2 before = vertices[i] - vertices[(i + n - 1) % n];
    const Vec2 after = vertices[(i + 1) % n] - vertices[i];
    const std::string vertex = "vertex " + std::to_string(i + 1);
    if (!(norm(after) > 0.0)) refuse(vertex + " twice in a row", "vertices that differ");
    const double angle = std::atan2(cross(before, after), dot(before, after));
    const double turn = clockwise ? -angle : angle;
    if (std::abs(turn) < least_turn) {
      refuse(vertex + " on the line between its neighbours", "corners only: leave it out");
    }
    if (turn < 0.0 || turn > std::numbers::pi - least_turn) {
      refuse(vertex + " pointing inward", "a convex polygon (make several of one that is not)");
    }
    around += turn;
  }
  if (around > 3.0 * std::numbers::pi) refuse("sides that cross", "a convex polygon");
  if (clockwise) std::reverse(vertices.begin(), vertices.end());
  return vertices;
}

}  // namespace

Component<Obstacle> polygon_component() {
  OptionSpec vertices;
  vertices.name = "vertices";
  vertices.type = OptionType::points;
  vertices.size = 3;
  vertices.required = true;
  vertices.dimension = dimension::length;
  vertices.description = "corners of a convex polygon, in order around it";
  return {
      "polygon",
      "a convex polygon grown by a distance, which rounds its corners",
      {vertices, positive_length_option("rounding", "distance by which the polygon is grown: radius of its corners")},
      [](const Options& options) -> std::unique_ptr<Obstacle> {
        const NumberTable& table = options.table("vertices");
        std::vector<Vec2> points;
        points.reserve(static_cast<std::size_t>(table.rows));
        for (int i = 0; i < table.rows; ++i) points.push_back({table(i, 0), table(i, 1)});
        return std::make_unique<RoundedHull>(convex(std::move(points)), options.real("rounding"));
      }};
}

}  // namespace tendril
