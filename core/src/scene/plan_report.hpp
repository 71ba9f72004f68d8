#pragma once

#include <functional>
#include <string>
#include <vector>

#include "certificate/clearance.hpp"
#include "program/pose_program.hpp"
#include "rod/rod.hpp"
#include "tendril/plan.hpp"
#include "tendril/scale.hpp"
#include "tendril/scene.hpp"

namespace tendril {

/// Points of a rod in SI units, every knot included: at least 100 at first. A piece whose length changes keeps its
/// number of points as long as that is within a quarter of what its length asks for, and nothing is allocated.
class BackboneSampler {
 public:
  explicit BackboneSampler(const Chain& chain);
  /// Replaces `out` by points of the program's shape computed last, whose curve this is. `length`: of the rod, m.
  void sample(const PoseProgram& program, const Curve& curve, double length, std::vector<BackbonePoint>& out);

 private:
  struct Piece {
    Piece() = default;
    Piece(const Chain& chain, int steps);
    CurveSamples samples;
    Eigen::MatrixXd value, first;        ///< of the basis, a row per point
    Eigen::VectorXd x, y, angle, slope;  ///< of the points: memory that is used again
  };
  std::vector<Piece> pieces_;
};

/// The shape of a program's point computed last as points in SI units, at least 100 of them, every knot included.
std::vector<BackbonePoint> sampled_backbone(const PoseProgram& program, double length);

/// The contacts of a program's point computed last in SI units.
std::vector<PlannedContact> planned_contacts(const PoseProgram& program, const std::vector<std::string>& obstacle_names,
                                             const Scale& scale);
/// The same into `contacts`, whose memory is used again.
void planned_contacts(const PoseProgram& program, const std::vector<std::string>& obstacle_names, const Scale& scale,
                      std::vector<PlannedContact>& contacts);

/// Where a program's rod has been moved to at x, which it was evaluated at last.
RodPlace place_of(const PoseProgram& program, ConstVectorRef x, const Scale& scale);
/// The place of a finger in the world, in the frame of its palm; of a scene without one as it is.
RodPlace place_on_palm(const Scene& scene, RodPlace place);
/// The same as numbers of Rod::moves; `otherwise`: those of what is absent.
std::vector<double> moves_of(const Rod& rod, const Scale& scale, const RodPlace& place, std::vector<double> otherwise);

/// The shape of a start, integrated by midpoints: a line for the figure.
std::vector<BackbonePoint> outline(const StartShape& shape, const Rod& rod, double length);

/// The curvature of an earlier plan of a rod of this length (m), dimensionless, over s/L.
TENDRIL_API std::function<double(double)> curvature_of(const Plan& plan, double length);

/// What a scene calls its obstacles, or "obstacle 1", ...
std::vector<std::string> obstacle_names(const Scene& scene);

}  // namespace tendril
