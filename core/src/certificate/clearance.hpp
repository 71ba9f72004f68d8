#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "rod/curve.hpp"
#include "tendril/obstacle.hpp"

namespace tendril {

/// A depth that the true one does not exceed: bisects every piece until the bound of model.md section 4 is sharp to
/// tolerance::clearance_sharpness or shows clearance. 0: the curve, or the body around it, stays outside.
TENDRIL_API double certified_depth(const Curve& curve, const Obstacle& obstacle);

/// A local minimum of the distance of the body along the rod.
struct ClosestApproach {
  int piece = 0;            ///< of the chain
  double sigma = 0.0;       ///< on the piece, in [0,1]
  double arc_length = 0.0;  ///< units of L
  double distance = 0.0;    ///< signed, units of L
};

/// Local minima of the distance to one obstacle that are below `level`, by sampling and refinement; ends of the rod
/// count.
TENDRIL_API std::vector<ClosestApproach> closest_approaches(const Curve& curve, const Obstacle& obstacle, double level);
/// The same, added to `found`; nothing else is allocated.
TENDRIL_API void closest_approaches(const Curve& curve, const Obstacle& obstacle, double level,
                                    std::vector<ClosestApproach>& found);

}  // namespace tendril
