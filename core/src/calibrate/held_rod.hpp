#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <vector>

#include "rod/chain.hpp"
#include "rod/places.hpp"
#include "rod/rod.hpp"
#include "tendril/coordinate_model.hpp"

namespace tendril {

/// A rod that touches nothing, in equilibrium under known loads (model.md section 3), as a function of the numbers that
/// a calibration looks for. Its base is the origin. Integrated Legendre functions of one order on every piece.
/// Everything dimensionless, in units of the rod that it is made of.
class TENDRIL_API HeldRod {
 public:
  /// Factors on the rod's properties, and what is added to them.
  struct Properties {
    Eigen::VectorXd stiffness;       ///< factor, one per segment
    Eigen::VectorXd rest_curvature;  ///< added, one per segment
    double density = 1.0;            ///< factor
  };
  /// What pulls at it and bends it.
  struct Loads {
    Eigen::VectorXd moments;  ///< one per actuator
    Vec2 gravity{};           ///< per weight of the rod itself
    std::vector<Push> at{};   ///< force and moment, one for each of the rod's loads that acts at a point
    Push tip{};               ///< at its end, what hangs there included
    double line = 1.0;        ///< share of the rod's dead forces per length
  };

  /// Point loads of `rod` only say where forces act, not which.
  HeldRod(const Rod& rod, int order, double turn);
  HeldRod(const HeldRod&) = delete;
  HeldRod& operator=(const HeldRod&) = delete;

  int size() const { return chain_.coordinate_count(); }
  int segments() const { return static_cast<int>(rest_.cols()); }
  const Chain& chain() const { return chain_; }

  /// The stable equilibrium next to `q`, by Newton's method; false: none was found.
  bool solve(const Properties& properties, const Loads& loads, Eigen::VectorXd& q);
  /// The one that loads which grow from nothing lead to.
  bool load_up(const Properties& properties, const Loads& loads, Eigen::VectorXd& q);

  /// Prepares rates at an equilibrium; false: it is at its limit of stability.
  bool stand(const Properties& properties, const Loads& loads, const Eigen::VectorXd& q);
  ///@{
  /// Generalized forces there, each per unit of what it is named after.
  Eigen::VectorXd by_stiffness(int segment) const;
  Eigen::VectorXd by_rest_curvature(int segment) const;
  Eigen::VectorXd by_density();
  Eigen::VectorXd by_moment(int actuator) const { return moment_.col(actuator); }
  Eigen::VectorXd by_base_angle();
  ///@}
  /// How the coordinates follow generalized forces (implicit function theorem).
  Eigen::VectorXd follow(const Eigen::VectorXd& force) const { return factors_.solve(force); }

 private:
  /// The energy's part of the forces of one segment's pieces.
  void add_bending(const Properties& properties, const Eigen::VectorXd& q, int segment, double factor,
                   Eigen::VectorXd& out) const;
  void move(const Properties& properties, const Loads& loads, const Eigen::VectorXd& q);
  const Eigen::VectorXd& residual(const Properties& properties, const Loads& loads, const Eigen::VectorXd& q);
  bool factor(const Properties& properties);
  Eigen::VectorXd unloaded(const Properties& properties) const;

  LegendreBasis basis_;
  Chain chain_;
  Places places_;
  std::vector<int> load_place_;  ///< of each point load; -1: it acts on the base
  int tip_ = 0;
  Eigen::MatrixXd stiffness_;  ///< K of the bending energy, at factors of 1
  Eigen::VectorXd bent_;       ///< its forces where the coordinates are 0
  Eigen::MatrixXd rest_;       ///< forces per rest curvature, a column per segment
  Eigen::MatrixXd moment_;     ///< forces per moment, a column per actuator
  Forces forces_;
  Properties properties_;
  Eigen::VectorXd q_, residual_;
  Eigen::MatrixXd hessian_;
  Eigen::LLT<Eigen::MatrixXd> factors_;
};

}  // namespace tendril
