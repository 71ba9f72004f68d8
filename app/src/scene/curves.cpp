#include "scene/curves.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tendril::app {

namespace {

Vec2 middle(Vec2 a, Vec2 b) { return 0.5 * (a + b); }

std::array<Cubic, 2> halves(const Cubic& c) {
  const Vec2 a = middle(c[0], c[1]);
  const Vec2 b = middle(c[1], c[2]);
  const Vec2 d = middle(c[2], c[3]);
  const Vec2 e = middle(a, b);
  const Vec2 f = middle(b, d);
  const Vec2 m = middle(e, f);
  return {{{c[0], a, e, m}, {m, f, d, c[3]}}};
}

/// Adds corners from the beginning of a curve up to its end, which is left to the next one. A curve lies between its
/// chord and its control points, so that either of these is on the outside.
void flatten(const Cubic& c, double tolerance, int depth, Outline& out) {
  const Vec2 chord = c[3] - c[0];
  const double length = norm(chord);
  const auto left_of_chord = [&](Vec2 p) { return length > 0.0 ? cross(chord, p - c[0]) / length : 0.0; };
  const double first = left_of_chord(c[1]);
  const double second = left_of_chord(c[2]);
  const bool forth = dot(chord, c[1] - c[0]) >= 0.0 && dot(chord, c[3] - c[2]) >= 0.0 &&
                     dot(chord, c[2] - c[0]) >= dot(chord, c[1] - c[0]);
  if (std::max({norm(c[1] - c[0]), norm(c[2] - c[0]), length}) <= 1e-6 * tolerance) return out.push_back(c[0]);
  const bool flat = length > 0.0 && forth && std::max(std::abs(first), std::abs(second)) <= tolerance;
  constexpr int most_halvings = 24;
  if (!flat && depth < most_halvings) {
    for (const Cubic& half : halves(c)) flatten(half, tolerance, depth + 1, out);
    return;
  }
  out.push_back(c[0]);
  const double right = -std::min(first, second);
  if (!(right > 1e-9 * tolerance)) return;  // nothing of it lies outside of its chord
  const double bend = cross(c[1] - c[0], c[2] - c[1]);
  const double more = cross(c[2] - c[1], c[3] - c[2]);
  if (bend >= 0.0 && more >= 0.0) {
    out.push_back(c[1]);
    out.push_back(c[2]);
    return;
  }
  // It bends both ways: a step to the outside and back.
  const Vec2 out_of = (-right / length) * turned(chord);
  out.push_back(c[0] + out_of);
  out.push_back(c[3] + out_of);
}

/// Takes away slits and whiskers without width, in which a line comes back on itself: where arcs meet in a cusp both
/// have the same tangent.
Outline without_slits(const Outline& line) {
  Outline kept;
  const auto comes_back = [](Vec2 before, Vec2 at, Vec2 after) {
    const Vec2 forth = at - before;
    const Vec2 back = after - at;
    return std::abs(cross(forth, back)) <= 1e-9 * norm(forth) * norm(back) && dot(forth, back) <= 0.0;
  };
  for (const Vec2 p : line) {
    kept.push_back(p);
    while (kept.size() > 2 && comes_back(kept[kept.size() - 3], kept[kept.size() - 2], kept.back())) {
      kept.erase(kept.end() - 2);
      if (kept[kept.size() - 2] == kept.back()) kept.pop_back();
    }
  }
  // The same across the place where the line was begun.
  while (kept.size() > 3 && comes_back(kept[kept.size() - 2], kept.back(), kept.front())) {
    kept.pop_back();
    if (kept.back() == kept.front()) kept.pop_back();
  }
  while (kept.size() > 3 && comes_back(kept.back(), kept[0], kept[1])) {
    kept.erase(kept.begin());
    if (kept.back() == kept.front()) kept.erase(kept.begin());
  }
  return kept;
}

}  // namespace

Cubic straight(Vec2 from, Vec2 to) {
  return {from, from + (1.0 / 3.0) * (to - from), to + (1.0 / 3.0) * (from - to), to};
}

void add_arc(CurvedLine& line, Vec2 center, Vec2 first, Vec2 second, double from, double to) {
  constexpr double step = std::numbers::pi / 8.0;
  const int parts = std::max(1, static_cast<int>(std::ceil(std::abs(to - from) / step)));
  const double angle = (to - from) / parts;
  const double reach = 4.0 / 3.0 * std::tan(0.25 * angle);
  const auto point = [&](double a) { return center + std::cos(a) * first + std::sin(a) * second; };
  const auto slope = [&](double a) { return std::cos(a) * second - std::sin(a) * first; };
  for (int i = 0; i < parts; ++i) {
    const double a = from + i * angle;
    const double b = a + angle;
    line.push_back({point(a), point(a) + reach * slope(a), point(b) - reach * slope(b), point(b)});
  }
}

double twice_area(const CurvedLine& line) {
  double area = 0.0;
  if (line.empty()) return area;
  const Vec2 origin = line[0][0];
  Vec2 last = origin;
  for (const Cubic& c : line) {
    // The integral of cross(P, dP) over a cubic, in closed form.
    const Vec2 a = c[0] - origin;
    const Vec2 b = c[1] - origin;
    const Vec2 d = c[2] - origin;
    const Vec2 e = c[3] - origin;
    area += cross(last - origin, a);
    area += (6.0 * cross(a, b) + 3.0 * cross(a, d) + cross(a, e) + 3.0 * cross(b, d) + 3.0 * cross(b, e) +
             6.0 * cross(d, e)) /
            10.0;
    last = c[3];
  }
  return area;
}

CurvedLine reversed(const CurvedLine& line) {
  CurvedLine other;
  other.reserve(line.size());
  for (auto c = line.rbegin(); c != line.rend(); ++c) other.push_back({(*c)[3], (*c)[2], (*c)[1], (*c)[0]});
  return other;
}

Outline flattened(const CurvedLine& line, double tolerance) {
  Outline out;
  for (const Cubic& c : line) {
    if (c[0] == c[3] && c[1] == c[0] && c[2] == c[0]) continue;
    const bool is_straight = c[1] == straight(c[0], c[3])[1] && c[2] == straight(c[0], c[3])[2];
    if (is_straight) {
      out.push_back(c[0]);
    } else {
      flatten(c, tolerance, 0, out);
    }
  }
  if (!line.empty() && !(line.back()[3] == line.front()[0])) out.push_back(line.back()[3]);
  Outline corners;
  for (const Vec2 p : out) {
    if (corners.empty() || !(corners.back() == p)) corners.push_back(p);
  }
  while (corners.size() > 1 && corners.front() == corners.back()) corners.pop_back();
  return without_slits(corners);
}

}  // namespace tendril::app
