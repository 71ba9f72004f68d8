#include "rod/rod.hpp"

#include <algorithm>

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

}  // namespace tendril
