#pragma once

#include <string>
#include <vector>

#include "estimate/estimate_fit.hpp"
#include "estimate/plausibility.hpp"
#include "rod/rod.hpp"
#include "tendril/scene.hpp"

namespace tendril {

/// Moments of the actuators (N m) while the points were measured. Throws SceneError where they are not known.
std::vector<double> known_moments(const Scene& scene);

/// The scene made dimensionless.
struct EstimateInput {
  /// Throws SceneError if the scene has no measurement that determines anything.
  explicit EstimateInput(const Scene& scene);

  Scale scale;
  Rod rod;
  std::vector<double> moments;
  MeasuredShape measured;
  int most_contacts = 1;
  double friction = 0.0;  ///< coefficient of whatever touches the rod
  bool equal_spacing = false;
  int at_base = 0;  ///< measured points that stand at the base and say nothing

  std::string hint() const { return misfit_hint(rod, measured, moments, equal_spacing, scale.length); }
};

}  // namespace tendril
