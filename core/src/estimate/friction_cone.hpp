#pragma once

#include <cstddef>
#include <vector>

#include "estimate/estimate_fit.hpp"

namespace tendril {

/// Fits like `fit`, one after the other, of what its contacts may be if each of them has a tangential part of up to
/// `friction` times the normal one (model.md section 11): first `fit` itself, which has none, then along straight lines
/// to the corners and the middle of the edges of their cones. A line ends where no fit is found any more; `whole`: none
/// did.
struct ConeFits {
  std::vector<ShapeFit> fits;
  std::vector<std::size_t> before;  ///< of each fit, that which it started from
  ShapeFit best;                    ///< of all states of friction
  bool whole = true;

  /// Those whose sum of squares is within `most`, and their neighbours: where the points rule a state out, the last one
  /// that they allow lies between it and the one before.
  std::vector<const ShapeFit*> allowed(double most) const;
};
ConeFits fit_cone(const LoadedRod& rod, const MeasuredShape& measured, const ShapeFit& fit, double friction,
                  double accuracy, const Deadline& deadline);

}  // namespace tendril
