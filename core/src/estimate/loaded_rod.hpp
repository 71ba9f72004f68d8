#pragma once

#include <Eigen/Core>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "rod/places.hpp"
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

/// A rod in equilibrium under known loads and under normal forces, each of which has a knot of its own (model.md
/// sections 2 and 3), as a function of its properties, its loads, and these forces. Integrated Legendre functions of
/// one order on every piece. Everything dimensionless, in units of the rod that it is made of.
///
/// Normal forces turn with the rod, so the equilibrium equations are no gradient: their Jacobian is not symmetric.
class TENDRIL_API LoadedRod {
 public:
  /// Factors on the rod's properties, and what is added to them.
  struct Properties {
    Eigen::VectorXd stiffness;       ///< factor on EI, one per segment
    Eigen::VectorXd axial;           ///< factor on EA, one per segment
    Eigen::VectorXd rest_curvature;  ///< added, one per segment
    double density = 1.0;            ///< factor
  };
  /// What pulls at it and bends it.
  struct Loads {
    Eigen::VectorXd moments;  ///< one per actuator, with the axial force that goes with each
    Eigen::VectorXd thrusts;  ///< further axial force along the span of each actuator; counts where the rod stretches
    Vec2 gravity{};           ///< per weight of the rod itself
    std::vector<Push> at{};   ///< force and moment, one for each of the rod's loads that acts at a point
    Push tip{};               ///< at its end, what hangs there included
    double line = 1.0;        ///< share of the rod's dead forces per length
  };

  /// Under `moments`, one per actuator of the rod, and the rod's own loads, until set() says otherwise. `order` in
  /// 1..LegendreBasis::maximum_order. `turn`: angle that one piece may turn by, for the number of nodes.
  LoadedRod(const Rod& rod, const std::vector<double>& moments, int order, double turn);
  ~LoadedRod();
  LoadedRod(const LoadedRod&) = delete;
  LoadedRod& operator=(const LoadedRod&) = delete;

  /// Of what all that follows is.
  void set(const Properties& properties, const Loads& loads);
  const Properties& properties() const { return properties_; }
  /// Only these, one per actuator.
  void set_moments(std::span<const double> moments);

  /// An equilibrium, and with it the start of another one.
  struct Shape {
    std::vector<NormalForce> forces;  ///< ascending in arc length
    Eigen::VectorXd coordinates;      ///< piece after piece
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

  ///@{
  /// Without normal forces, by coordinates on chain().
  const Chain& chain() const;
  int size() const { return chain().coordinate_count(); }
  /// The stable equilibrium next to `q`; false: none was found.
  bool settle(Eigen::VectorXd& q) const;
  /// The one that loads which grow from nothing lead to.
  bool load_up(Eigen::VectorXd& q);
  /// Prepares rates at an equilibrium; false: it is at its limit of stability.
  bool stand(const Eigen::VectorXd& q) const;
  /// What it is a function of: `index` is the segment or the actuator.
  enum class Number { stiffness, axial_stiffness, rest_curvature, density, moment, thrust, base_angle };
  /// Generalized forces there per unit of a number.
  Eigen::VectorXd force_by(Number number, int index) const;
  /// How the coordinates follow generalized forces (implicit function theorem).
  Eigen::VectorXd follow(const Eigen::VectorXd& force) const;
  ///@}

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
  /// The same, moved to a shape.
  Pieces& pieces(const Shape& shape) const;
  Pieces& factored(const Shape& shape) const;  ///< Likewise, ready for rates.
  Eigen::VectorXd coordinates(std::span<const NormalForce> forces, const Curvature& curvature) const;
  Shape newton(std::vector<NormalForce> forces, Eigen::VectorXd coordinates, bool stable = false) const;
  void move_apart(std::vector<NormalForce>& forces) const;
  std::vector<int> stretches(std::span<const NormalForce> forces) const;

  Rod rod_;
  LegendreBasis basis_;
  double turn_;
  std::vector<double> knots_;
  Properties properties_;
  Loads loads_;
  mutable std::map<std::vector<int>, std::unique_ptr<Pieces>> pieces_;
  mutable int solves_ = 0;
};

}  // namespace tendril
