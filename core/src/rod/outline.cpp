#include "rod/outline.hpp"

#include <cmath>

namespace tendril {

void outline(const Rod& rod, const std::function<double(double)>& curvature, int steps,
             std::vector<OutlinePoint>& out) {
  out.clear();
  const double from = rod.port();
  const double h = (1.0 - from) / steps;
  const bool thick = rod.is_thick();
  OutlinePoint p;
  p.position = rod.base;
  p.angle = rod.base_angle;
  for (int i = 0;; ++i) {
    p.s = from + i * h;
    p.tangent = {std::cos(p.angle), std::sin(p.angle)};
    p.curvature = curvature(p.s);
    if (thick) p.radius = rod.radius_at(p.s).value;
    out.push_back(p);
    if (i == steps) return;
    const double middle = p.angle + 0.5 * h * curvature(p.s + 0.25 * h);
    p.position += h * Vec2{std::cos(middle), std::sin(middle)};
    p.angle += h * curvature(p.s + 0.5 * h);
  }
}

}  // namespace tendril
