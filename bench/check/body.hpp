#pragma once

#include <vector>

#include "tendril/geometry.hpp"
#include "tendril/scene.hpp"

namespace tendril::bench {

/// A core (a point, a line, outlines or a half plane) grown by a radius.
struct Body {
  /// Outlines do not touch each other; those around the body run counterclockwise, those around holes clockwise.
  std::vector<std::vector<Vec2>> lines;
  double radius = 0.0;
  /// Of a channel `lines` are pieces of its boundary, with the body on their left: what lies in one of these convex
  /// polygons, and in none of those.
  std::vector<std::vector<Vec2>> solid, hollow;
  bool half_plane = false;  ///< the first point is on its surface, the second one is its normal
  double size = 1.0;        ///< largest coordinate, for what rounding of the data does

  /// Distance to the core (negative inside of outlines) and its gradient.
  double distance(Vec2 p, Vec2& normal) const;
};

/// The body of an obstacle whose options are numbers or text with units, in units of `length`. Throws Error for a shape
/// that is not known here, and for a polygon in parts.
Body body_of(const ObstacleSpec& spec, const QuantityReader& read, double length);

}  // namespace tendril::bench
