#pragma once

#include "tendril/obstacle.hpp"

namespace tendril {

/// A half-plane. It is its own core.
class TENDRIL_API Wall : public Obstacle {
 public:
  /// A point of its surface in units of L, and a direction out of it, not zero.
  Wall(Vec2 point, Vec2 normal);
  ~Wall() override;

  SurfacePoint at(Vec2 point) const override { return {dot(point - point_, normal_), normal_, 0.0, 0.0}; }
  Vec2 reference_point() const override { return point_; }
  double smallest_radius() const override;
  double core_distance(Vec2 point) const override { return dot(point - point_, normal_); }
  double rounding() const override { return 0.0; }
  void bounding_box(Vec2& low, Vec2& high) const override;
  /// The part inside the box; all points at infinity if there is none.
  void outline(std::span<Vec2> points, Vec2 low, Vec2 high) const override;

 private:
  Vec2 point_, normal_;
};

}  // namespace tendril
