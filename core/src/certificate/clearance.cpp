#include "certificate/clearance.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "tendril/tolerances.hpp"

namespace tendril {

namespace {

/// Of a piece; they reach the spacing of doubles: nothing is hidden between two neighbours.
constexpr int most_halvings = 60;

struct Interval {
  int piece = 0;
  double from = 0.0, to = 1.0;
  double core_from = 0.0,
         core_to = 0.0;  // distance to the core at the ends; for a shape without rounding the signed distance
  int depth = 0;
  double radius_from = 0.0, radius_to = 0.0;  ///< of the body at the ends
};

/// The depth of a rod in a core that is not convex is known up to this share of it.
constexpr double blunt_share = 1e-3;

/// Where the rod meets the core the square of the distance bounds nothing. The signed distance to a convex shape is
/// convex: it lies above its tangent at the middle, which bounds it like a wall. Of any other shape it is only known
/// that it changes no faster than the place.
double depth_bound(const Curve& curve, const Obstacle& obstacle, const Interval& at, double& lowest_seen) {
  const Vec2 middle = curve.position(at.piece, 0.5 * (at.from + at.to));
  const SurfacePoint s = obstacle.at(middle);
  lowest_seen = std::min(lowest_seen, s.distance - curve.radius(at.piece, 0.5 * (at.from + at.to)));
  const double h = (at.to - at.from) * curve.arc_bound(at.piece);
  const double bend = curve.radius_bounds(at.piece).bend;
  if (!obstacle.convex()) return s.distance - 0.5 * h - std::max(at.radius_from, at.radius_to) - h * h / 8.0 * bend;
  const double from = dot(s.normal, curve.position(at.piece, at.from) - middle) - at.radius_from;
  const double to = dot(s.normal, curve.position(at.piece, at.to) - middle) - at.radius_to;
  return s.distance + std::min(from, to) - h * h / 8.0 * (curve.curvature_bound(at.piece) + bend);
}

}  // namespace

double certified_depth(const Curve& curve, const Obstacle& obstacle) {
  const double radius = obstacle.rounding();
  const bool flat = !std::isfinite(obstacle.smallest_radius());
  double lowest_seen = 0.0;  // only depth counts
  // Comparisons with what is no number would pass for clearance.
  bool no_number = !(radius >= 0.0);
  const auto core = [&](int piece, double sigma) {
    const Vec2 p = curve.position(piece, sigma);
    const double value = flat ? obstacle.at(p).distance : obstacle.core_distance(p);
    if (!(value > -infinity)) no_number = true;
    // Inside of the core only the signed distance tells how deep.
    const double distance = flat ? value : value > 0.0 ? value - radius : obstacle.at(p).distance;
    lowest_seen = std::min(lowest_seen, distance - curve.radius(piece, sigma));
    return value;
  };
  double depth = 0.0;
  // The ends of all pieces first: depth seen anywhere spares halvings everywhere.
  for (int j = 0; j < curve.piece_count(); ++j) {
    core(j, 0.0);
    core(j, 1.0);
  }
  // Of an interval and its halves at most one more than the halvings are open at a time.
  std::array<Interval, most_halvings + 2> open;
  std::size_t count = 0;
  int pieces_left = curve.piece_count();
  while ((count > 0 || pieces_left > 0) && !no_number) {
    if (count == 0) {
      const int j = --pieces_left;
      open[count++] = {j, 0.0, 1.0, core(j, 0.0), core(j, 1.0), 0, curve.radius(j, 0.0), curve.radius(j, 1.0)};
    }
    const Interval at = open[--count];
    const double h = (at.to - at.from) * curve.arc_bound(at.piece);
    const double kappa = curve.curvature_bound(at.piece);
    const double low = std::min(at.core_from, at.core_to);
    const double farthest = std::max(at.core_from, at.core_to) + 0.5 * h;
    const double square = low * low - 0.25 * h * h * (1.0 + kappa * farthest);
    const double swell = h * h / 8.0 * curve.radius_bounds(at.piece).bend;
    double bound = 0.0;  // of the body's distance to the obstacle
    if (flat) {
      bound = std::min(at.core_from - at.radius_from, at.core_to - at.radius_to) - h * h / 8.0 * kappa - swell;
    } else if (square > 0.0) {
      // The square lies above a straight line, less a part; its root, being concave, above what it is at the ends.
      const double less = low * low - square;
      const auto end = [&](double distance, double thick) { return std::sqrt(distance * distance - less) - thick; };
      bound = std::min(end(at.core_from, at.radius_from), end(at.core_to, at.radius_to)) - radius - swell;
    } else {
      bound = depth_bound(curve, obstacle, at, lowest_seen);
    }
    // A rod in a core that is not convex is refused, however deep it is.
    const bool blunt = !obstacle.convex() && square <= 0.0 && lowest_seen < -radius;
    const double sharp = std::max(tolerance::clearance_sharpness, blunt ? -blunt_share * lowest_seen : 0.0);
    if (bound >= lowest_seen - sharp || at.depth >= most_halvings) {
      depth = std::max(depth, -bound);
      continue;
    }
    const double middle = 0.5 * (at.from + at.to);
    const double value = core(at.piece, middle);
    const double thick = curve.radius(at.piece, middle);
    open[count++] = {at.piece, at.from, middle, at.core_from, value, at.depth + 1, at.radius_from, thick};
    open[count++] = {at.piece, middle, at.to, value, at.core_to, at.depth + 1, thick, at.radius_to};
  }
  return no_number ? infinity : depth;
}

std::vector<ClosestApproach> closest_approaches(const Curve& curve, const Obstacle& obstacle, double level) {
  std::vector<ClosestApproach> found;
  closest_approaches(curve, obstacle, level, found);
  return found;
}

namespace {

/// Local minima of the distance along a curve, of which samples in their order are shown to it.
class Valleys {
 public:
  Valleys(const Curve& curve, const Obstacle& obstacle, double level, std::vector<ClosestApproach>& found)
      : curve_(curve), obstacle_(obstacle), level_(level), found_(found) {}

  ClosestApproach sample(int piece, double sigma) const {
    return {piece, sigma, curve_.start(piece) + sigma * curve_.length(piece),
            obstacle_.at(curve_.position(piece, sigma)).distance - curve_.radius(piece, sigma)};
  }
  /// A sample between its neighbours along the rod, where it has them.
  void consider(const ClosestApproach* before, const ClosestApproach& here, const ClosestApproach* after) {
    if (before != nullptr && here.distance > before->distance) return;
    if (after != nullptr && here.distance >= after->distance) return;
    const double low = before != nullptr ? before->arc_length : here.arc_length;
    const double high = after != nullptr ? after->arc_length : here.arc_length;
    // A sample may stand above the level although the minimum beside it does not: neighbours bound the slope by 1, and
    // by that of the body.
    const double slope = curve_.stretch_bound(here.piece) + curve_.radius_bounds(here.piece).slope;
    if (here.distance - slope * std::max(here.arc_length - low, high - here.arc_length) > level_) return;
    const ClosestApproach best = lowest(here, low, high);
    if (best.distance <= level_) found_.push_back(best);
  }

 private:
  ClosestApproach at_arc_length(double s) const {
    int j = 0;
    while (j + 1 < curve_.piece_count() && s > curve_.start(j + 1)) ++j;
    return sample(j, std::clamp((s - curve_.start(j)) / curve_.length(j), 0.0, 1.0));
  }
  /// Golden section: the distance has one minimum between neighbours of a lowest sample.
  ClosestApproach lowest(ClosestApproach best, double low, double high) const {
    const double ratio = 0.5 * (std::sqrt(5.0) - 1.0);
    ClosestApproach left = at_arc_length(high - ratio * (high - low));
    ClosestApproach right = at_arc_length(low + ratio * (high - low));
    while (high - low > 1e-9) {
      if (left.distance < right.distance) {
        high = right.arc_length;
        right = left;
        left = at_arc_length(high - ratio * (high - low));
      } else {
        low = left.arc_length;
        left = right;
        right = at_arc_length(low + ratio * (high - low));
      }
      const ClosestApproach& lower = left.distance < right.distance ? left : right;
      if (lower.distance < best.distance) best = lower;
    }
    return best;
  }

  const Curve& curve_;
  const Obstacle& obstacle_;
  double level_;
  std::vector<ClosestApproach>& found_;
};

}  // namespace

void closest_approaches(const Curve& curve, const Obstacle& obstacle, double level,
                        std::vector<ClosestApproach>& found) {
  Valleys valleys(curve, obstacle, level, found);
  // Valleys of the distance are as wide as the obstacle is small; the curve itself is smooth on the scale of its
  // pieces.
  ClosestApproach before, here;
  int seen = 0;
  for (int j = 0; j < curve.piece_count(); ++j) {
    // A piece is no nearer than its middle less half its length.
    const double reach = 0.5 * curve.length(j) * (curve.stretch_bound(j) + curve.radius_bounds(j).slope);
    if (valleys.sample(j, 0.5).distance - reach > level) {
      if (seen > 0) valleys.consider(seen > 1 ? &before : nullptr, here, nullptr);
      seen = 0;
      continue;
    }
    const double wanted = curve.arc_bound(j) / std::clamp(0.5 * obstacle.smallest_radius(), 1e-3, 0.02);
    const int steps = std::clamp(static_cast<int>(std::ceil(wanted)), 8, 1000);
    // From sample to sample the distance changes by no more than that.
    const double most = 2.0 * reach / steps;
    for (int i = seen == 0 ? 0 : 1; i <= steps; ++i, ++seen) {
      const ClosestApproach next = valleys.sample(j, static_cast<double>(i) / steps);
      if (seen > 0) valleys.consider(seen > 1 ? &before : nullptr, here, &next);
      before = here;
      here = next;
      // Samples that stand above the level with their neighbours, whatever they are, are passed over.
      if (const double above = std::min((next.distance - level) / most, static_cast<double>(steps)); above >= 5.0) {
        i += static_cast<int>(above) - 3;
        seen = -1;
      }
    }
  }
  if (seen > 0) valleys.consider(seen > 1 ? &before : nullptr, here, nullptr);
}

}  // namespace tendril
