#pragma once

#include <Eigen/Core>
#include <vector>

#include "rod/backbone.hpp"

namespace tendril {

/// A backbone point inside a piece whose sigma may change: a contact of an unsplit rod, or a sample at a fixed arc
/// length while knots move. It integrates up to its own sigma with nodes of its own. Nothing allocates after
/// construction.
class MovingPoint {
 public:
  explicit MovingPoint(const Chain& chain);

  /// Evaluates the point at arc length s in piece j.
  void move(const Backbone& backbone, int j, double s);
  void move_to(const Backbone& backbone, int j, double sigma);  ///< The same at sigma of the piece.

  int piece() const { return piece_; }
  double sigma() const { return sigma_; }
  Vec2 position() const { return position_; }
  Vec2 chord() const { return chord_; }  ///< int_0^sigma P' dsigma, P' by the arc length
  double angle() const { return angle_; }
  double curvature() const { return slope_ / length_; }
  Vec2 tangent() const { return tangent_; }                ///< unit vector
  Vec2 velocity() const { return stretch_ * tangent_; }    ///< P' by the arc length
  double stretch() const { return stretch_; }              ///< 1 + eps
  double stretch_slope() const { return stretch_slope_; }  ///< deps/dsigma
  const double* stretch_functions() const { return by_stretch_.col(node_count_).data(); }
  const double* stretch_function_slopes() const { return stretch_slopes_.data(); }
  Vec2 normal() const { return turned(velocity()); }  ///< P' turned
  double slope() const { return slope_; }             ///< dphi/dsigma
  double bend() const { return bend_; }               ///< d^2 phi/dsigma^2
  const double* beta() const { return beta_.data(); }
  const double* beta1() const { return beta1_.data(); }
  const double* beta2() const { return beta2_.data(); }

  /// Fills third[i] = beta_i'''(sigma): the derivative of the interpolating polynomial of beta_i'' on its smooth
  /// interval, which is exact for polynomial bases and as accurate as the quadrature for others. Only a curvature read
  /// at a moving sigma needs it.
  void third_derivative(double* third) const;

  int node_count() const { return node_count_; }
  double weight(int g) const { return weight_[g]; }  ///< of dsigma
  double node_sigma(int g) const { return sigma_nodes_[g]; }
  Vec2 node_tangent(int g) const { return {cosine_[g], sine_[g]}; }         ///< P'
  Vec2 node_unit(int g) const { return {unit_cosine_[g], unit_sine_[g]}; }  ///< of a rod that stretches
  const double* node_stretch(int g) const { return by_stretch_.col(g).data(); }
  const double* node_beta(int g) const { return by_node_.col(g).data(); }

  /// n . dP/dq of the own piece, h int_0^sigma N beta dsigma . n, or the same of the virtual displacement:
  /// functions() entries.
  void own_row(Vec2 n, bool displaced, double* row) const;

  /// Virtual rotation and growth along coordinates `lambda` of the own piece, from `psi` at its start on.
  void displace(const double* lambda, double psi);
  double psi() const { return psi_[node_count_]; }  ///< at the point
  double psi_slope() const { return psi_slope_; }   ///< dpsi/dsigma there
  double node_psi(int g) const { return psi_[g]; }
  double node_eta(int g) const { return eta_[g]; }  ///< likewise, growth along the tangent
  double eta() const { return eta_[node_count_]; }
  double eta_slope() const { return eta_slope_; }
  Vec2 virtual_chord() const { return virtual_chord_; }  ///< int_0^sigma (what these make of P') dsigma

 private:
  double find_stretch(int g, const double* e);
  void grow(const double* lambda);

  const Chain* chain_;
  std::vector<double> breaks_;
  int piece_ = 0;
  double sigma_ = 0.0, length_ = 1.0;
  Vec2 position_{}, chord_{}, tangent_{};
  double angle_ = 0.0, slope_ = 0.0, bend_ = 0.0, psi_slope_ = 0.0;
  double stretch_ = 1.0, stretch_slope_ = 0.0, eta_slope_ = 0.0;
  Vec2 virtual_chord_{};
  Eigen::VectorXd local_nodes_, local_weights_;
  Eigen::VectorXd beta_, beta1_, beta2_;
  int node_count_ = 0;
  Eigen::VectorXd weight_, sigma_nodes_, cosine_, sine_, psi_;
  Eigen::MatrixXd value_, first_, second_, by_node_;
  Eigen::VectorXd unit_cosine_, unit_sine_, eta_, stretch_slopes_;  // of a rod that stretches
  Eigen::MatrixXd by_stretch_;                                      // its functions x nodes and the point
};

}  // namespace tendril
