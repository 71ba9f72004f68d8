#include "obstacle/rounded_hull.hpp"

#include <algorithm>
#include <cmath>

#include "obstacle/outline.hpp"
#include "obstacle/surface.hpp"
#include "tendril/error.hpp"
#include "tendril/numbers.hpp"

namespace tendril {

RoundedHull::RoundedHull(std::vector<Vec2> corners, double rounding) : rounding_(rounding) {
  if (!(rounding > 0.0) || !std::isfinite(rounding)) throw Error("a rounded shape needs a positive, finite radius");
  const std::size_t n = corners.size();
  if (n < 2) throw Error("a rounded shape needs at least two corners");
  for (std::size_t i = 0; i < n; ++i) {
    const Vec2 side = corners[(i + 1) % n] - corners[i];
    const double length = norm(side);
    if (!(length > 0.0) || !std::isfinite(length)) throw Error("corners of a rounded shape must be finite and differ");
    const Vec2 along = (1.0 / length) * side;
    edges_.push_back({corners[i], along, -turned(along), length});
  }
  seams_.resize(2 * n);
  for (std::size_t i = 0; i < n; ++i) {
    const Edge& edge = edges_[i];
    const Edge& before = edges_[(i + n - 1) % n];
    const double begin = dot(edge.along, edge.from);
    seams_[i] = {Seam{edge.along, begin}, Seam{-edge.along, -begin - edge.length}};
    seams_[n + i] = {Seam{-edge.along, -begin}, Seam{before.along, dot(before.along, edge.from)}};
  }
  // Relative to the first corner: a small polygon far from the origin would else lose its digits.
  double area = 0.0;
  Vec2 moment{};
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const Vec2 a = corners[i] - corners[0];
    const Vec2 b = corners[i + 1] - corners[0];
    area += cross(a, b);
    moment += (cross(a, b) / 3.0) * (a + b);
  }
  if (n > 2 && !(area > 0.0)) throw Error("corners of a rounded polygon must run counterclockwise");
  reference_ = n == 2 ? 0.5 * (corners[0] + corners[1]) : corners[0] + (1.0 / area) * moment;
}

RoundedHull::~RoundedHull() = default;

int RoundedHull::patch_at(Vec2 point) const {
  const std::size_t n = edges_.size();
  std::size_t highest = 0;
  double height = -infinity;
  std::size_t nearest = 0;
  double square = infinity;
  for (std::size_t i = 0; i < n; ++i) {
    const Edge& edge = edges_[i];
    const Vec2 out = point - edge.from;
    const double above = dot(edge.normal, out);
    const double along = dot(edge.along, out);
    if (above >= 0.0 && along >= 0.0 && along <= edge.length) return static_cast<int>(i);
    if (above > height) {
      height = above;
      highest = i;
    }
    if (const double s = dot(out, out); s < square) {
      square = s;
      nearest = i;
    }
  }
  // Below every edge is inside of the core, where the nearest edge is the highest one.
  return static_cast<int>(height < 0.0 ? highest : n + nearest);
}

SurfacePoint RoundedHull::on_patch(int patch, Vec2 point) const {
  const std::size_t n = edges_.size();
  const auto i = static_cast<std::size_t>(patch);
  if (i < n) return {dot(edges_[i].normal, point - edges_[i].from) - rounding_, edges_[i].normal, 0.0, 0.0};
  const Edge& edge = edges_[i - n];
  return beside_corner(point - edge.from, edge.normal, rounding_);
}

double RoundedHull::core_distance(Vec2 point) const { return std::max(0.0, at(point).distance + rounding_); }

void RoundedHull::bounding_box(Vec2& low, Vec2& high) const {
  low = high = edges_.front().from;
  for (const Edge& edge : edges_) {
    low = {std::min(low.x, edge.from.x), std::min(low.y, edge.from.y)};
    high = {std::max(high.x, edge.from.x), std::max(high.y, edge.from.y)};
  }
  low = low - Vec2{rounding_, rounding_};
  high = high + Vec2{rounding_, rounding_};
}

void RoundedHull::outline(std::span<Vec2> points, Vec2, Vec2) const {
  const std::size_t n = edges_.size();
  constexpr int steps = 24;  // per corner: 15 degrees at most
  std::vector<Vec2> line;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec2 first = edges_[(i + n - 1) % n].normal;
    const double turn = std::atan2(cross(first, edges_[i].normal), dot(first, edges_[i].normal));
    // Opposite normals have no shorter way: the end of a capsule is a half circle, counterclockwise.
    const double angle = turn > 0.0 ? turn : std::abs(turn);
    for (int k = 0; k <= steps; ++k) {
      const double a = angle * k / steps;
      line.push_back(edges_[i].from + rounding_ * (std::cos(a) * first + std::sin(a) * turned(first)));
    }
  }
  spread_outline(line, points);
}

}  // namespace tendril
