#pragma once

#include <span>

#include "tendril/export.hpp"
#include "tendril/geometry.hpp"

namespace tendril {

/// The obstacle's boundary seen from a point: all that contact needs (model.md section 4).
struct SurfacePoint {
  double distance = 0.0;        ///< signed distance d, > 0 outside
  Vec2 normal{};                ///< unit gradient of d, out of the obstacle
  double curvature = 0.0;       ///< k of the level set through the point: Hess d = k tau tau^T, tau = turned(normal)
  double curvature_rate = 0.0;  ///< dk/dtau
};

/// A fixed body of the plane. Dimensionless.
class TENDRIL_API Obstacle {
 public:
  virtual ~Obstacle();

  /// Undefined only on the shape's medial axis (a circle's centre), where any unit normal may be returned.
  virtual SurfacePoint at(Vec2 point) const = 0;
  /// A point that stands for the obstacle in objectives (a circle's centre).
  virtual Vec2 reference_point() const = 0;
  /// Smallest radius of curvature of the boundary; infinity for a wall.
  virtual double smallest_radius() const = 0;
  /// Distance from `point` to the convex core that is rounded to give the shape (a circle's centre). The shape is the
  /// core grown by rounding(). The clearance bound stands on the convexity of the core.
  virtual double core_distance(Vec2 point) const = 0;
  virtual double rounding() const = 0;
  /// Axis-aligned box for figures; unbounded shapes return infinities.
  virtual void bounding_box(Vec2& low, Vec2& high) const = 0;
  /// `count` points around the boundary, for figures; unbounded shapes clip to the given box.
  virtual void outline(std::span<Vec2> points, Vec2 low, Vec2 high) const = 0;
};

}  // namespace tendril
