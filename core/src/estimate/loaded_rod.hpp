#pragma once

#include <Eigen/Core>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "rod/rod.hpp"
#include "tendril/coordinate_model.hpp"
#include "tendril/geometry.hpp"
#include "tendril/numbers.hpp"

namespace tendril {

/// A contact as the rod feels it, whatever the obstacle is: a force along the backbone's normal N = (-sin phi, cos phi)
/// at an arc length, and its share along the tangent T = (cos phi, sin phi). Negative forces push to the other side.
/// Dimensionless.
struct NormalForce {
  double force = 0.0;       ///< along N, units of EI0/L^2
  double arc_length = 0.0;  ///< in (0,1)
  double lean = 0.0;        ///< force along T for each unit of `force`
};

/// A rod in equilibrium under given moments, its own loads, and normal forces, each of which has a knot of its own
/// (model.md sections 2 and 3). Integrated Legendre functions of one order on every piece. Everything dimensionless.
///
/// Normal forces turn with the rod, so the equilibrium equations are no gradient: their Jacobian is not symmetric.
class TENDRIL_API LoadedRod {
 public:
  /// `moments`: one per actuator of the rod. `order` in 1..LegendreBasis::maximum_order. `turn`: angle that one piece
  /// may turn by, for the number of nodes.
  LoadedRod(const Rod& rod, std::vector<double> moments, int order, double turn);
  ~LoadedRod();
  LoadedRod(const LoadedRod&) = delete;
  LoadedRod& operator=(const LoadedRod&) = delete;

  /// An equilibrium, and with it the start of another one.
  struct Shape {
    std::vector<NormalForce> forces;  ///< ascending in arc length
    Eigen::VectorXd coordinates;      ///< order() per piece, piece after piece
    bool converged = false;           ///< Whether this is an equilibrium.
    int iterations = 0;               ///< Newton steps
  };
  /// Curvature, times L, as a function of the arc length in [0,1].
  using Curvature = std::function<double(double)>;

  /// Arc lengths closer than this to a fixed knot, to one another, or to the ends are moved apart by solve().
  static constexpr double knot_clearance = 1e-5;

  /// Newton from a curvature given along the rod, or from another shape of this rod. Forces in ascending order of arc
  /// length. A shape that did not converge has the coordinates where Newton stopped.
  Shape solve(std::vector<NormalForce> forces, const Curvature& start) const;
  /// Newton from a shape of this rod.
  Shape solve(std::vector<NormalForce> forces, const Shape& start) const;

  /// Backbone points of a shape at given arc lengths, and how they move with the forces and their places along the
  /// equilibrium (implicit function theorem).
  struct Response {
    Eigen::VectorXd points;            ///< x and y of each arc length in turn
    Eigen::MatrixXd rates;             ///< 2 points x 2 forces: columns force, arc length of each force in turn
    Eigen::MatrixXd coordinate_rates;  ///< coordinates x 2 forces
  };
  /// Of a converged shape at `arc_lengths`, each in [0,1].
  Response response(const Shape& shape, std::span<const double> arc_lengths) const;

  /// How the points at `arc_lengths` move with the lean of each force of a converged shape.
  Eigen::MatrixXd lean_rates(const Shape& shape, std::span<const double> arc_lengths) const;

  /// How the points at `arc_lengths` move with a further force that is 0 so far, one column for each of `places`, of
  /// whose forces only the sign counts.
  Eigen::MatrixXd influence(const Shape& shape, std::span<const double> arc_lengths,
                            std::span<const NormalForce> places) const;

  /// What is out of balance along a curvature without any normal force, and what a unit normal force at each place
  /// would balance of it, both measured by the shape that it bends: vectors of one length, orthonormal in the bending
  /// energy.
  struct Imbalance {
    Eigen::VectorXd missing;    ///< What is out of balance.
    Eigen::MatrixXd per_force;  ///< one column per place
  };
  /// Of the rod bent to `curvature`, with one force for each of `places`, as in influence().
  Imbalance imbalance(const Curvature& curvature, std::span<const NormalForce> places) const;

  /// A point of the rod, dimensionless, with angle (rad) and curvature there.
  struct Point {
    Vec2 position{};         ///< units of L
    double angle = 0.0;      ///< rad
    double curvature = 0.0;  ///< times L
  };
  /// Points of a shape at `arc_lengths`, each in [0,1].
  std::vector<Point> points(const Shape& shape, std::span<const double> arc_lengths) const;

  /// Curvature of a shape along the rod. It refers to this rod and must not outlive it.
  Curvature curvature(const Shape& shape) const;

  /// Functions per piece.
  int order() const { return basis_.function_count(); }
  /// The rod that it was made of.
  const Rod& rod() const { return rod_; }
  /// Equilibria that were solved for so far.
  int solve_count() const { return solves_; }

 private:
  class Pieces;
  /// The pieces for forces in these stretches between fixed knots; made once each.
  Pieces& pieces(std::span<const NormalForce> forces) const;
  Eigen::VectorXd coordinates(std::span<const NormalForce> forces, const Curvature& curvature) const;
  /// What forces at places do to the coordinates of a state, one column each: of `normal` along N and, on the side that
  /// the place's force pushes from, its lean along T.
  static Eigen::MatrixXd unit_forces(Pieces& pieces, std::span<const NormalForce> places, double normal = 1.0);
  /// How the points at `arc_lengths` move with generalized forces, one column each.
  static Eigen::MatrixXd answer(Pieces& pieces, const Eigen::MatrixXd& forces, std::span<const double> arc_lengths);
  Shape newton(std::vector<NormalForce> forces, Eigen::VectorXd coordinates) const;
  void move_apart(std::vector<NormalForce>& forces) const;
  std::vector<int> stretches(std::span<const NormalForce> forces) const;

  Rod rod_;
  std::vector<double> moments_;
  LegendreBasis basis_;
  double turn_;
  std::vector<double> knots_;
  mutable std::map<std::vector<int>, std::unique_ptr<Pieces>> pieces_;
  mutable int solves_ = 0;
};

}  // namespace tendril
