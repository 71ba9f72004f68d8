#include "check/body.hpp"

#include <algorithm>
#include <cmath>

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
  if (std::abs(winding) < 1.0) return nearest;
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
