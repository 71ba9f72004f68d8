#include "tendril/rod.hpp"

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

Rod make_rod(const Scene& scene, const Scale& scale) {
  Rod rod;
  rod.segments.clear();
  const double length = scene.rod.length();
  const double g = scene.gravity ? norm(*scene.gravity) : 0.0;
  // Forces per length come in EI0/L^3; weights are rounded like every other datum.
  constexpr Dimension per_length{-1, 1, "N/m"};
  double from = 0.0;
  for (const SegmentSpec& spec : scene.rod.segments) {
    Rod::Segment s;
    s.from = from;
    s.to = round_to_12_digits(from + spec.length / length);
    s.stiffness = round_to_12_digits(spec.bending_stiffness / scale.stiffness);
    s.weight = scale.to_dimensionless(spec.linear_density * g, per_length);
    s.rest_curvature = scale.to_dimensionless(spec.rest_curvature, dimension::curvature);
    rod.segments.push_back(s);
    from = s.to;
  }
  rod.segments.back().to = 1.0;
  for (const ActuatorSpec& spec : scene.rod.actuators) {
    Rod::Actuator a;
    a.from = scale.to_dimensionless(spec.from, dimension::length);
    a.to = std::min(1.0, scale.to_dimensionless(spec.to, dimension::length));
    a.minimum = scale.to_dimensionless(spec.minimum, dimension::moment);
    a.maximum = scale.to_dimensionless(spec.maximum, dimension::moment);
    rod.actuators.push_back(a);
  }
  rod.base = {scale.to_dimensionless(scene.rod.base_position.x, dimension::length),
              scale.to_dimensionless(scene.rod.base_position.y, dimension::length)};
  rod.base_angle = round_to_12_digits(scene.rod.base_angle);
  if (g > 0.0) rod.gravity = {round_to_12_digits(scene.gravity->x / g), round_to_12_digits(scene.gravity->y / g)};
  rod.payload = scale.to_dimensionless(scene.tip_load.mass * g, dimension::force);
  rod.tip_force = {scale.to_dimensionless(scene.tip_load.force.x, dimension::force),
                   scale.to_dimensionless(scene.tip_load.force.y, dimension::force)};
  return rod;
}

}  // namespace tendril
