#pragma once

#include <memory>
#include <span>

#include "tendril/export.hpp"
#include "tendril/geometry.hpp"

namespace tendril {

/// The obstacle's boundary seen from a point: all that contact needs (docs/model.md section 4).
struct SurfacePoint {
  double distance = 0.0;        ///< signed distance d, > 0 outside
  Vec2 normal{};                ///< unit gradient of d, out of the obstacle
  double curvature = 0.0;       ///< k of the level set through the point: Hess d = k tau tau^T, tau = turned(normal)
  double curvature_rate = 0.0;  ///< dk/dtau
};

/// A line on which the level-set curvature jumps: points of the patch have normal . P >= offset.
struct Seam {
  Vec2 normal{};        ///< unit, into the patch
  double offset = 0.0;  ///< normal . P on the line
};

/// A fixed body of the plane. Dimensionless.
class TENDRIL_API Obstacle {
 public:
  virtual ~Obstacle();

  /// Undefined only on the shape's medial axis (a circle's centre), where a unit normal of any nearest boundary point
  /// is returned.
  virtual SurfacePoint at(Vec2 point) const = 0;
  /// Patches are the parts of the plane in which at() is smooth; a shape without seams is one patch. patch_at() names
  /// the one that holds a point, on_patch() is its surface continued beyond its seams.
  virtual int patch_at(Vec2 point) const;
  /// at() of one patch, continued beyond its seams.
  virtual SurfacePoint on_patch(int patch, Vec2 point) const;
  /// The straight lines that bound a patch outside of the core. None: the shape is smooth.
  virtual std::span<const Seam> seams(int patch) const;
  /// A point that stands for the obstacle in objectives (a circle's centre).
  virtual Vec2 reference_point() const = 0;
  /// Smallest radius of curvature of the boundary; infinity for a wall.
  virtual double smallest_radius() const = 0;
  /// Distance from `point` to the core that is rounded to give the shape (a circle's centre), 0 inside. The shape is
  /// the core grown by rounding().
  virtual double core_distance(Vec2 point) const = 0;
  /// Radius by which the core is grown to give the shape.
  virtual double rounding() const = 0;
  /// Whether the core is convex. Of one that is not, a rod may touch several places with one stretch, and the depth of
  /// a rod that runs through the core is certified to a thousandth only.
  virtual bool convex() const;
  /// Axis-aligned box for figures; unbounded shapes return infinities.
  virtual void bounding_box(Vec2& low, Vec2& high) const = 0;
  /// Points around the boundary, for figures; unbounded shapes clip to the given box, and put the points at infinity if
  /// nothing of them lies in it.
  virtual void outline(std::span<Vec2> points, Vec2 low, Vec2 high) const = 0;
};

/// The obstacle elsewhere: turned by `turn` (rad) about its reference point, then shifted (L). One that is not moved is
/// given back as it is.
TENDRIL_API std::unique_ptr<Obstacle> moved(std::unique_ptr<Obstacle> obstacle, Vec2 shift, double turn);

}  // namespace tendril
