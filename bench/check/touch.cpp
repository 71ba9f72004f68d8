#include "check/touch.hpp"

#include <algorithm>
#include <cmath>

namespace tendril::bench {
namespace {

/// (L) Beside a smaller obstacle the two parts of a contact's stiffness, 1/radius each, leave nothing but rounding of
/// their sum, and differences would step over the obstacle: what is beside the contact is taken for itself instead.
constexpr double tiny_radius = 1e-3;

Vec2 direction(double angle) { return {std::cos(angle), std::sin(angle)}; }

}  // namespace

void look_beside(const Body& body, const RodShape& shape, const Eigen::VectorXd& q, Touch& touch) {
  if (body.half_plane || body.radius >= tiny_radius) return;
  const RodShape::Point p = shape.point(q, touch.s);
  const double distance = body.distance(p.at, touch.normal);
  touch.core = p.at - distance * touch.normal;
  // A hundredth of the radius along the surface turns the normal of a round one by a hundredth.
  constexpr double share = 1e-2;
  Vec2 there{};
  body.distance(p.at + share * body.radius * turned(touch.normal), there);
  touch.flat = norm(there - touch.normal) <= 0.5 * share;
  touch.followed = !touch.flat && !touch.at_tip;
  if (!touch.followed) return;
  touch.side = cross(direction(p.angle), touch.normal) > 0.0 ? 1.0 : -1.0;
  // Where the curvature jumps, the side with less sliding counts.
  constexpr double step = 1e-6;
  const auto bend = [&](double along) {
    const double near = shape.point(q, touch.s + along).angle - p.angle;
    const double far = shape.point(q, touch.s + 2.0 * along).angle - p.angle;
    return (4.0 * near - far) / (2.0 * along);
  };
  touch.curvature = touch.side * std::max(touch.side * bend(step), touch.side * bend(-step));
  touch.convexity = 1.0 + touch.side * touch.curvature * distance;
}

Vec2 normal_of(const Body& body, const Touch& touch, Vec2 at) {
  if (touch.flat) return touch.normal;
  Vec2 normal{};
  body.distance(at, normal);
  return normal;
}

Hold followed_hold(const Touch& touch, const RodShape::Point& p) {
  const Vec2 tangent = direction(p.angle);
  const double slide = -dot(tangent, p.at - touch.core) / touch.convexity;
  // At the closest point the obstacle's normal is the rod's.
  return {p.at + slide * tangent, touch.side * turned(direction(p.angle + slide * touch.curvature))};
}

}  // namespace tendril::bench
