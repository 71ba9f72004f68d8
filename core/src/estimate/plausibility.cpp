#include "estimate/plausibility.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tendril {
namespace {

/// Errors of points beyond this many standard deviations are none.
constexpr double most_deviations = 10.0;

std::string text(double value) { return shown(value, 3); }

Vec2 point_of(const MeasuredShape& measured, std::size_t i) {
  const auto at = static_cast<Eigen::Index>(2 * i);
  return {measured.points[at], measured.points[at + 1]};
}

/// Turn of the tip against the base that moments and rest curvature alone would make.
double turn_of_moments(const Rod& rod, std::span<const double> moments) {
  double turn = 0.0;
  for (const Rod::Segment& s : rod.segments) turn += s.rest_turn();
  for (std::size_t a = 0; a < rod.actuators.size(); ++a) {
    for (const Rod::Segment& s : rod.segments) {
      turn += moments[a] * rod.actuators[a].compliance(s);
    }
  }
  return turn;
}

/// By how much the points lie further from the base than the rod reaches at their arc lengths, at most; also with arc
/// lengths counted from the tip.
struct Excess {
  double from_base = 0.0;
  double from_tip = 0.0;
};

Excess excess_of(const Rod& rod, const MeasuredShape& measured) {
  Excess excess;
  for (std::size_t i = 0; i < measured.arc_lengths.size(); ++i) {
    const double distance = norm(point_of(measured, i) - rod.base);
    excess.from_base = std::max(excess.from_base, distance - measured.arc_lengths[i]);
    excess.from_tip = std::max(excess.from_tip, distance - (1.0 - measured.arc_lengths[i]));
  }
  return excess;
}

/// The direction of the first point from the base, against that of the base itself (rad); 0 if it is too far away to
/// tell.
double first_direction(const Rod& rod, const MeasuredShape& measured) {
  constexpr double near = 0.3;
  if (measured.arc_lengths.front() > near) return 0.0;
  const Vec2 d = point_of(measured, 0) - rod.base;
  return norm(d) > 0.0 ? std::remainder(std::atan2(d.y, d.x) - rod.base_angle, 2.0 * std::numbers::pi) : 0.0;
}

/// Ratio of the largest to the smallest distance of neighbours.
double unevenness(const MeasuredShape& measured) {
  double least = infinity;
  double most = 0.0;
  for (std::size_t i = 1; i < measured.arc_lengths.size(); ++i) {
    const double chord = norm(point_of(measured, i) - point_of(measured, i - 1));
    least = std::min(least, chord);
    most = std::max(most, chord);
  }
  return most / least;
}

}  // namespace

std::string misfit_hint(const Rod& rod, const MeasuredShape& measured, std::span<const double> moments,
                        bool equal_spacing, double length) {
  const auto metres = [&](double value) { return text(value * length) + " m"; };
  const double errors = std::max(0.01, most_deviations * measured.noise);
  double farthest = 0.0;
  for (std::size_t i = 0; i < measured.arc_lengths.size(); ++i) {
    farthest = std::max(farthest, norm(point_of(measured, i) - rod.base));
  }
  if (farthest < 0.02) {
    return "; all points lie within " + metres(farthest) + " of the base of a rod of " + metres(1.0) +
           ": is their unit right?";
  }
  const Excess excess = excess_of(rod, measured);
  if (excess.from_base > errors) {
    return "; a point lies " + metres(excess.from_base) +
           " further from the base than the rod reaches at its arc length: " +
           (excess.from_tip < 0.25 * excess.from_base
                ? "are the arc lengths counted from the tip?"
                : "are the rod's length and base, and the points' unit and origin right?");
  }
  if (const double direction = first_direction(rod, measured); std::abs(direction) > 0.3 * std::numbers::pi) {
    return "; the first point lies in a direction that differs by " + text(direction * 180.0 / std::numbers::pi) +
           " deg from the base's angle: are the base's angle and the points' axes ('y_down') right?";
  }
  const double turn = turn_of_moments(rod, moments);
  if (const double seen = measured_turn(rod, measured); std::abs(turn) > seen + std::numbers::pi) {
    return "; the moments alone would turn the tip by " + text(turn) + " rad, and the points turn by " + text(seen) +
           " rad: are the moments right?";
  }
  constexpr double uneven = 1.3;
  if (const double ratio = unevenness(measured);
      equal_spacing && ratio > uneven &&
      measured.noise * 30.0 < 1.0 / static_cast<double>(measured.arc_lengths.size())) {
    return "; the distances of neighbouring points differ by a factor of " + text(ratio) +
           ", and without arc lengths (s) they are taken to be equal along the rod";
  }
  return "";
}

}  // namespace tendril
