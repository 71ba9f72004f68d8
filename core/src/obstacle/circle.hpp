#pragma once

#include "tendril/obstacle.hpp"

namespace tendril {

/// A disc. The rounded core is its centre.
class TENDRIL_API Circle : public Obstacle {
 public:
  /// radius > 0; all in units of L.
  Circle(Vec2 center, double radius);
  ~Circle() override;

  SurfacePoint at(Vec2 point) const override;
  Vec2 reference_point() const override { return center_; }
  double smallest_radius() const override { return radius_; }
  double core_distance(Vec2 point) const override { return norm(point - center_); }
  double rounding() const override { return radius_; }
  void bounding_box(Vec2& low, Vec2& high) const override;
  void outline(std::span<Vec2> points, Vec2 low, Vec2 high) const override;

 private:
  /// Of a point at this distance from the centre. Far larger than the rod, the circle is nearly a wall: the difference
  /// of two large numbers would leave few digits of it.
  double surface_distance(Vec2 point, double from_center) const {
    if (radius_ < large) return from_center - radius_;
    return (dot(point, point) - 2.0 * dot(point, center_) + offset_) / (from_center + radius_);
  }

  static constexpr double large = 8.0;  ///< L
  double offset_;                       ///< |center|^2 - radius^2
  Vec2 center_;
  double radius_;
};

}  // namespace tendril
