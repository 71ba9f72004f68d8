#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "tendril/scene.hpp"

namespace tendril {

/// A load along the rod's direction at its base, and to the left of that.
inline Vec2 seen_from_base(Vec2 load, double base_angle) {
  return std::cos(base_angle) * load - std::sin(base_angle) * turned(load);
}

/// Adds a note for every actuator that is told less, or more, than its rod was calibrated with, and for every load
/// beyond those. `moments` (N m) and `turns` as in Plan; `base_angle`: rad, in the axes of the scene's gravity;
/// `whose`: stands before a note, as "lower finger: ".
void tell_beyond_calibration(const Scene& scene, const std::vector<double>& moments, const std::vector<double>& turns,
                             double base_angle, const std::string& whose, std::vector<std::string>& notes);

}  // namespace tendril
