#pragma once

#include <vector>

#include "tendril/geometry.hpp"
#include "tendril/scene.hpp"

namespace tendril::bench {

/// A convex core (a point, a line, a polygon or a half plane) grown by a radius.
struct Body {
  std::vector<Vec2> core;  ///< counterclockwise
  double radius = 0.0;
  bool half_plane = false;  ///< core[0] is on its surface, core[1] is its normal
  double size = 1.0;        ///< largest coordinate, for what rounding of the data does

  /// Distance to the core (negative inside a polygon) and its gradient.
  double distance(Vec2 p, Vec2& normal) const;
};

/// The body of an obstacle whose options are numbers or text with units, in units of `length`. Throws Error for a shape
/// that is not known here.
Body body_of(const ObstacleSpec& spec, const QuantityReader& read, double length);

}  // namespace tendril::bench
