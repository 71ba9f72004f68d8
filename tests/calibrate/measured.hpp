#pragma once

#include <cstdint>
#include <ostream>
#include <string>
#include <vector>

#include "support/rod_bvp.hpp"
#include "tendril/calibrate.hpp"

namespace tendril {

/// The name that results write.
inline void PrintTo(CalibrationStatus value, std::ostream* out) { *out << to_string(value); }

}  // namespace tendril

namespace tendril::test {

/// A silicone arm of 100 mm that lies along x and hangs down, and recordings of it as the boundary-value problem has
/// them: exact points, which share nothing with what a calibration computes.
struct MeasuredArm {
  double stiffness = 4.9e-4;  ///< N m^2, of the truth
  double density = 0.084;     ///< kg/m
  double rest_curvature = 0.0;
  Vec2 base{};
  double base_angle = 0.0;
  double length = 0.1;

  /// The scene, whose numbers are not those of the truth.
  Scene scene() const;
  /// What is seen at equally spaced arc lengths, the last one at the tip. `moments`: N m. `payload`: kg.
  Recording recording(double moment, double payload, int points) const;
  /// The same under a gravity of another direction.
  Recording recording(double moment, double payload, int points, Vec2 gravity) const;
};

/// Adds independent normal noise to all coordinates.
void add_noise(std::vector<Recording>& recordings, double noise, std::uint64_t seed);

/// The recordings that scenes/calibrate.csv holds: exact shapes of an arm of 5.2e-4 N m^2 whose chamber gives 1.3e-8 N
/// m per Pa, with noise of 0.1 mm, seed 1, rounded to micrometres.
std::string calibration_file();

/// An unknown of a kind.
CalibrationUnknownSpec unknown(CalibrationUnknown kind);

}  // namespace tendril::test
