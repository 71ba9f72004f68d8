#pragma once

#include <string>
#include <vector>

#include "estimate/contact_tracker.hpp"
#include "estimate/plausibility.hpp"
#include "rod/rod.hpp"
#include "tendril/estimate_sequence.hpp"
#include "tendril/scene.hpp"

namespace tendril {

/// Moments of the actuators (N m) while the points were measured. Throws SceneError where they are not known.
std::vector<double> known_moments(const Scene& scene);

/// The scene made dimensionless.
struct EstimateInput {
  /// Throws SceneError if the scene has no measurement that determines anything.
  explicit EstimateInput(const Scene& scene);
  /// Likewise, of a frame.
  EstimateInput(const Scene& scene, const SequenceSpec& spec);

  Scale scale;
  Rod rod;
  std::vector<double> moments;
  MeasuredShape measured;
  std::vector<SequenceFrame> frames;  ///< instead, of a sequence
  int most_contacts = 1;
  double friction = 0.0;  ///< coefficient of whatever touches the rod
  bool equal_spacing = false;
  int at_base = 0;  ///< measured points that stand at the base and say nothing

 private:
  void take_contacts(const Scene& scene);
  std::vector<double> dimensionless(const std::vector<double>& si) const;
  MeasuredShape shape_of(const Scene& scene);
};

}  // namespace tendril
