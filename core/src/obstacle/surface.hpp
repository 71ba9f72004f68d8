#pragma once

#include <cmath>

#include "tendril/obstacle.hpp"

namespace tendril {

/// A symmetric 2 x 2 matrix.
struct Symmetric2 {
  double xx = 0.0, xy = 0.0, yy = 0.0;
};

/// What a corner that is rounded so much looks like from a point `out` of it. At the corner itself every direction
/// between the normals of both sides is normal; `there` is one of them.
inline SurfacePoint beside_corner(Vec2 out, Vec2 there, double rounding) {
  const double square = dot(out, out);
  if (!(square > 0.0)) return {-rounding, there, 0.0, 0.0};
  const double distance = std::sqrt(square);
  const double inverse = distance * (1.0 / square);
  return {distance - rounding, inverse * out, inverse, 0.0};
}

/// Hess d = k tau tau^T at a surface point.
inline Symmetric2 distance_hessian(const SurfacePoint& s) {
  const Vec2 tau = turned(s.normal);
  return {s.curvature * tau.x * tau.x, s.curvature * tau.x * tau.y, s.curvature * tau.y * tau.y};
}

/// Second derivative of c . n(P): the third derivative of the distance contracted with c.
inline Symmetric2 normal_hessian(const SurfacePoint& s, Vec2 c) {
  const Vec2 n = s.normal;
  const Vec2 tau = turned(n);
  const double k = s.curvature;
  const double along = -k * k * dot(n, c) + s.curvature_rate * dot(tau, c);
  const double mixed = -k * k * dot(tau, c);
  return {along * tau.x * tau.x + 2.0 * mixed * n.x * tau.x,
          along * tau.x * tau.y + mixed * (n.x * tau.y + n.y * tau.x),
          along * tau.y * tau.y + 2.0 * mixed * n.y * tau.y};
}

}  // namespace tendril
