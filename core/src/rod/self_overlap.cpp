#include "rod/self_overlap.hpp"

#include <algorithm>
#include <cmath>

namespace tendril {
namespace {

constexpr double touching = 1e-9;  ///< share of a chord: what is nearer than that to its end or side lies on it

/// Shares of both chords at which a-b and c-d meet.
std::optional<std::pair<double, double>> meeting(Vec2 a, Vec2 b, Vec2 c, Vec2 d) {
  const Vec2 first = b - a;
  const Vec2 second = d - c;
  const Vec2 between = c - a;
  const double area = cross(first, second);
  const double size = norm(first) * norm(second);
  const auto inside = [](double t) { return t >= -touching && t <= 1.0 + touching; };
  if (std::abs(area) > touching * size) {
    const double t = cross(between, second) / area;
    const double u = cross(between, first) / area;
    if (inside(t) && inside(u)) return std::pair(std::clamp(t, 0.0, 1.0), std::clamp(u, 0.0, 1.0));
    return std::nullopt;
  }
  // Parallel: they meet only if one lies on the other.
  const double square = dot(first, first);
  if (!(square > 0.0) || std::abs(cross(first, between)) > touching * square) return std::nullopt;
  double from = dot(between, first) / square;
  double to = dot(d - a, first) / square;
  const bool opposite = from > to;
  if (opposite) std::swap(from, to);
  const double t = std::max(0.0, from);
  if (t > std::min(1.0, to) + touching) return std::nullopt;
  const double u = to > from ? (t - from) / (to - from) : 0.0;
  return std::pair(std::clamp(t, 0.0, 1.0), std::clamp(opposite ? 1.0 - u : u, 0.0, 1.0));
}

}  // namespace

std::vector<BackbonePoint> body_outline(std::span<const BackbonePoint> backbone, const BodyRadius& radius) {
  std::vector<BackbonePoint> out;
  out.reserve(2 * backbone.size());
  const auto add = [&](const BackbonePoint& p, double side) {
    const double r = side * radius(p.s);
    out.push_back({p.s, p.x - r * std::sin(p.angle), p.y + r * std::cos(p.angle), p.angle, p.curvature});
  };
  for (const BackbonePoint& p : backbone) add(p, 1.0);
  for (auto p = backbone.rbegin(); p != backbone.rend(); ++p) add(*p, -1.0);
  return out;
}

std::optional<std::pair<double, double>> self_overlap(std::span<const BackbonePoint> backbone,
                                                      const BodyRadius& radius) {
  // A curve whose tangent turns by less than half a turn moves on along some direction all the time, and its sides do
  // where it bends less than its body is thick.
  const auto by_angle = [](const BackbonePoint& a, const BackbonePoint& b) { return a.angle < b.angle; };
  const auto [least, most] = std::minmax_element(backbone.begin(), backbone.end(), by_angle);
  if (least == backbone.end()) return std::nullopt;
  const bool folds = radius && std::any_of(backbone.begin(), backbone.end(), [&](const BackbonePoint& p) {
                       return std::abs(p.curvature) * radius(p.s) > 1.0;
                     });
  if (most->angle - least->angle < 3.0 && !folds) return std::nullopt;
  const std::vector<BackbonePoint> sides = radius ? body_outline(backbone, radius) : std::vector<BackbonePoint>{};
  const std::span<const BackbonePoint> line = radius ? sides : backbone;
  const auto point = [&](std::size_t i) { return line[i].position(); };
  const auto arc = [&](std::size_t i, double t) { return line[i].s + t * (line[i + 1].s - line[i].s); };
  for (std::size_t later = 2; later + 1 < line.size(); ++later) {
    for (std::size_t earlier = 0; earlier + 2 <= later; ++earlier) {
      const auto met = meeting(point(earlier), point(earlier + 1), point(later), point(later + 1));
      if (met) return std::minmax(arc(earlier, met->first), arc(later, met->second));
    }
  }
  return std::nullopt;
}

std::optional<std::pair<double, double>> meeting_of(std::span<const BackbonePoint> a,
                                                    std::span<const BackbonePoint> b) {
  const auto point = [](const BackbonePoint& p) { return p.position(); };
  const auto arc = [](std::span<const BackbonePoint> rod, std::size_t i, double t) {
    return rod[i].s + t * (rod[i + 1].s - rod[i].s);
  };
  for (std::size_t i = 0; i + 1 < a.size(); ++i) {
    for (std::size_t k = 0; k + 1 < b.size(); ++k) {
      const auto met = meeting(point(a[i]), point(a[i + 1]), point(b[k]), point(b[k + 1]));
      if (met) return std::pair(arc(a, i, met->first), arc(b, k, met->second));
    }
  }
  return std::nullopt;
}

}  // namespace tendril
