#include "figure/backbones.hpp"

#include <algorithm>
#include <cmath>

namespace tendril::app {

std::vector<BackbonePoint> backbone_of(const Reader& state, const std::string& name) {
  std::vector<BackbonePoint> backbone;
  for (const Reader& entry : state.member(name).list()) {
    const std::vector<double> p = entry.reals();
    if (p.size() != 5) entry.fail("five numbers: s, x, y, angle, curvature");
    backbone.push_back({p[0], p[1], p[2], p[3], p[4]});
  }
  return backbone;
}

/// Half the diameters that a state lists for its points, between these in proportion; empty: it has no body.
BodyRadius radius_of(const Reader& state) {
  const auto thickness = state.optional("thickness");
  if (!thickness) return {};
  std::vector<std::pair<double, double>> known;  // arc length, radius
  const std::vector<BackbonePoint> backbone = backbone_of(state);
  const std::vector<double> diameters = thickness->reals();
  if (diameters.size() != backbone.size() || backbone.empty())
    thickness->fail("a number for each point of the backbone");
  known.reserve(backbone.size());
  for (std::size_t i = 0; i < backbone.size(); ++i) known.emplace_back(backbone[i].s, 0.5 * diameters[i]);
  return [known](double s) {
    const auto above = std::lower_bound(known.begin(), known.end(), s,
                                        [](const auto& point, double value) { return point.first < value; });
    if (above == known.begin()) return known.front().second;
    if (above == known.end()) return known.back().second;
    const auto below = above - 1;
    const double share = (s - below->first) / (above->first - below->first);
    return below->second + share * (above->second - below->second);
  };
}

std::vector<Vec2> line_of(const std::vector<BackbonePoint>& backbone) {
  std::vector<Vec2> line;
  line.reserve(backbone.size());
  for (const BackbonePoint& p : backbone) line.push_back(p.position());
  return line;
}

/// Across the normal of a contact, in the direction in which arc lengths grow.
Vec2 tangent_at(const std::vector<BackbonePoint>& backbone, double arc_length, Vec2 normal) {
  const auto above = std::find_if(backbone.begin(), backbone.end(), [&](const auto& p) { return p.s >= arc_length; });
  const double angle = backbone.empty() ? 0.0 : above == backbone.end() ? backbone.back().angle : above->angle;
  const Vec2 tangent = turned(normal);
  return dot(tangent, {std::cos(angle), std::sin(angle)}) < 0.0 ? -tangent : tangent;
}

std::vector<Vec2> points_in(const Reader& list) {
  std::vector<Vec2> points;
  for (const Reader& entry : list.list()) points.push_back(entry.point());
  return points;
}

/// The first backbone or line of a result, for the length of its rod.
double length_of(const Reader& result) {
  for (const char* list : {"cases", "steps"}) {
    if (!result.has(list)) continue;
    for (const Reader& one : result.member(list).list()) {
      if (const double length = length_of(one); length > 0.0) return length;
    }
    return 0.0;
  }
  if (const auto plan = result.optional("plan")) return length_of(*plan);
  if (!result.has("backbone")) return 0.0;
  const std::vector<BackbonePoint> backbone = backbone_of(result);
  return backbone.empty() ? 0.0 : backbone.back().s;
}

}  // namespace tendril::app
