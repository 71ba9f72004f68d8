#pragma once

#include <Eigen/Core>
#include <span>
#include <utility>

#include "rod/chain.hpp"
#include "tendril/geometry.hpp"
#include "tendril/numbers.hpp"

namespace tendril {

/// Sums over the nodes of each piece from which every vector B^T z and every Gram product B^T diag(W) B is spread, B
/// being the constant rows of the backbone angle (model.md section 2).
struct PieceSums {
  Eigen::MatrixXd vector;  ///< functions x pieces: sum_g z_g beta(sigma_g)
  Eigen::VectorXd scalar;  ///< pieces: sum_g z_g
  /// By pieces: sum_g W_g beta_i beta_k, packed i <= k, and behind them the products of beta_i with the functions of
  /// the stretch, i by i. These have no products with each other.
  Eigen::MatrixXd gram;
  int bends;  ///< functions of the angle

  /// All sums zero, sized for `chain`; `gram` stays empty unless asked for.
  PieceSums(const Chain& chain, bool with_gram);
  void set_zero();  ///< Starts new sums.
  /// Adds weight * beta at a single point of piece j.
  void add_point(int j, double weight, const double* beta);
  /// Adds weight * beta beta^T, weight * beta and weight.
  void add_gram_point(int j, double weight, const double* beta);
  /// Adds weight * functions of the stretch; these see no piece but their own.
  void add_stretch_point(int j, double weight, const double* stretch);
  /// Adds this, and weight * beta stretch^T.
  void add_mixed_point(int j, double weight, const double* beta, const double* stretch);
};

/// A vector field along the rod, integrated from the base on: its tangent, or virtual displacements per length.
struct Integrals {
  Eigen::Matrix2Xd knot;   ///< pieces + 1: up to the start of every piece, and to the tip
  Eigen::Matrix2Xd chord;  ///< pieces: over a piece, by dsigma
  /// 2 functions x pieces: h int (derivative of the field by the coordinates) dsigma, first all x. By those of the
  /// angle it is turned(field) beta.
  Eigen::MatrixXd sum;

  explicit Integrals(const Chain& chain);  ///< All zero.
  Vec2 knot_of(int j) const { return {knot(0, j), knot(1, j)}; }
  Vec2 chord_of(int j) const { return {chord(0, j), chord(1, j)}; }
  /// n . (derivative by the coordinates of the integral up to a point where it is `value`), for pieces before `last`;
  /// `end` is beta(1). A piece turns all behind it:  sum_i + turned(value - knot_(i+1)) beta(1)^T.
  void row_before(int last, Vec2 value, Vec2 n, const Eigen::VectorXd& end, double* row) const;
};

/// The shape of a chain at given coordinates: angles, positions and their derivatives. Every sine and cosine is
/// computed once per move(). Nothing allocates after construction.
class TENDRIL_API Backbone {
 public:
  /// A rod clamped at `base` (units of L) with angle `base_angle` (rad) there. `chain` is borrowed and must outlive
  /// this.
  Backbone(const Chain& chain, Vec2 base, double base_angle);

  /// The chain that it was made of.
  const Chain& chain() const { return *chain_; }

  /// Where the next move() begins.
  void place(Vec2 base, double angle) {
    base_ = base;
    base_angle_ = angle;
  }
  /// Where the rod begins.
  Vec2 base() const { return base_; }

  /// Moves to coordinates q (chain.coordinate_count()) and moving knots (chain.knot_count()).
  void move(ConstVectorRef q, std::span<const double> knots);

  /// Length of piece j, units of L.
  double length(int j) const { return length_[j]; }
  /// Arc length at which piece j begins, units of L.
  double start(int j) const { return start_[j]; }
  /// Angle and position at the start of piece j; j = piece_count(): the tip.
  double knot_angle(int j) const { return knot_angle_[j]; }
  /// Position at the start of piece j; j = piece_count(): the tip.
  Vec2 knot_point(int j) const { return tangent_.knot_of(j); }
  /// Unit tangent there.
  Vec2 knot_tangent(int j) const;
  /// Position of the tip, units of L.
  Vec2 tip() const { return knot_point(chain_->piece_count()); }
  /// Angle of the tip, rad.
  double tip_angle() const { return knot_angle_[chain_->piece_count()]; }
  /// int_0^1 P' dsigma over piece j, P' = (1 + eps) t by the arc length.
  Vec2 chord(int j) const { return tangent_.chord_of(j); }
  /// P' at node g of piece j: the unit tangent, where the rod does not stretch.
  Vec2 tangent(int j, int g) const { return {cosine_(g, j), sine_(g, j)}; }
  /// The unit tangent there, of a rod that stretches.
  Vec2 unit_tangent(int j, int g) const { return {unit_cosine_(g, j), unit_sine_(g, j)}; }
  /// 1 + eps there.
  double stretch(int j, int g) const { return stretch_(g, j); }
  /// Bounds of 1 + eps over piece j.
  std::pair<double, double> stretch_bounds(int j) const;
  /// Coordinates of piece j: chain().functions() entries.
  const double* coordinates(int j) const { return q_.data() + j * chain_->functions(); }

  /// Shape at any arc length, for reports and certificates (slow: evaluates the basis, allocates).
  struct Point {
    Vec2 position{};         ///< units of L
    double angle = 0.0;      ///< rad
    double curvature = 0.0;  ///< times L, by the arc length of the rod that is not stretched
    double stretch = 1.0;    ///< 1 + eps
  };
  Point at(double s) const;  ///< The point at arc length s in [0,1].
  /// The same at sigma of piece j.
  Point at(int j, double sigma) const;

  /// Computes h_j int N beta dsigma for every piece (needed by rows).
  void sum_normals();
  /// The tangent's integrals.
  const Integrals& integrals() const { return tangent_; }
  /// n . dP/dq of a point P in piece j, pieces i < j only (the own block is the caller's); needs sum_normals().
  void row_before(int j, Vec2 point, Vec2 n, double* row) const {
    tangent_.row_before(j, point, n, chain_->table().end, row);
  }
  /// out[0..2n) += sum_g z[g * stride] (derivatives of P' by the coordinates)_g over the nodes of piece j, N beta by
  /// those of the angle; needs sum_normals().
  void add_turned(int j, const double* z, int stride, double* out) const;
  /// x and y [0..rows) += sum_g columns(:, g) t_g over the nodes of piece j.
  void add_tangents(int j, int rows, const double* columns, double* x, double* y) const;
  /// The integrals of what a rotation psi makes of P', and, of a rod that stretches, a growth eta along t: at the nodes
  /// (nodes x pieces); needs sum_normals().
  void turn(const Eigen::MatrixXd& psi, const Eigen::MatrixXd& eta, Integrals& out) const;

  /// sums.vector.col(j) += sum_g z_g beta_g and sums.scalar[j] += sum_g z_g over the nodes of piece j.
  void add_nodes(PieceSums& sums, int j, const double* z) const;
  /// The same with the Gram product of z as weights.
  void add_gram_nodes(PieceSums& sums, int j, const double* weights) const;
  /// Likewise of the functions of the stretch, and of their products with those of the angle.
  void add_stretch_nodes(PieceSums& sums, int j, const double* z) const;
  void add_mixed_nodes(PieceSums& sums, int j, const double* weights) const;

  /// out += B^T z from the sums: out_j += vector_j + beta(1) sum_{i > j} scalar_i.
  void spread(const PieceSums& sums, double* out) const;
  /// out(0..n, 0..n) += B^T diag(W) B, both triangles.
  void spread_gram(const PieceSums& sums, MatrixRef out) const;

  /// Node values psi = B direction (nodes x pieces) and psi at the start of every piece (pieces + 1), the first of
  /// which is given.
  void along(const double* direction, MatrixRef node_values, VectorRef knot_values) const;

 private:
  void stretch_tangents(int j);
  void turn_growth(int j, const Eigen::MatrixXd& eta, double* sum) const;

  friend class Curve;
  friend class Places;
  const Chain* chain_;
  Vec2 base_;
  double base_angle_;
  Eigen::VectorXd q_;
  Eigen::VectorXd length_, start_;
  Eigen::VectorXd knot_angle_;
  Integrals tangent_;
  Eigen::MatrixXd angle_, cosine_, sine_;              // nodes x pieces; the latter times 1 + eps
  Eigen::MatrixXd stretch_, unit_cosine_, unit_sine_;  // nodes x pieces, of a rod that stretches
  Eigen::MatrixXd turned_;  // (2 functions x nodes) x pieces: derivatives of P' by the coordinates at every node
  mutable Eigen::VectorXd node_buffer_;  // nodes
};

}  // namespace tendril
