#pragma once

#include <optional>
#include <vector>

#include "tendril/trajectory.hpp"

namespace tendril {

/// A target that lies at this share of the way from one to another; its obstacles are at the same share of theirs.
TENDRIL_API TargetSpec between(const TargetSpec& a, const TargetSpec& b, double share);

/// A rod that was led along with its obstacles.
struct Led {
  Plan at;                  ///< where it came to rest
  double share = 0.0;       ///< of the way to the step, there
  std::vector<Snap> snaps;  ///< on the way; `load` is the share of the way
};

/// What `step` is executed from where the step before, with the obstacles of `from`, ended at `before`: obstacles that
/// move far are led there together with what is held, in stretches that are shorter than a quarter of their rounding,
/// so that none comes to the other side of the rod. Nothing: no obstacle moves so far, or the rod came to rest on none
/// of these stretches. `control`: as of execute() for the step; its `start` and `place` do not count.
TENDRIL_API std::optional<Led> led_near(const Scene& scene, const ObstaclesAt& obstacles, const TargetSpec& from,
                                        const Plan& before, const TrajectoryStep& step, const ExecuteControl& control);

/// All snaps of a step that was `led` and then executed from there, as TrajectoryStep has them.
TENDRIL_API std::vector<Snap> snaps_of(const std::optional<Led>& led, const Execution& rest);

}  // namespace tendril
