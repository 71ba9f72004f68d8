#pragma once

#include <cmath>

#include "support/rod_bvp.hpp"

/// What chains of rigid links know of the plane and of obstacles.
namespace tendril::support {

inline Point direction(double angle) { return {std::cos(angle), std::sin(angle)}; }
inline double dot(Point a, Point b) { return a.x * b.x + a.y * b.y; }
inline Point turned(Point a) { return {-a.y, a.x}; }

/// Outward normal, gap and curvature of the gap's level line.
struct ChainSurface {
  Point normal{};
  double gap = 0.0;
  double curvature = 0.0;
};

/// Throws BvpError on a circle's centre.
inline ChainSurface surface(const BvpContact& c, Point p) {
  const Point d{p.x - c.center.x, p.y - c.center.y};
  if (c.wall_normal.x != 0.0 || c.wall_normal.y != 0.0) return {c.wall_normal, dot(d, c.wall_normal), 0.0};
  const double distance = std::hypot(d.x, d.y);
  if (!(distance > 0.0)) throw BvpError("a joint lies on an obstacle's centre");
  return {{d.x / distance, d.y / distance}, distance - c.radius, 1.0 / distance};
}

}  // namespace tendril::support
