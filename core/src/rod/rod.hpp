#pragma once

#include <vector>

#include "rod/profile.hpp"
#include "tendril/export.hpp"
#include "tendril/geometry.hpp"
#include "tendril/numbers.hpp"

namespace tendril {

/// The rod of a scene, dimensionless (model.md section 1): length 1, EI of the first segment 1.
struct TENDRIL_API Rod {
  /// A stretch with constant properties.
  struct Segment {
    double from = 0.0;            ///< arc length, units of L
    double to = 1.0;              ///< arc length, units of L
    double stiffness = 1.0;       ///< EI / EI0
    double weight = 0.0;          ///< rho |g| L^3 / EI0
    double rest_curvature = 0.0;  ///< kappa0 L
  };
  /// A moment between two arc lengths, with its limits: u p(s).
  struct Actuator {
    double from = 0.0;                   ///< arc length, units of L
    double to = 1.0;                     ///< arc length, units of L
    double minimum = -infinity;          ///< of u, units of EI0/L
    double maximum = infinity;           ///< of u, units of EI0/L
    std::vector<ProfilePart> profile{};  ///< p from `from` to `to`, in order, without gaps; empty: 1
    /// The part of the profile that holds arc length s between `from` and `to`; null: there is none, p is 1.
    const ProfilePart* part_at(double s) const;
    /// p(s); 0 outside.
    double at(double s) const;
    /// int p ds between two arc lengths.
    double integral(double begin, double end) const;
    /// Whether p is not the same all over one of its parts.
    bool varies() const;
    /// Whether it can do nothing.
    bool fixed_at_zero() const { return minimum == 0.0 && maximum == 0.0; }
  };
  std::vector<Segment> segments{Segment{}};  ///< in order from the base on, without gaps
  std::vector<Actuator> actuators{};         ///< as in the scene
  Vec2 base{};                               ///< where it is clamped, units of L
  double base_angle = 0.0;                   ///< against the x axis, rad
  Vec2 gravity{};                            ///< unit vector, or zero: no gravity
  double payload = 0.0;                      ///< mass |g| L^2 / EI0
  Vec2 tip_force{};                          ///< dead force, times L^2 / EI0

  /// Whether gravity does anything: it has a direction, and the rod or the tip has mass.
  bool has_gravity() const;
  /// Whether a dead force acts on the tip.
  bool has_tip_force() const { return tip_force.x != 0.0 || tip_force.y != 0.0; }
  /// Ends of segments, actuators and parts of their profiles, ascending, 0 and 1 included: the knots that do not move.
  std::vector<double> fixed_knots() const;
  /// The segment that holds arc length s: the later one at a joint, the last one beyond the end.
  const Segment& segment_at(double s) const;
};

/// Two fixed knots closer than this are one (units of L): below it pieces would be all rounding.
inline constexpr double knot_merge_distance = 1e-9;

}  // namespace tendril
