#include "check/body.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "tendril/error.hpp"

namespace tendril::bench {
namespace {

double number_of(const RawValue& value, const QuantityReader& read, const Dimension& of) {
  if (const auto* real = std::get_if<double>(&value.value)) return *real;
  if (const auto* whole = std::get_if<std::int64_t>(&value.value)) return static_cast<double>(*whole);
  if (const auto* text = std::get_if<std::string>(&value.value)) return read(*text, of);
  throw Error("an option of an obstacle is no number");
}

Vec2 point_of(const RawValue& value, const QuantityReader& read, double length) {
  const auto& list = std::get<RawValue::List>(value.value);
  return {number_of(list.at(0), read, dimension::length) / length,
          number_of(list.at(1), read, dimension::length) / length};
}

/// Convex, corners in either direction.
bool holds(const std::vector<Vec2>& polygon, Vec2 p) {
  bool left = false;
  bool right = false;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2 a = polygon[i];
    const double side = cross(polygon[(i + 1) % polygon.size()] - a, p - a);
    left = left || side > 0.0;
    right = right || side < 0.0;
  }
  return !(left && right);
}

bool is_solid(const Body& body, Vec2 p) {
  const auto in = [&](const std::vector<Vec2>& polygon) { return holds(polygon, p); };
  return std::any_of(body.solid.begin(), body.solid.end(), in) &&
         std::none_of(body.hollow.begin(), body.hollow.end(), in);
}

}  // namespace

double Body::distance(Vec2 p, Vec2& normal) const {
  if (half_plane) {
    normal = lines[0][1];
    return dot(normal, p - lines[0][0]);
  }
  double nearest = infinity;
  double winding = 0.0;
  Vec2 outward{1.0, 0.0};
  for (const std::vector<Vec2>& line : lines) {
    for (std::size_t i = 0; i < line.size(); ++i) {
      const Vec2 a = line[i];
      const Vec2 b = line[(i + 1) % line.size()];
      const Vec2 along = b - a;
      const double square = dot(along, along);
      const double t = square > 0.0 ? std::clamp(dot(p - a, along) / square, 0.0, 1.0) : 0.0;
      const Vec2 away = p - a - t * along;
      if (norm(away) < nearest) {
        nearest = norm(away);
        normal = nearest > 0.0 ? (1.0 / nearest) * away : Vec2{1.0, 0.0};
        outward = square > 0.0 ? (-1.0 / std::sqrt(square)) * turned(along) : normal;
      }
      if (line.size() > 2) winding += std::atan2(cross(a - p, b - p), dot(a - p, b - p));
    }
  }
  if (solid.empty() ? std::abs(winding) < 1.0 : !is_solid(*this, p)) return nearest;
  normal = nearest > 0.0 ? -normal : outward;
  return -nearest;
}

namespace {

/// The corners of a polygon, cut into its outlines.
std::vector<std::vector<Vec2>> outlines_of(const ObstacleSpec& spec, const QuantityReader& read, double length) {
  const auto& corners = std::get<RawValue::List>(spec.options.at("vertices").value);
  std::vector<std::size_t> sizes{corners.size()};
  if (const auto given = spec.options.find("outlines"); given != spec.options.end()) {
    sizes.clear();
    for (const RawValue& size : std::get<RawValue::List>(given->second.value)) {
      sizes.push_back(static_cast<std::size_t>(number_of(size, read, dimension::none)));
    }
  }
  std::vector<std::vector<Vec2>> lines;
  std::size_t at = 0;
  int bodies = 0;
  for (const std::size_t size : sizes) {
    std::vector<Vec2> line;
    line.reserve(size);
    for (std::size_t i = 0; i < size; ++i) line.push_back(point_of(corners.at(at++), read, length));
    double area = 0.0;
    for (std::size_t i = 0; i < size; ++i) area += cross(line[i], line[(i + 1) % size]);
    if (area < 0.0 && sizes.size() == 1) std::reverse(line.begin(), line.end());
    bodies += area > 0.0 ? 1 : 0;
    lines.push_back(std::move(line));
  }
  if (bodies > 1) throw Error("no geometry is known here for a polygon in parts");
  return lines;
}

/// A line with its half widths (docs/obstacles.md): corners of up to 30 degrees are mitred, around others runs a
/// polygon around the circle, a corner for each 15 degrees.
struct Strip {
  std::vector<Vec2> points;
  std::vector<double> half;

  Vec2 along(std::size_t side) const {
    const Vec2 way = points[side + 1] - points[side];
    return (1.0 / norm(way)) * way;
  }
  /// As convex polygons, each half width larger by `more`, the ends farther out.
  std::vector<std::vector<Vec2>> polygons(double more, double before, double after) const {
    constexpr double pi = 3.14159265358979323846;
    std::vector<std::vector<Vec2>> all;
    const std::size_t sides = points.size() - 1;
    const auto mitred = [&](std::size_t i) { return dot(along(i - 1), along(i)) >= std::cos(pi / 6.0); };
    const auto width_at = [&](std::size_t side, std::size_t i) {
      const Vec2 square = (half[i] + more) * turned(along(side));
      if (i == 0 || i == sides || !mitred(i)) return square;
      const Vec2 middle = along(i - 1) + along(i);
      const Vec2 normal = turned((1.0 / norm(middle)) * middle);
      return ((half[i] + more) / dot(normal, turned(along(i)))) * normal;
    };
    for (std::size_t i = 0; i < sides; ++i) {
      const Vec2 from = points[i] - (i == 0 ? before : 0.0) * along(i);
      const Vec2 to = points[i + 1] + (i + 1 == sides ? after : 0.0) * along(i);
      // Beyond its ends it goes on widening as it does, down to a tenth.
      const double growth = (half[i + 1] - half[i]) / norm(points[i + 1] - points[i]);
      const auto share = [&](double way, double at) { return std::max(0.1, 1.0 + way * growth / (at + more)); };
      const Vec2 a = share(i == 0 ? -before : 0.0, half[i]) * width_at(i, i);
      const Vec2 b = share(i + 1 == sides ? after : 0.0, half[i + 1]) * width_at(i, i + 1);
      all.push_back({from + a, from - a, to - b, to + b});
    }
    for (std::size_t i = 1; i < sides; ++i) {
      if (mitred(i)) continue;
      const double turn = std::atan2(cross(along(i - 1), along(i)), dot(along(i - 1), along(i)));
      const double reach = (turn > 0.0 ? -1.0 : 1.0) * (half[i] + more);
      const int count = static_cast<int>(std::ceil(std::abs(turn) / (pi / 12.0)));
      std::vector<Vec2> fan{points[i], points[i] + reach * turned(along(i - 1))};
      for (int k = 0; k < count; ++k) {
        const double angle = (k + 0.5) * turn / count;
        const Vec2 out = std::cos(angle) * turned(along(i - 1)) - std::sin(angle) * along(i - 1);
        fan.push_back(points[i] + (reach / std::cos(0.5 * turn / count)) * out);
      }
      fan.push_back(points[i] + reach * turned(along(i)));
      all.push_back(std::move(fan));
    }
    return all;
  }
};

/// All sides of all polygons, cut where they cross others, as far as they bound the body.
void find_boundary(Body& body) {
  std::vector<std::pair<Vec2, Vec2>> sides;
  for (const auto* polygons : {&body.solid, &body.hollow}) {
    for (const std::vector<Vec2>& polygon : *polygons) {
      for (std::size_t i = 0; i < polygon.size(); ++i)
        sides.emplace_back(polygon[i], polygon[(i + 1) % polygon.size()]);
    }
  }
  for (const auto& [a, b] : sides) {
    const Vec2 along = b - a;
    std::vector<double> cuts{0.0, 1.0};
    for (const auto& [c, d] : sides) {
      const double denominator = cross(along, d - c);
      if (denominator != 0.0) cuts.push_back(std::clamp(cross(c - a, d - c) / denominator, 0.0, 1.0));
      for (const Vec2 end : {c, d}) cuts.push_back(std::clamp(dot(end - a, along) / dot(along, along), 0.0, 1.0));
    }
    std::sort(cuts.begin(), cuts.end());
    for (std::size_t i = 1; i < cuts.size(); ++i) {
      if (cuts[i] - cuts[i - 1] < 1e-12) continue;
      const Vec2 from = a + cuts[i - 1] * along;
      const Vec2 to = a + cuts[i] * along;
      const Vec2 left = (1e-9 / norm(along)) * turned(along);
      const bool on_left = is_solid(body, 0.5 * (from + to) + left);
      if (on_left == is_solid(body, 0.5 * (from + to) - left)) continue;
      body.lines.push_back(on_left ? std::vector<Vec2>{from, to} : std::vector<Vec2>{to, from});
    }
  }
}

void build_channel(Body& body, const ObstacleSpec& spec, const QuantityReader& read, double length) {
  const auto real = [&](const RawValue& value) { return number_of(value, read, dimension::length) / length; };
  const auto given = [&](const char* name) { return spec.options.contains(name); };
  Strip strip;
  for (const RawValue& p : std::get<RawValue::List>(spec.options.at("points").value))
    strip.points.push_back(point_of(p, read, length));
  strip.half.assign(strip.points.size(), given("width") ? 0.5 * real(spec.options.at("width")) : 0.0);
  if (given("widths")) {
    const auto& widths = std::get<RawValue::List>(spec.options.at("widths").value);
    for (std::size_t i = 0; i < strip.half.size(); ++i) strip.half[i] = 0.5 * real(widths.at(i));
  }
  const auto [least, most] = std::minmax_element(strip.half.begin(), strip.half.end());
  body.radius = given("rounding") ? real(spec.options.at("rounding")) : 0.2 * *least;
  const double wall = (given("wall") ? real(spec.options.at("wall")) : 2.0 * *most) - body.radius;
  const std::string closed = given("closed") ? std::get<std::string>(spec.options.at("closed").value) : "none";
  body.solid = strip.polygons(wall, closed == "start" || closed == "both" ? wall : 0.0,
                              closed == "end" || closed == "both" ? wall : 0.0);
  body.hollow = strip.polygons(body.radius, body.radius, body.radius);
  find_boundary(body);
}

}  // namespace

Body body_of(const ObstacleSpec& spec, const QuantityReader& read, double length) {
  if (spec.place.moves()) throw Error("no geometry is known here for an obstacle that was moved");
  const auto at = [&](const char* name) { return point_of(spec.options.at(name), read, length); };
  const auto real = [&](const char* name) {
    return number_of(spec.options.at(name), read, dimension::length) / length;
  };
  Body body;
  if (spec.shape == "circle") {
    body.lines = {{at("center")}};
    body.radius = real("radius");
  } else if (spec.shape == "wall") {
    const auto angle = spec.options.find("angle");
    const double direction = angle == spec.options.end() ? 0.0 : number_of(angle->second, read, dimension::angle);
    const Vec2 normal =
        angle == spec.options.end() ? at("normal") : turned(Vec2{std::cos(direction), std::sin(direction)});
    body.lines = {{at("point"), (1.0 / norm(normal)) * normal}};
    body.half_plane = true;
  } else if (spec.shape == "capsule") {
    body.lines = {{at("from"), at("to")}};
    body.radius = real("radius");
  } else if (spec.shape == "polygon") {
    body.lines = outlines_of(spec, read, length);
    body.radius = real("rounding");
  } else if (spec.shape == "channel") {
    build_channel(body, spec, read, length);
  } else {
    throw Error("no geometry is known here for the shape '" + spec.shape + "'");
  }
  body.size = 1.0 + body.radius;
  for (const std::vector<Vec2>& line : body.lines) {
    for (const Vec2& p : line) body.size = std::max(body.size, norm(p));
  }
  return body;
}

}  // namespace tendril::bench
