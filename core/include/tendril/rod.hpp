#pragma once

#include <vector>

#include "tendril/geometry.hpp"
#include "tendril/scale.hpp"
#include "tendril/scene.hpp"

namespace tendril {

/// The rod of a scene, dimensionless (model.md section 1): length 1, EI of the first segment 1.
struct TENDRIL_API Rod {
  /// A stretch with constant properties.
  struct Segment {
    double from = 0.0;
    double to = 1.0;
    double stiffness = 1.0;       ///< EI / EI0
    double weight = 0.0;          ///< rho |g| L^3 / EI0
    double rest_curvature = 0.0;  ///< kappa0 L
  };
  /// A moment between two arc lengths, with its limits.
  struct Actuator {
    double from = 0.0;
    double to = 1.0;
    double minimum = -infinity;
    double maximum = infinity;
    bool fixed_at_zero() const { return minimum == 0.0 && maximum == 0.0; }
  };
  std::vector<Segment> segments{Segment{}};
  std::vector<Actuator> actuators{};
  Vec2 base{};
  double base_angle = 0.0;
  Vec2 gravity{};        ///< unit vector, or zero: no gravity
  double payload = 0.0;  ///< mass |g| L^2 / EI0
  Vec2 tip_force{};      ///< dead force, times L^2 / EI0

  bool has_gravity() const;
  bool has_tip_force() const { return tip_force.x != 0.0 || tip_force.y != 0.0; }
  /// Ends of segments and actuators, ascending, 0 and 1 included: the knots that do not move.
  std::vector<double> fixed_knots() const;
  const Segment& segment_at(double s) const;
};

/// Two fixed knots closer than this are one (units of L): below it pieces would be all rounding.
inline constexpr double knot_merge_distance = 1e-9;

TENDRIL_API Rod make_rod(const Scene& scene, const Scale& scale);

}  // namespace tendril
