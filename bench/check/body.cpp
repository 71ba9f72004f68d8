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
    normal = core[1];
    return dot(core[1], p - core[0]);
  }
  double nearest = infinity;
  bool inside = core.size() > 2;
  double shallow = -infinity;
  Vec2 inner{};
  for (std::size_t i = 0; i < core.size(); ++i) {
    const Vec2 a = core[i];
    const Vec2 along = core[(i + 1) % core.size()] - a;
    const double square = dot(along, along);
    const double t = square > 0.0 ? std::clamp(dot(p - a, along) / square, 0.0, 1.0) : 0.0;
    const Vec2 away = p - a - t * along;
    if (norm(away) < nearest) {
      nearest = norm(away);
      normal = nearest > 0.0 ? (1.0 / nearest) * away : Vec2{1.0, 0.0};
    }
    if (core.size() > 2) {
      const Vec2 out = (-1.0 / std::sqrt(square)) * turned(along);
      const double level = dot(out, p - a);
      inside = inside && level < 0.0;
      if (level > shallow) {
        shallow = level;
        inner = out;
      }
    }
  }
  if (!inside) return nearest;
  normal = inner;
  return shallow;
}

Body body_of(const ObstacleSpec& spec, const QuantityReader& read, double length) {
  const auto at = [&](const char* name) { return point_of(spec.options.at(name), read, length); };
  const auto real = [&](const char* name) {
    return number_of(spec.options.at(name), read, dimension::length) / length;
  };
  Body body;
  if (spec.shape == "circle") {
    body.core = {at("center")};
    body.radius = real("radius");
  } else if (spec.shape == "wall") {
    const auto angle = spec.options.find("angle");
    const double direction = angle == spec.options.end() ? 0.0 : number_of(angle->second, read, dimension::angle);
    const Vec2 normal =
        angle == spec.options.end() ? at("normal") : turned(Vec2{std::cos(direction), std::sin(direction)});
    body.core = {at("point"), (1.0 / norm(normal)) * normal};
    body.half_plane = true;
  } else if (spec.shape == "capsule") {
    body.core = {at("from"), at("to")};
    body.radius = real("radius");
  } else if (spec.shape == "polygon") {
    for (const RawValue& corner : std::get<RawValue::List>(spec.options.at("vertices").value)) {
      body.core.push_back(point_of(corner, read, length));
    }
    double area = 0.0;
    for (std::size_t i = 0; i < body.core.size(); ++i)
      area += cross(body.core[i], body.core[(i + 1) % body.core.size()]);
    if (area < 0.0) std::reverse(body.core.begin(), body.core.end());
    body.radius = real("rounding");
  } else {
    throw Error("no geometry is known here for the shape '" + spec.shape + "'");
  }
  body.size = 1.0 + body.radius;
  for (const Vec2& p : body.core) body.size = std::max(body.size, norm(p));
  return body;
}

}  // namespace tendril::bench
