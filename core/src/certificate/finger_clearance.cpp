#include "certificate/finger_clearance.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "tendril/tolerances.hpp"

namespace tendril {
namespace {

/// Pairs of pieces that are looked at before the question counts as open: fingers that lie along each other.
constexpr int most_pairs = 400000;
constexpr int samples = 400;  ///< of what has passed the other finger, where the depth is measured

/// A part of a finger and its chord.
struct Span {
  int piece = 0;
  double from = 0.0, to = 1.0;
  Vec2 start{}, end{};

  double length(const FingerCurve& f) const { return (to - from) * f.curve->length(piece) * f.length; }
  double radius(const FingerCurve& f, double sigma) const { return f.length * f.curve->radius(piece, sigma); }
  /// Bounds of the body's radius.
  std::pair<double, double> radii(const FingerCurve& f) const {
    const auto [least, most] = std::minmax({radius(f, from), radius(f, to)});
    const double h = (to - from) * f.curve->length(piece);
    const double swell = f.length * h * h / 8.0 * f.curve->radius_bounds(piece).bend;
    return {least - swell, most + swell};
  }
  /// How far the curve may stray from its chord.
  double bend(const FingerCurve& f) const {
    const double h = length(f);
    return h * h / 8.0 * f.curve->curvature_bound(piece) / f.length;
  }
};

std::pair<Span, Span> halves(const FingerCurve& f, const Span& at) {
  const double middle = 0.5 * (at.from + at.to);
  const Vec2 point = f.position(at.piece, middle);
  return {Span{at.piece, at.from, middle, at.start, point}, Span{at.piece, middle, at.to, point, at.end}};
}

double distance_to_chord(Vec2 p, Vec2 a, Vec2 b) {
  const Vec2 along = b - a;
  const double square = dot(along, along);
  const double t = square > 0.0 ? std::clamp(dot(p - a, along) / square, 0.0, 1.0) : 0.0;
  return norm(p - a - t * along);
}

/// Shares of both chords at which they cross.
std::optional<std::pair<double, double>> crossing(const Span& a, const Span& b) {
  const Vec2 first = a.end - a.start;
  const Vec2 second = b.end - b.start;
  const double area = cross(first, second);
  if (area == 0.0) return std::nullopt;
  const double t = cross(b.start - a.start, second) / area;
  const double u = cross(b.start - a.start, first) / area;
  if (t < 0.0 || t > 1.0 || u < 0.0 || u > 1.0) return std::nullopt;
  return std::pair(t, u);
}

double chord_distance(const Span& a, const Span& b) {
  if (crossing(a, b)) return 0.0;
  return std::min(std::min(distance_to_chord(a.start, b.start, b.end), distance_to_chord(a.end, b.start, b.end)),
                  std::min(distance_to_chord(b.start, a.start, a.end), distance_to_chord(b.end, a.start, a.end)));
}

struct Place {
  int piece = 0;
  double sigma = 0.0;
  double along = 0.0;  ///< of the whole finger, units of the finger
};

struct Crossing {
  Place upper, lower;
};

Place place_of(const FingerCurve& f, const Span& at, double share) {
  const double sigma = at.from + share * (at.to - at.from);
  return {at.piece, sigma, f.curve->start(at.piece) + sigma * f.curve->length(at.piece)};
}

Place place_at(const FingerCurve& f, double along) {
  int j = 0;
  while (j + 1 < f.curve->piece_count() && along > f.curve->start(j + 1)) ++j;
  return {j, std::clamp((along - f.curve->start(j)) / f.curve->length(j), 0.0, 1.0), along};
}

double end_of(const FingerCurve& f) {
  const int last = f.curve->piece_count() - 1;
  return f.curve->start(last) + f.curve->length(last);
}

Vec2 at(const FingerCurve& f, const Place& place) { return f.position(place.piece, place.sigma); }

/// The farthest that the part of `f` beyond `from` and up to `to` comes from `other`.
double farthest(const FingerCurve& f, double from, double to, const FingerCurve& other) {
  std::vector<Vec2> line;
  for (int i = 0; i <= samples; ++i) line.push_back(at(other, place_at(other, end_of(other) * i / samples)));
  double most = 0.0;
  for (int i = 0; i <= samples; ++i) {
    const Vec2 p = at(f, place_at(f, from + (to - from) * i / samples));
    double nearest = infinity;
    for (std::size_t k = 0; k + 1 < line.size(); ++k)
      nearest = std::min(nearest, distance_to_chord(p, line[k], line[k + 1]));
    most = std::max(most, nearest);
  }
  return most;
}

/// The end of `f` beyond `from` that lies farthest against `direction`.
Place extreme(const FingerCurve& f, double from, Vec2 direction) {
  Place best = place_at(f, end_of(f));
  double least = dot(direction, at(f, best));
  for (int i = 0; i < samples; ++i) {
    const Place here = place_at(f, from + (end_of(f) - from) * i / samples);
    const double value = dot(direction, at(f, here));
    if (!(value < least) || !(here.sigma > 0.0)) continue;
    least = value;
    best = here;
  }
  return best;
}

}  // namespace

Vec2 FingerCurve::position(int piece, double sigma) const {
  const Vec2 p = length * curve->position(piece, sigma);
  return mirrored ? Vec2{p.x, -p.y} : p;
}

Vec2 FingerCurve::tangent(int piece, double sigma) const {
  const Vec2 t = curve->at(piece, sigma).tangent;
  return mirrored ? Vec2{t.x, -t.y} : t;
}

FingerClearance finger_clearance(const FingerCurve& upper, const FingerCurve& lower) {
  std::vector<std::pair<Span, Span>> open;
  const auto whole = [](const FingerCurve& f, int j) {
    return Span{j, 0.0, 1.0, f.position(j, 0.0), f.position(j, 1.0)};
  };
  for (int j = 0; j < upper.curve->piece_count(); ++j) {
    for (int k = 0; k < lower.curve->piece_count(); ++k) open.emplace_back(whole(upper, j), whole(lower, k));
  }
  FingerClearance out;
  std::vector<Crossing> found;
  std::optional<Crossing> deepest;  // where the bodies lie in each other
  for (int pairs = 0; !open.empty(); ++pairs) {
    const auto [a, b] = open.back();
    open.pop_back();
    const double bend = a.bend(upper) + b.bend(lower);
    const double apart = chord_distance(a, b);
    // What is no number is neither apart nor near.
    if (pairs > most_pairs || !(apart >= 0.0) || !(bend >= 0.0)) {
      out.depth = infinity;
      return out;
    }
    const auto [upper_least, upper_most] = a.radii(upper);
    const auto [lower_least, lower_most] = b.radii(lower);
    if (apart > bend + (upper_most + lower_most)) continue;
    if (const double depth = upper_least + lower_least - apart - bend; depth > 0.0) {
      // The bodies lie in each other there, whether or not the backbones cross.
      if (depth > out.depth) deepest = {place_of(upper, a, 0.5), place_of(lower, b, 0.5)};
      out.depth = std::max(out.depth, depth);
      continue;
    }
    if (bend > 0.5 * tolerance::clearance_sharpness) {
      const bool first = a.length(upper) >= b.length(lower);
      const auto [left, right] = first ? halves(upper, a) : halves(lower, b);
      open.emplace_back(first ? left : a, first ? b : left);
      open.emplace_back(first ? right : a, first ? b : right);
      continue;
    }
    const auto shares = crossing(a, b);
    if (!shares) continue;  // nearer than can matter, but on its own side
    const Crossing here{place_of(upper, a, shares->first), place_of(lower, b, shares->second)};
    // A crossing at the end of one part is seen from the next one too.
    const double same = 2.0 * std::max(a.length(upper), b.length(lower));
    const bool known = std::any_of(found.begin(), found.end(), [&](const Crossing& c) {
      return std::abs(c.upper.along - here.upper.along) * upper.length <= same &&
             std::abs(c.lower.along - here.lower.along) * lower.length <= same;
    });
    if (!known) found.push_back(here);
  }
  std::sort(found.begin(), found.end(),
            [](const Crossing& a, const Crossing& b) { return a.upper.along < b.upper.along; });
  // Between a crossing and the next one each finger is on the wrong side of the other; behind the last one up to its
  // tip.
  for (std::size_t i = 0; i < found.size(); i += 2) {
    const bool last = i + 1 == found.size();
    const double upper_end = last ? end_of(upper) : found[i + 1].upper.along;
    const double lower_end = last ? end_of(lower) : found[i + 1].lower.along;
    out.depth = std::max(out.depth, std::min(farthest(upper, found[i].upper.along, upper_end, lower),
                                             farthest(lower, found[i].lower.along, lower_end, upper)));
    const auto unit = [](Vec2 v) { return (1.0 / std::max(1e-300, norm(v))) * v; };
    const Vec2 along = unit(upper.tangent(found[i].upper.piece, found[i].upper.sigma)) +
                       unit(lower.tangent(found[i].lower.piece, found[i].lower.sigma));
    if (!(norm(along) > 1e-6)) continue;  // they run against each other: no direction keeps them apart
    const Vec2 normal = turned(unit(along));
    const Place top = extreme(upper, found[i].upper.along, normal);
    const Place bottom = extreme(lower, found[i].lower.along, -1.0 * normal);
    out.crossings.push_back({top.piece, top.sigma, bottom.piece, bottom.sigma, normal});
  }
  if (!found.empty() || !deepest) return out;
  // Bodies that meet beside backbones on their own sides are kept apart along what lies between.
  const auto& [top, bottom] = *deepest;
  const Vec2 between = at(upper, top) - at(lower, bottom);
  if (!(norm(between) > 0.0)) return out;
  out.crossings.push_back({top.piece, top.sigma, bottom.piece, bottom.sigma, (1.0 / norm(between)) * between});
  return out;
}

}  // namespace tendril
