#include "rod/rod.hpp"

#include <algorithm>
#include <utility>

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
    for (const ProfilePart& part : a.profile) ends.push_back(part.to);
  }
  std::sort(ends.begin(), ends.end());
  std::vector<double> knots{0.0};
  for (const double e : ends) {
    if (e > knots.back() + knot_merge_distance && e < 1.0 - knot_merge_distance) knots.push_back(e);
  }
  knots.push_back(1.0);
  return knots;
}

const ProfilePart* Rod::Actuator::part_at(double s) const {
  for (const ProfilePart& part : profile) {
    if (s < part.to) return &part;
  }
  return profile.empty() ? nullptr : &profile.back();
}

double Rod::Actuator::at(double s) const {
  if (!(s > from && s < to)) return 0.0;
  const ProfilePart* part = part_at(s);
  return part == nullptr ? 1.0 : part->at(s);
}

double Rod::Actuator::integral(double begin, double end) const {
  const auto common = [&](double part_from, double part_to) {
    return std::pair{std::max(begin, part_from), std::min(end, part_to)};
  };
  if (profile.empty()) {
    const auto [low, high] = common(from, to);
    return std::max(0.0, high - low);
  }
  double sum = 0.0;
  for (const ProfilePart& part : profile) {
    const auto [low, high] = common(part.from, part.to);
    if (low < high) sum += part.integral(high) - part.integral(low);
  }
  return sum;
}

bool Rod::Actuator::varies() const {
  return std::any_of(profile.begin(), profile.end(), [](const ProfilePart& part) { return !part.constant(); });
}

const Rod::Segment& Rod::segment_at(double s) const {
  for (const Segment& segment : segments) {
    if (s < segment.to) return segment;
  }
  return segments.back();
}

}  // namespace tendril
