#pragma once

#include <array>
#include <vector>

#include "tendril/obstacle.hpp"

namespace tendril {

/// A convex core, a line or a polygon, grown by a distance: what capsules and rounded polygons are. Its patches are the
/// edges, then the corners; curvature jumps between them.
class TENDRIL_API RoundedHull : public Obstacle {
 public:
  /// `corners`: two different points, or at least three of a strictly convex polygon, counterclockwise. rounding > 0;
  /// without it the normal at a corner would be undefined where a rod touches it. All in units of L.
  RoundedHull(std::vector<Vec2> corners, double rounding);
  ~RoundedHull() override;

  SurfacePoint at(Vec2 point) const override { return on_patch(patch_at(point), point); }
  int patch_at(Vec2 point) const override;
  SurfacePoint on_patch(int patch, Vec2 point) const override;
  std::span<const Seam> seams(int patch) const override { return seams_[static_cast<std::size_t>(patch)]; }
  /// The middle of a line, the centroid of a polygon.
  Vec2 reference_point() const override { return reference_; }
  double smallest_radius() const override { return rounding_; }
  double core_distance(Vec2 point) const override;
  double rounding() const override { return rounding_; }
  void bounding_box(Vec2& low, Vec2& high) const override;
  void outline(std::span<Vec2> points, Vec2 low, Vec2 high) const override;

 private:
  struct Edge {
    Vec2 from{}, along{}, normal{};
    double length = 0.0;
  };
  std::vector<Edge> edges_;  ///< edge i runs from corner i to the next
  std::vector<std::array<Seam, 2>> seams_;
  double rounding_;
  Vec2 reference_{};
};

}  // namespace tendril
