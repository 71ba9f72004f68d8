#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "statics.hpp"

namespace tendril {

/// A stretch of check points that press against one obstacle.
struct PressedRun {
  PointContact contact;       ///< at the centre of its force; the stretch of the setup is not filled in
  double from = 0.0, to = 0.0;
};

struct Descent {
  bool converged = false;
  const char* reason = "";  ///< why not
  Shape shape;
  std::vector<PressedRun> runs;
  double energy = 0.0;
};

/// Walks downhill from a shape that is no stable equilibrium to one that is, at the loads of `path` as they stand:
/// minimizes Pi plus an exterior penalty for d(P(s)) >= 0 by a trust-region Newton method whose steps are short, so that
/// the valley found is the one below the start. The penalty stiffens in rounds; what is left of its softness is for
/// Newton's method on point contacts to remove.
Descent descend(const LoadPath& path, const std::function<double(double)>& curvature,
                const std::function<bool()>& must_stop);

}  // namespace tendril
