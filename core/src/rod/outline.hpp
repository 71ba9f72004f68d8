#pragma once

#include <functional>
#include <vector>

#include "rod/rod.hpp"

namespace tendril {

/// A point of a shape that is only looked at.
struct OutlinePoint {
  double s = 0.0;      ///< arc length, units of L
  Vec2 position{};     ///< units of L
  Vec2 tangent{};      ///< unit vector
  double angle = 0.0;  ///< rad
  double curvature = 0.0;
  double radius = 0.0;  ///< of the body, units of L
};

/// The shape of a curvature over s/L with the base where searches begin, integrated by midpoints: steps + 1 points,
/// equally far apart, into `out`. What a start looks like, and where it comes near something; nothing that a plan
/// stands on.
void outline(const Rod& rod, const std::function<double(double)>& curvature, int steps, std::vector<OutlinePoint>& out);

}  // namespace tendril
