#pragma once

#include "tendril/obstacle.hpp"

namespace tendril {

/// The same distance field with the surface moved inward: how an obstacle grows out of its core.
class ShrunkObstacle : public Obstacle {
 public:
  explicit ShrunkObstacle(const Obstacle& whole) : whole_(&whole) {}
  ~ShrunkObstacle() override;
  void shrink(double by) { by_ = by; }

  SurfacePoint at(Vec2 point) const override;
  int patch_at(Vec2 point) const override { return whole_->patch_at(point); }
  SurfacePoint on_patch(int patch, Vec2 point) const override;
  std::span<const Seam> seams(int patch) const override { return whole_->seams(patch); }
  Vec2 reference_point() const override { return whole_->reference_point(); }
  double smallest_radius() const override { return whole_->smallest_radius() - by_; }
  double core_distance(Vec2 point) const override { return whole_->core_distance(point); }
  double rounding() const override { return whole_->rounding() - by_; }
  bool convex() const override { return whole_->convex(); }
  void bounding_box(Vec2& low, Vec2& high) const override { whole_->bounding_box(low, high); }
  void outline(std::span<Vec2> points, Vec2 low, Vec2 high) const override { whole_->outline(points, low, high); }

 private:
  const Obstacle* whole_;
  double by_ = 0.0;
};

}  // namespace tendril
