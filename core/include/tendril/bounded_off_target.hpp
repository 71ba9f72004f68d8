#pragma once

#include "tendril/export.hpp"

namespace tendril {

/// What an objective term may be besides an ObjectiveTerm: one whose bound grows with the distance of the tip from the
/// target. Core uses it to leave out ways of being in contact whose tip cannot come near enough to win.
class TENDRIL_API BoundedOffTarget {
 public:
  virtual ~BoundedOffTarget();
  /// A number that the term can never go below where the tip is at least `distance` (units of L) from the target's
  /// position, whatever else it is given. It must not fall with the distance. Asked only where the target has a
  /// position.
  virtual double lower_bound_off_target(double distance) const = 0;
};

}  // namespace tendril
