#include "obstacle/circle.hpp"

#include <cmath>
#include <numbers>

#include "obstacle/shape_options.hpp"
#include "tendril/error.hpp"

namespace tendril {

Circle::Circle(Vec2 center, double radius)
    : offset_((norm(center) - radius) * (norm(center) + radius)), center_(center), radius_(radius) {
  if (!(radius > 0.0) || !std::isfinite(radius)) throw Error("a circle needs a positive, finite radius");
}

Circle::~Circle() = default;

SurfacePoint Circle::at(Vec2 point) const {
  const Vec2 out = point - center_;
  const double square = dot(out, out);
  const double distance = std::sqrt(square);
  // Every direction is normal at the centre; the curvature of the level set through it is without bound.
  if (!(square > 0.0)) return {distance - radius_, {0.0, 1.0}, 0.0, 0.0};
  const double inverse = distance * (1.0 / square);  // root and quotient do not wait for each other
  return {surface_distance(point, distance), inverse * out, inverse, 0.0};
}

void Circle::bounding_box(Vec2& low, Vec2& high) const {
  low = center_ - Vec2{radius_, radius_};
  high = center_ + Vec2{radius_, radius_};
}

void Circle::outline(std::span<Vec2> points, Vec2, Vec2) const {
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(points.size());
    points[i] = center_ + radius_ * Vec2{std::cos(angle), std::sin(angle)};
  }
}

Component<Obstacle> circle_component() {
  return {"circle",
          "a disc",
          {point_option("center", "centre of the circle"), positive_length_option("radius", "radius of the circle")},
          [](const Options& options) {
            return std::make_unique<Circle>(point_of(options, "center"), options.real("radius"));
          }};
}

}  // namespace tendril
