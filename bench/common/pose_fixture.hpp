#pragma once

#include <cmath>
#include <cstdint>
#include <deque>
#include <memory>
#include <numbers>

#include "obstacle/circle.hpp"
#include "obstacle/part.hpp"
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

/// A toothed wheel where the circle is: its teeth reach as far as that.
inline tendril::Part wheel(Vec2 center, double radius, int corners) {
  ClosedLine line;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / corners;
    const double reach = (i % 2 == 0 ? 0.95 : 0.9) * radius;
    line.push_back(center + reach * Vec2{std::cos(angle), std::sin(angle)});
  }
  return tendril::Part({line}, 0.05 * radius);
}

inline constexpr std::int64_t tapered = 1, stretching = 2, toothed = 3, crowded = 4;

/// The program of which one evaluation (cost, gradient, rows, Jacobian) is the unit of costs: the braced arm, order 6,
/// split at its contact, 20 check points. `kind`: the rod is tapered (1) or stretches (2),
/// its obstacle has 200 sides (3), or 199 further circles stand around (4).
struct PoseFixture {
  explicit PoseFixture(int order = 6, int check_points = 20, std::int64_t kind = 0) : basis(order) {
    rod.segments[0].weight = 1.68;
    if (kind == stretching) {
      rod.stretch_order = order / 2;
      rod.segments[0].axial = 1600.0;
    }
    if (kind == tapered) {
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
    if (kind == toothed) spec.obstacles = {&teeth};
    if (kind == crowded) {
      for (int i = 0; i < 199; ++i) {
        const int row = i / 20;
        crowd.emplace_back(Vec2{0.1 * (i % 20) - 0.5, 0.1 * row + 0.6}, 0.01);
      }
      for (const Circle& c : crowd) spec.obstacles.push_back(&c);
    }
    spec.terms = {{&pose, 1.0, "pose"}};
    spec.split = true;
    spec.contacts = {{0, false, 0}};
    const int per_piece = check_points / 2;
    for (int i = 1; i <= per_piece; ++i) {
      for (const int piece : {0, 1}) {
        const int obstacle = 2 * (i - 1) + piece;
        spec.checks.push_back({piece, static_cast<double>(i) / (per_piece + 1), kind == crowded ? obstacle : 0});
      }
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
  tendril::Part teeth = wheel({0.6, 0.0}, 0.08, 200);
  std::deque<Circle> crowd;
  BracedPose pose;
  Rod rod;
  std::unique_ptr<PoseProgram> program;
  Eigen::VectorXd x, y;
  double flip = 1e-6;
};

}  // namespace tendril::bench
