#include "scene/start_shape.hpp"

#include "estimate/estimate_fit.hpp"

namespace tendril {

std::function<double(double)> start_curvature(const Scene& scene, const Scale& scale, const Rod& rod) {
  if (scene.start_points.empty()) return {};
  Vec2 last = rod.base;
  MeasuredShape shape;
  shape.points.resize(2 * static_cast<Eigen::Index>(scene.start_points.size()));
  for (std::size_t i = 0; i < scene.start_points.size(); ++i) {
    const Vec2 point{scene.start_points[i].x / scale.length, scene.start_points[i].y / scale.length};
    shape.arc_lengths.push_back((i > 0 ? shape.arc_lengths.back() : 0.0) + norm(point - last));
    shape.points.segment<2>(2 * static_cast<Eigen::Index>(i)) << point.x, point.y;
    last = point;
  }
  const double length = shape.arc_lengths.back();
  if (!(length > 0.0)) throw SceneError("start.points", "the points lie on the base, expected them along the rod");
  // Points that are farther apart, or nearer, than the rod is long give its shape all the same.
  for (double& s : shape.arc_lengths) s /= length;
  return measured_curvature(rod, shape);
}

}  // namespace tendril
