#include "rod/rod.hpp"

#include <algorithm>
#include <cmath>

#include "rod/quadrature.hpp"

namespace tendril {

Rod::Jet Rod::Segment::at(double s, double start, const std::vector<double>& more) const {
  const double length = to - from;
  const double x = (s - from) / length;
  Jet jet;
  for (auto c = more.rbegin();; ++c) {
    jet = {jet.value * x + (c != more.rend() ? *c : start), jet.slope * x + jet.value, jet.bend * x + 2.0 * jet.slope,
           jet.jerk * x + 3.0 * jet.bend};
    if (c == more.rend()) break;
  }
  return {jet.value, jet.slope / length, jet.bend / (length * length), jet.jerk / (length * length * length)};
}

double Rod::Segment::up_to(double s, double start, const std::vector<double>& more) const {
  if (more.empty()) return start * (s - from);
  const double x = (s - from) / (to - from);
  double mean = 0.0;
  for (auto i = more.size(); i > 0; --i) mean = (mean + more[i - 1] / static_cast<double>(i + 1)) * x;
  return (start + mean) * (s - from);
}

Rod::Jet Rod::Segment::radius_bounds() const {
  const double length = to - from;
  Jet bounds{std::max(radius, radius_at(to).value)};
  for (std::size_t i = 0; i < more_radius.size(); ++i) {
    const auto power = static_cast<double>(i + 1);
    const double size = std::abs(more_radius[i]);
    bounds.slope += power * size / length;
    bounds.bend += power * (power - 1.0) * size / (length * length);
  }
  bounds.value += length * length / 8.0 * bounds.bend;
  return bounds;
}

double Rod::Segment::compliance(double low, double high, const ProfilePart* profile) const {
  const double start = std::max(low, from);
  const double length = std::min(high, to) - start;
  if (!(length > 0.0)) return 0.0;
  if (more_stiffness.empty() && profile == nullptr) return length / stiffness;
  static const Quadrature rule(24);
  double sum = 0.0;
  for (int i = 0; i < rule.size(); ++i) {
    const double s = start + length * rule.nodes()[i];
    const double moment = profile == nullptr ? 1.0 : profile->at(s);
    sum += length * rule.weights()[i] * moment / stiffness_at(s).value;
  }
  return sum;
}

double Rod::Segment::holding_moment(double low, double high, double curvature) const {
  if (bends_evenly()) return stiffness * (curvature - rest_curvature);
  const double rest =
      up_to(high, rest_curvature, more_rest_curvature) - up_to(low, rest_curvature, more_rest_curvature);
  return (curvature * (high - low) - rest) / compliance(low, high);
}

bool Rod::has_gravity() const {
  if (gravity == Vec2{}) return false;
  return payload != 0.0 || std::any_of(loads.begin(), loads.end(), [](const Load& l) { return l.weight != 0.0; }) ||
         std::any_of(segments.begin(), segments.end(),
                     [](const Segment& s) { return s.weight != 0.0 || !s.weighs_evenly(); });
}

bool Rod::has_dead_loads() const {
  return std::any_of(loads.begin(), loads.end(), [](const Load& l) { return l.force != Vec2{}; });
}

Vec2 Rod::whole_load() const {
  double weight = payload;
  Vec2 force = tip_force;
  for (const Segment& s : segments) weight += s.whole_weight();
  for (const Load& l : loads) {
    weight += l.weight;
    force += (l.at_point() ? 1.0 : l.to - l.from) * l.force;
  }
  return weight * gravity + force;
}

bool Rod::has_torsion() const {
  return std::all_of(segments.begin(), segments.end(), [](const Segment& s) { return s.torsion > 0.0; });
}

bool Rod::is_thick() const {
  return std::any_of(segments.begin(), segments.end(),
                     [](const Segment& s) { return s.radius != 0.0 || !s.more_radius.empty(); });
}

double Rod::most_radius() const {
  double most = 0.0;
  for (const Segment& s : segments) most = std::max(most, s.radius_bounds().value);
  return most;
}

std::vector<double> Rod::starts() const {
  std::vector<double> starts;
  for (const Move& m : moves) starts.push_back(m.start);
  return starts;
}

std::vector<double> Rod::fixed_knots() const {
  std::vector<double> ends{0.0, 1.0};
  for (const Segment& s : segments) ends.push_back(s.to);
  for (const Actuator& a : actuators) {
    ends.push_back(a.from);
    ends.push_back(a.to);
    for (const ProfilePart& part : a.profile) ends.push_back(part.to);
  }
  for (const Load& l : loads) {
    ends.push_back(l.from);
    ends.push_back(l.to);
  }
  std::sort(ends.begin(), ends.end());
  std::vector<double> knots{0.0};
  for (const double e : ends) {
    if (e > knots.back() + knot_merge_distance && e < 1.0 - knot_merge_distance) knots.push_back(e);
  }
  knots.push_back(1.0);
  knots.erase(knots.begin(), knots.begin() + hidden);
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

double Rod::Actuator::compliance(const Segment& segment) const {
  if (profile.empty()) return segment.compliance(from, to);
  double sum = 0.0;
  for (const ProfilePart& part : profile) sum += segment.compliance(part.from, part.to, &part);
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
