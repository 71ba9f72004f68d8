#pragma once

#include <vector>

#include "obstacle/box_tree.hpp"
#include "obstacle/region.hpp"
#include "tendril/obstacle.hpp"

namespace tendril {

/// A body of any outline, with holes if need be, grown by a distance: one obstacle, however many sides it has. It is
/// not cut into convex pieces, so there are no seams between pieces to hide: outside, the distance is that to the
/// outline, and a contact slides from side to side on its own. Inside of the core the distance is the depth under the
/// outline and the rounding, which is the way out only where the body is convex.
///
/// Its patches are the sides, then the corners where sides begin. Where the body turns inward the normal jumps between
/// the two sides, which is no seam.
class TENDRIL_API Part : public Obstacle {
 public:
  /// `lines` as boundary_of() gives them: at least one, with the body on their left. rounding > 0. All in units of L.
  Part(const std::vector<ClosedLine>& lines, double rounding);
  ~Part() override;

  SurfacePoint at(Vec2 point) const override { return on_patch(patch_at(point), point); }
  int patch_at(Vec2 point) const override;
  SurfacePoint on_patch(int patch, Vec2 point) const override;
  std::span<const Seam> seams(int patch) const override;
  /// The centroid; the point of the core nearest to it if it lies outside.
  Vec2 reference_point() const override { return reference_; }
  double smallest_radius() const override { return rounding_; }
  double core_distance(Vec2 point) const override;
  /// Whether the core lies between two points.
  bool separates(Vec2 a, Vec2 b) const;
  double rounding() const override { return rounding_; }
  bool convex() const override { return false; }
  void bounding_box(Vec2& low, Vec2& high) const override;
  /// Several lines are joined to one by ways to and fro.
  void outline(std::span<Vec2> points, Vec2 low, Vec2 high) const override;

 private:
  struct Edge {
    Vec2 from{}, along{}, normal{};
    double length = 0.0;
    int next = 0;         ///< the one that goes on at its end
    bool inward = false;  ///< at its beginning the body turns inward
  };
  const Edge& edge(int i) const { return edges_[static_cast<std::size_t>(i)]; }
  BoxTree tree_of_edges() const;
  /// Adds the line around the body that edge `first` belongs to.
  void draw(int first, std::vector<Vec2>& line) const;

  std::vector<Edge> edges_;
  std::vector<int> firsts_;  ///< an edge of each line
  std::vector<Seam> seams_;
  std::vector<std::size_t> seams_from_;  ///< by patch, and where the last one ends
  double rounding_;
  BoxTree tree_{{}};
  Vec2 reference_{};
};

}  // namespace tendril
