#pragma once

#include <vector>

#include "certificate/clearance.hpp"
#include "program/grasp_program.hpp"

namespace tendril {

/// A finger as a curve in the frame of the grasp.
struct TENDRIL_API FingerCurve {
  const Curve* curve = nullptr;  ///< borrowed, in the finger's own frame and units
  double length = 1.0;           ///< unit of the curve in that of the grasp
  bool mirrored = false;         ///< the lower finger

  Vec2 position(int piece, double sigma) const;  ///< Units of the grasp.
  Vec2 tangent(int piece, double sigma) const;   ///< Of unit length but for the rounding of the curve's series.
};

/// How two fingers lie to each other.
struct FingerClearance {
  /// How far one reaches through the other; 0 where they are proven not to cross, or to do no more than touch (to
  /// tolerance::clearance_sharpness); infinity where neither could be shown.
  double depth = 0.0;
  /// What would keep them apart where they cross: the ends that have passed each other, along the direction that halves
  /// their tangents at the crossing. Where only their bodies lie in each other: the places where they do most.
  std::vector<FingerSeparation> crossings;
};

/// Bisects both curves until every pair of pieces is apart by more than they can bend, or crosses.
TENDRIL_API FingerClearance finger_clearance(const FingerCurve& upper, const FingerCurve& lower);

}  // namespace tendril
