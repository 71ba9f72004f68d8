#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "statics/statics.hpp"

namespace tendril {

struct Descent {
  bool converged = false;
  const char* reason = "";  ///< why not
  /// Each stretch of check points that press against one obstacle is one contact at the centre of its force, whose
  /// region is not filled in. With rigid obstacles: every check point that presses is one. Tendons that are held by
  /// their length are kept from being longer as obstacles are kept out.
  State state;
  double energy = 0.0;
  double stiffness = 0.0;                      ///< of the penalty at last, energy per length squared
  std::shared_ptr<const LegendreBasis> basis;  ///< of descend()
  double depth = 0.0;                          ///< of any check point, with rigid obstacles
  double gradient = 0.0;                       ///< of the Lagrangian, in the metric of the bending energy
};

/// Walks downhill from a shape that is no stable equilibrium to one that is, at a load
/// fraction of `path`: minimizes Pi plus an exterior penalty for d(P(s)) >= 0 by a trust-region Newton method whose
/// steps are short, so that the valley found is the one below the start. The penalty stiffens in rounds; what is left
/// of its softness is for Newton's method on point contacts to remove, or, with `rigid`, for an augmented Lagrangian:
/// then the check points stay outside, and their multipliers are the force that is distributed along the rod.
Descent descend(const LoadPath& path, double load, const Curvature& curvature, const std::function<bool()>& must_stop,
                bool rigid = false);

/// Where arcs of every turn up to +-`widest` (rad) come to rest, coarsely: few functions, few check points, and between
/// two arcs that come to rest in one valley no other is let go. Each valley once.
std::vector<Descent> descend_from_arcs(const LoadPath& path, double load, double widest, int arcs,
                                       const std::function<bool()>& must_stop);

/// The same in the coordinates of a model, not split at contacts, with soft obstacles. `model` must outlive the result.
Descent descend_in(const CoordinateModel& model, const LoadPath& path, double load, const Curvature& curvature,
                   const std::function<bool()>& must_stop);

}  // namespace tendril
