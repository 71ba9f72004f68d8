#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "statics/statics.hpp"

namespace tendril {

/// A stretch of check points that press against one obstacle.
struct PressedRun {
  PointContact contact;  ///< at the centre of its force; the stretch of the setup is not filled in
  double from = 0.0, to = 0.0;
};

/// One check point that presses.
struct PressedPoint {
  int obstacle = 0;
  bool joined = false;  ///< to the point before it: in between the rod does not leave the obstacle
  double s = 0.0, force = 0.0;
  bool at_tip = false;
};

struct Descent {
  bool converged = false;
  const char* reason = "";  ///< why not
  Shape shape;
  std::vector<PressedRun> runs;
  double energy = 0.0;
  double stiffness = 0.0;  ///< of the penalty at last, energy per length squared
  /// With rigid obstacles: every check point that presses, and what is left of the softness.
  std::vector<PressedPoint> points;
  std::shared_ptr<const LegendreBasis> basis;  ///< of descend()
  double depth = 0.0;                          ///< of any check point
  double gradient = 0.0;                       ///< of the Lagrangian, in the metric of the bending energy
};

/// Walks downhill from a shape that is no stable equilibrium to one that is, at a load
/// fraction of `path`: minimizes Pi plus an exterior penalty for d(P(s)) >= 0 by a trust-region Newton method whose
/// steps are short, so that the valley found is the one below the start. The penalty stiffens in rounds; what is left
/// of its softness is for Newton's method on point contacts to remove, or, with `rigid`, for an augmented Lagrangian:
/// then the check points stay outside, and their multipliers are the force that is distributed along the rod.
Descent descend(const LoadPath& path, double load, const std::function<double(double)>& curvature,
                const std::function<bool()>& must_stop, bool rigid = false);

/// The same in the coordinates of a model, not split at contacts, with soft obstacles. `model` must outlive the result.
Descent descend_in(const CoordinateModel& model, const LoadPath& path, double load,
                   const std::function<double(double)>& curvature, const std::function<bool()>& must_stop);

}  // namespace tendril
