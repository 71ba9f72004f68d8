#pragma once

#include <algorithm>

#include "tendril/geometry.hpp"
#include "tendril/numbers.hpp"

namespace tendril::app {

/// What points span.
struct Box {
  Vec2 low{infinity, infinity};
  Vec2 high{-infinity, -infinity};

  void add(Vec2 p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
  }
  bool empty() const { return low.x > high.x; }
  Vec2 size() const { return high - low; }
  bool contains(Vec2 p) const { return low.x <= p.x && p.x <= high.x && low.y <= p.y && p.y <= high.y; }
  /// Whether a point of the line from a to b may be nearer than `distance`.
  bool may_meet(Vec2 a, Vec2 b, double distance) const {
    return std::max(a.x, b.x) > low.x - distance && std::min(a.x, b.x) < high.x + distance &&
           std::max(a.y, b.y) > low.y - distance && std::min(a.y, b.y) < high.y + distance;
  }
  void grow(double by) {
    low = low - Vec2{by, by};
    high = high + Vec2{by, by};
  }
  /// Takes in what of `other` is no farther away than `near`.
  void add_near(const Box& other, double near) {
    if (other.empty()) return;
    Box around = *this;
    around.grow(near);
    for (const Vec2 p : {other.low, other.high}) {
      add({std::clamp(p.x, around.low.x, around.high.x), std::clamp(p.y, around.low.y, around.high.y)});
    }
  }
  /// Grows on both sides until it is `least` wide and high.
  void widen(Vec2 least) {
    const Vec2 more{0.5 * std::max(0.0, least.x - size().x), 0.5 * std::max(0.0, least.y - size().y)};
    low = low - more;
    high = high + more;
  }
};

}  // namespace tendril::app
