#include "rod/rod.hpp"

#include <algorithm>
#include <cmath>

namespace tendril {

bool Rod::has_gravity() const {
  if (gravity == Vec2{}) return false;
  return payload != 0.0 ||
         std::any_of(segments.begin(), segments.end(), [](const Segment& s) { return s.weight != 0.0; });
}

std::vector<double> Rod::fixed_knots() const {
  std::vector<double> ends{0.0, 1.0};
  for (const Segment& s : segments) ends.push_back(s.to);
  for (const Actuator& a : actuators) {
    ends.push_back(a.from);
    ends.push_back(a.to);
  }
  std::sort(ends.begin(), ends.end());
  std::vector<double> knots{0.0};
  for (const double e : ends) {
    if (e > knots.back() + knot_merge_distance && e < 1.0 - knot_merge_distance) knots.push_back(e);
  }
  knots.push_back(1.0);
  return knots;
}

const Rod::Segment& Rod::segment_at(double s) const {
  for (const Segment& segment : segments) {
    if (s < segment.to) return segment;
  }
  return segments.back();
}

std::vector<Vec2> drawn(const Rod& rod, const std::function<double(double)>& curvature, int steps) {
  std::vector<Vec2> points{rod.base};
  double angle = rod.base_angle;
  const double h = 1.0 / steps;
  for (int i = 0; i < steps; ++i) {
    const double middle = angle + 0.5 * h * curvature((i + 0.25) * h);
    points.push_back(points.back() + h * Vec2{std::cos(middle), std::sin(middle)});
    angle += h * curvature((i + 0.5) * h);
  }
  return points;
}

}  // namespace tendril
