#pragma once

#include <cstdint>
#include <memory>

#include "obstacle/circle.hpp"
#include "program/pose_program.hpp"

namespace tendril::bench {

/// Tip position and moment, as in the paper's Eq. 5.
class BracedPose : public ObjectiveBase<BracedPose> {
 public:
  Reads reads() const override {
    Reads r;
    r.tip_position = r.moments = true;
    return r;
  }
  template <class T>
  void operator()(const Quantities<T>& x, Contribution<T>& out) const {
    out.residual(x.tip.x - 0.97);
    out.residual(x.tip.y - 0.2);
    out.residual(0.01 * x.moments[0]);
  }
};

/// The program of which one evaluation (cost, gradient, rows, Jacobian) is the unit of costs: the braced arm, order 6,
/// split at its contact, 20 check points. `kind`: 1, the rod is tapered; 2, it stretches.
struct PoseFixture {
  explicit PoseFixture(int order = 6, int check_points = 20, std::int64_t kind = 0) : basis(order) {
    rod.segments[0].weight = 1.68;
    if (kind == 2) {
      rod.stretch_order = order / 2;
      rod.segments[0].axial = 1600.0;
    }
    if (kind == 1) {
      // A round section whose diameter falls by a fifth.
      rod.segments[0].more_stiffness = {-0.8, 0.24, -0.032, 0.0016};
      rod.segments[0].more_weight = {-0.4 * 1.68, 0.04 * 1.68};
    }
    rod.actuators = {{0.0, 1.0, -0.51, 0.51}};
    rod.gravity = {0.0, -1.0};
    PoseProgramSpec spec;
    spec.rod = &rod;
    spec.model = &basis;
    spec.obstacles = {&circle};
    spec.terms = {{&pose, 1.0, "pose"}};
    spec.split = true;
    spec.contacts = {{0, false, 0}};
    const int per_piece = check_points / 2;
    for (int i = 1; i <= per_piece; ++i) {
      for (const int piece : {0, 1}) spec.checks.push_back({piece, static_cast<double>(i) / (per_piece + 1), 0});
    }
    spec.nodes = suggested_nodes(order, 1.0);
    program = std::make_unique<PoseProgram>(spec);
    x = program->start_from(constant_curvature(0.5));
    x[program->layout().first_force] = 1.2;
    y = Eigen::VectorXd::Constant(program->row_count(), 0.3);
  }

  /// A new point each time, so that nothing is found in the cache.
  void nudge() { x[0] += (flip = -flip); }

  LegendreBasis basis;
  Circle circle{{0.6, 0.0}, 0.08};
  BracedPose pose;
  Rod rod;
  std::unique_ptr<PoseProgram> program;
  Eigen::VectorXd x, y;
  double flip = 1e-6;
};

}  // namespace tendril::bench
