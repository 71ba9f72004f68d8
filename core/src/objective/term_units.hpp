#pragma once

namespace tendril {

/// The units of a rod's own program in those of the scene, in which terms see everything. They differ where two fingers
/// of a grasp have rods of their own.
struct TermUnits {
  double length = 1.0;  ///< L of the rod / L of the scene
  double force = 1.0;   ///< EI/L^2 of the rod / the same of the scene
  bool operator==(const TermUnits&) const = default;
};

}  // namespace tendril
