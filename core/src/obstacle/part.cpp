#include "obstacle/part.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "obstacle/outline.hpp"
#include "obstacle/surface.hpp"
#include "tendril/error.hpp"
#include "tendril/numbers.hpp"

namespace tendril {

Part::Part(const std::vector<ClosedLine>& lines, double rounding) : rounding_(rounding) {
  if (!(rounding > 0.0) || !std::isfinite(rounding)) throw Error("a rounded part needs a positive, finite radius");
  double area = 0.0;
  Vec2 moment{};
  for (const ClosedLine& line : lines) {
    const std::size_t n = line.size();
    const auto first = static_cast<int>(edges_.size());
    firsts_.push_back(first);
    for (std::size_t i = 0; i < n; ++i) {
      const Vec2 side = line[(i + 1) % n] - line[i];
      const double length = norm(side);
      if (!(length > 0.0) || !std::isfinite(length)) throw Error("corners of a part must be finite and differ");
      const Vec2 along = (1.0 / length) * side;
      edges_.push_back({line[i], along, -turned(along), length, first + static_cast<int>((i + 1) % n), false});
      const Vec2 a = line[i] - lines[0][0];
      const Vec2 b = a + side;
      area += cross(a, b);
      moment += (cross(a, b) / 3.0) * (a + b);
    }
  }
  if (!(area > 0.0)) throw Error("lines around a part must have it on their left");
  for (const Edge& before : edges_) {
    Edge& after = edges_[static_cast<std::size_t>(before.next)];
    after.inward = cross(before.along, after.along) < 0.0;
  }
  std::vector<const Edge*> before(edges_.size());
  for (const Edge& e : edges_) before[static_cast<std::size_t>(e.next)] = &e;
  for (const Edge& e : edges_) {
    seams_from_.push_back(seams_.size());
    const double begin = dot(e.along, e.from);
    if (!e.inward) seams_.push_back({e.along, begin});
    if (!edge(e.next).inward) seams_.push_back({-e.along, -begin - e.length});
  }
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    seams_from_.push_back(seams_.size());
    const Edge& e = edges_[i];
    if (e.inward) continue;
    seams_.push_back({-e.along, -dot(e.along, e.from)});
    seams_.push_back({before[i]->along, dot(before[i]->along, e.from)});
  }
  seams_from_.push_back(seams_.size());
  tree_ = tree_of_edges();
  reference_ = lines[0][0] + (1.0 / area) * moment;
  const SurfacePoint nearest = at(reference_);
  if (nearest.distance > -rounding_) reference_ = reference_ - (nearest.distance + rounding_) * nearest.normal;
}

Part::~Part() = default;

BoxTree Part::tree_of_edges() const {
  std::vector<Box> boxes(edges_.size());
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    boxes[i].add(edges_[i].from);
    boxes[i].add(edge(edges_[i].next).from);
  }
  return BoxTree(boxes);
}

int Part::patch_at(Vec2 point) const {
  const auto n = static_cast<int>(edges_.size());
  int patch = n;
  tree_.nearest(point, infinity, [&](int i, double& best) {
    const Edge& e = edge(i);
    const Vec2 out = point - e.from;
    const double along = dot(e.along, out);
    const double above = dot(e.normal, out);
    // At its ends a side is no farther away than a corner there, and goes before it.
    if (along >= 0.0 && along <= e.length) {
      if (above * above > best || (above * above == best && patch < n)) return;
      best = above * above;
      patch = i;
      return;
    }
    const int corner = along < 0.0 ? i : e.next;
    const Vec2 away = point - edge(corner).from;
    const double square = dot(away, away);
    if (square >= best) return;
    best = square;
    patch = n + corner;
  });
  return patch;
}

SurfacePoint Part::on_patch(int patch, Vec2 point) const {
  const auto n = static_cast<int>(edges_.size());
  const Edge& e = edge(patch < n ? patch : patch - n);
  const Vec2 out = point - e.from;
  if (patch < n) return {dot(e.normal, out) - rounding_, e.normal, 0.0, 0.0};
  const SurfacePoint corner = beside_corner(out, e.inward ? -e.normal : e.normal, e.inward ? 0.0 : rounding_);
  if (!e.inward) return corner;
  // What is nearest to a corner that turns inward lies in the body.
  return {-corner.distance - rounding_, -corner.normal, -corner.curvature, 0.0};
}

std::span<const Seam> Part::seams(int patch) const {
  const std::size_t from = seams_from_[static_cast<std::size_t>(patch)];
  return {seams_.data() + from, seams_from_[static_cast<std::size_t>(patch) + 1] - from};
}

double Part::core_distance(Vec2 point) const { return std::max(0.0, at(point).distance + rounding_); }

bool Part::separates(Vec2 a, Vec2 b) const {
  return std::any_of(edges_.begin(), edges_.end(),
                     [&](const Edge& e) { return cross_inside(a, b, e.from, edge(e.next).from); });
}

void Part::bounding_box(Vec2& low, Vec2& high) const {
  Box box;
  for (const Edge& e : edges_) box.add(e.from);
  low = box.low - Vec2{rounding_, rounding_};
  high = box.high + Vec2{rounding_, rounding_};
}

void Part::draw(int first, std::vector<Vec2>& line) const {
  constexpr double step = std::numbers::pi / 24.0;
  int i = first;
  do {
    const Edge& before = edge(i);
    const Edge& e = edge(before.next);
    const double turn = std::atan2(cross(before.normal, e.normal), dot(before.normal, e.normal));
    if (turn < 0.0) {
      // The sides meet where both are the rounding away, unless they are too short for that.
      const Vec2 middle = e.from + (rounding_ / (1.0 + dot(before.normal, e.normal))) * (before.normal + e.normal);
      if (at(middle).distance > -1e-9) line.push_back(middle);
    } else {
      const int steps = std::max(1, static_cast<int>(std::ceil(turn / step)));
      for (int k = 0; k <= steps; ++k) {
        const double a = turn * k / steps;
        const Vec2 p = e.from + rounding_ * (std::cos(a) * before.normal + std::sin(a) * turned(before.normal));
        if (at(p).distance > -1e-9) line.push_back(p);
      }
    }
    i = before.next;
  } while (i != first);
}

void Part::outline(std::span<Vec2> points, Vec2, Vec2) const {
  std::vector<std::vector<Vec2>> lines;
  std::size_t corners = 0;
  for (const int first : firsts_) {
    std::vector<Vec2> line;
    draw(first, line);
    if (line.empty()) continue;
    // To its end, and the way back to the line before.
    corners += line.size() + 2;
    lines.push_back(std::move(line));
  }
  std::vector<Vec2> all;
  for (const std::vector<Vec2>& line : lines) {
    // Where there is no room for all corners, every line goes without the same share of its own.
    std::size_t kept = line.size();
    if (corners > points.size()) kept = std::max<std::size_t>(3, kept * points.size() / corners);
    for (std::size_t i = 0; i < kept; ++i) all.push_back(line[i * line.size() / kept]);
    if (lines.size() > 1) all.push_back(line[0]);
  }
  for (std::size_t i = lines.size(); i-- > 2;) all.push_back(lines[i - 1][0]);
  spread_outline(all, points);
}

}  // namespace tendril
