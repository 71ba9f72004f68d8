#pragma once

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

}  // namespace tendril
