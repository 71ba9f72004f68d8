#pragma once

#include <functional>
#include <span>
#include <vector>

#include "tendril/export.hpp"
#include "tendril/geometry.hpp"

namespace tendril {

/// A point of a backbone.
struct BackbonePoint {
  double s = 0.0;          ///< arc length from the base, m
  double x = 0.0;          ///< m
  double y = 0.0;          ///< m
  double angle = 0.0;      ///< rad
  double curvature = 0.0;  ///< 1/m

  Vec2 position() const { return {x, y}; }                ///< m
  bool operator==(const BackbonePoint&) const = default;  ///< Number by number.
};

/// Radius of a rod's body (m) at an arc length (m); empty: there is only a backbone.
using BodyRadius = std::function<double(double)>;

/// The sides of the body around a backbone: up along the left one, back along the right one.
TENDRIL_API std::vector<BackbonePoint> body_outline(std::span<const BackbonePoint> backbone, const BodyRadius& radius);

}  // namespace tendril
