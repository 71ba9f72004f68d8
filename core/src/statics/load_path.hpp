#pragma once

#include <memory>
#include <vector>

#include "rod/rod.hpp"
#include "tendril/numbers.hpp"
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
  void bounding_box(Vec2& low, Vec2& high) const override { whole_->bounding_box(low, high); }
  void outline(std::span<Vec2> points, Vec2 low, Vec2 high) const override { whole_->outline(points, low, high); }

 private:
  const Obstacle* whole_;
  double by_ = 0.0;
};

/// Rod and obstacles as functions of the load fraction: everything is affine in it, so that rates are exact
/// differences.
class LoadPath {
 public:
  struct Ends {
    std::vector<double> first, last;  ///< moments at load 0 and 1, one per actuator of the rod
    bool loads_grow = true;           ///< gravity and tip force start from 0; else they act from the beginning
  };
  LoadPath(Rod rod, const std::vector<const Obstacle*>& obstacles, Ends ends);

  /// Obstacle o starts `by` smaller and grows back with the load.
  void grow(std::size_t o, double by) { shrink_[o] = by; }
  void apply(double load);
  double load() const { return load_; }
  const Rod& rod() const { return rod_; }
  const std::vector<const Obstacle*>& obstacles() const { return pointers_; }
  double moment(std::size_t actuator, double load) const {
    return (1.0 - load) * ends_.first[actuator] + load * ends_.last[actuator];
  }
  double moment_rate(std::size_t actuator) const { return ends_.last[actuator] - ends_.first[actuator]; }
  /// d distance / d load of an obstacle at fixed points.
  double distance_rate(int o) const { return -shrink_[static_cast<std::size_t>(o)]; }
  bool loads_grow() const { return ends_.loads_grow && (rod_has_loads_); }

 private:
  Rod rod_;
  Vec2 gravity_, tip_force_;
  bool rod_has_loads_ = false;
  Ends ends_;
  std::vector<std::unique_ptr<ShrunkObstacle>> own_;
  std::vector<const Obstacle*> pointers_;
  std::vector<double> shrink_;
  double load_ = 1.0;
};

}  // namespace tendril
