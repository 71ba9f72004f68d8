#pragma once

#include <Eigen/Core>
#include <vector>

#include "tendril/geometry.hpp"
#include "tendril/plan.hpp"
#include "tendril/scene.hpp"

namespace tendril::bench {

/// An actuator: where it bends the rod, and its moment.
struct Span {
  double from = 0.0, to = 1.0, moment = 0.0;
};

/// A segment of the rod.
struct Stretch {
  double from, to, stiffness, weight, rest;
};

/// The rod of a scene under the moments of a plan, by definitions of its own. Dimensionless.
struct Loaded {
  std::vector<Stretch> segments;
  std::vector<Span> actuators;
  Vec2 base{}, gravity{}, tip_force{};
  double base_angle = 0.0;
  double loads = 1.0;  ///< sum of all, for what rounding of the data does

  Loaded(const Scene& scene, const Plan& plan);

  /// Ends of segments and actuators, ascending.
  std::vector<double> knots() const;
};

/// The shape of a rod in coordinates pcc, psc or legendre: by cumulative quadrature of its angle.
class RodShape {
 public:
  /// `moving`: arc lengths of knots at contacts. `coordinates`: of the plan, for their number. `order`: functions per
  /// piece. Throws Error where they do not fit.
  RodShape(const Loaded& rod, const std::vector<double>& moving, Eigen::Index coordinates, int order);

  struct Piece {
    double from = 0.0, length = 1.0;
    std::size_t segment = 0;
  };
  const std::vector<Piece>& pieces() const { return pieces_; }

  /// The rod cut into panels at pieces and at further places, with all that a quadrature needs at their nodes.
  struct Grid {
    std::vector<double> s, weight, angle, curvature;  ///< weight: of arc length
    std::vector<std::size_t> piece;
    std::vector<Vec2> at;
    Eigen::MatrixXd slopes;  ///< d curvature / d q of the node's piece, a column per node
    Vec2 tip{};
    double tip_angle = 0.0;
    std::vector<double> load;       ///< integral of rho beyond s
    std::vector<Vec2> load_moment;  ///< and of rho P
  };
  Grid grid(const Eigen::VectorXd& q, const std::vector<double>& cuts) const;

  struct Point {
    Vec2 at{};
    double angle = 0.0;
  };
  Point point(const Eigen::VectorXd& q, double s) const;

 private:
  void add_weight(Grid& g) const;

  const Loaded& rod_;
  int order_;
  std::vector<Piece> pieces_;
};

}  // namespace tendril::bench
