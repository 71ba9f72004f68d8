#include "figure/outlines.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace tendril::app {

namespace {

/// Points that a shape is asked for: corners of rounded convex shapes, and those of parts from drawings.
constexpr std::size_t convex_points = 361, part_points = 2401;

/// A part's outline is one line along all of its own, with ways there and back between them. Each of its own begins
/// and ends at the same point of the surface, which those between do not lie on.
std::vector<ClosedLine> parted(const Obstacle& obstacle, const ClosedLine& whole) {
  constexpr double on_surface = 1e-8;
  if (std::none_of(whole.begin() + 1, whole.end(), [&](Vec2 p) { return p == whole[0]; })) return {whole};
  std::vector<ClosedLine> lines;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    if (std::abs(obstacle.at(whole[i]).distance) > on_surface) continue;
    std::size_t end = i + 1;
    while (end < whole.size() && !(whole[end] == whole[i])) ++end;
    if (end == whole.size()) continue;
    if (end - i > 2)
      lines.emplace_back(whole.begin() + static_cast<std::ptrdiff_t>(i),
                         whole.begin() + static_cast<std::ptrdiff_t>(end));
    i = end;
  }
  if (lines.empty()) lines.push_back(whole);
  return lines;
}

/// Without points on a straight line between others.
ClosedLine without_spare(const ClosedLine& line) {
  constexpr double straight = 1e-9;
  ClosedLine kept;
  kept.reserve(line.size());
  for (std::size_t i = 0; i < line.size(); ++i) {
    const Vec2 before = line[i] - (kept.empty() ? line.back() : kept.back());
    const Vec2 after = line[(i + 1) % line.size()] - line[i];
    const double size = norm(before) * norm(after);
    if (size > 0.0 && (std::abs(cross(before, after)) > straight * size || dot(before, after) < 0.0))
      kept.push_back(line[i]);
  }
  return kept.size() < 3 ? line : kept;
}

/// Of a large shape little is in sight: there its outline gets points of the surface until it follows it.
void refine(const Obstacle& obstacle, const Box& box, Vec2 a, Vec2 b, int depth, ClosedLine& line) {
  constexpr double close = 2e-4;  // of the box's diagonal
  constexpr int deepest = 24;
  line.push_back(a);
  const Vec2 middle = a + 0.5 * (b - a);
  const SurfacePoint surface = obstacle.at(middle);
  const double off = std::abs(surface.distance);
  if (depth == deepest || !(off > close * norm(box.size())) || !(off < norm(b - a)) || !box.may_meet(a, b, off)) return;
  const Vec2 on = middle - surface.distance * surface.normal;
  line.pop_back();
  refine(obstacle, box, a, on, depth + 1, line);
  refine(obstacle, box, on, b, depth + 1, line);
}

ClosedLine refined(const Obstacle& obstacle, const Box& box, ClosedLine line) {
  // Points between corners of the outline lie on chords.
  for (Vec2& p : line) {
    const SurfacePoint surface = obstacle.at(p);
    p = p - surface.distance * surface.normal;
  }
  ClosedLine all;
  for (std::size_t i = 0; i < line.size(); ++i) refine(obstacle, box, line[i], line[(i + 1) % line.size()], 0, all);
  return all;
}

}  // namespace

ClosedLine cut_off(const Box& box, ClosedLine line) {
  if (std::all_of(line.begin(), line.end(), [&](Vec2 p) { return box.contains(p); })) return line;
  // Side after side (Sutherland and Hodgman 1974).
  for (int side = 0; side < 4; ++side) {
    const auto inside = [&](Vec2 p) {
      return side == 0   ? p.x - box.low.x
             : side == 1 ? box.high.x - p.x
             : side == 2 ? p.y - box.low.y
                         : box.high.y - p.y;
    };
    ClosedLine kept;
    for (std::size_t i = 0; i < line.size(); ++i) {
      const Vec2 a = line[i];
      const Vec2 b = line[(i + 1) % line.size()];
      const double from = inside(a);
      const double to = inside(b);
      if (from >= 0.0) kept.push_back(a);
      if ((from < 0.0) != (to < 0.0)) kept.push_back(a + from / (from - to) * (b - a));
    }
    line = std::move(kept);
  }
  return line;
}

std::vector<ClosedLine> outlines_of(const Obstacle& obstacle, Vec2 low, Vec2 high) {
  ClosedLine whole(obstacle.convex() ? convex_points : part_points);
  obstacle.outline(whole, low, high);
  for (const Vec2 p : whole) {
    if (!std::isfinite(p.x) || !std::isfinite(p.y)) return {};
  }
  std::vector<ClosedLine> lines = obstacle.convex() ? std::vector<ClosedLine>{whole} : parted(obstacle, whole);
  // What is cut off lies out of sight.
  const Box box{low - (high - low), high + (high - low)};
  for (ClosedLine& line : lines) {
    // Lines of unbounded shapes also go through the body, where these are cut off.
    if (obstacle.convex() && std::isfinite(obstacle.smallest_radius())) line = refined(obstacle, box, std::move(line));
    line = without_spare(cut_off(box, std::move(line)));
  }
  std::erase_if(lines, [](const ClosedLine& line) { return line.empty(); });
  return lines;
}

ClosedLine circle_outline(Vec2 center, double radius) {
  constexpr int corners = 180;
  ClosedLine line;
  line.reserve(corners);
  for (int i = 0; i < corners; ++i) {
    const double turn = 2.0 * std::numbers::pi * i / corners;
    line.push_back(center + radius * Vec2{std::cos(turn), std::sin(turn)});
  }
  return line;
}

ClosedLine joined(const std::vector<ClosedLine>& outlines) {
  ClosedLine all;
  for (const ClosedLine& line : outlines) {
    all.insert(all.end(), line.begin(), line.end());
    if (!line.empty()) all.push_back(line[0]);
  }
  for (std::size_t i = outlines.size(); i-- > 1;) {
    if (!outlines[i - 1].empty()) all.push_back(outlines[i - 1][0]);
  }
  return all;
}

}  // namespace tendril::app
