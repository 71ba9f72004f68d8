#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "rod/backbone.hpp"
#include "tendril/numbers.hpp"

namespace tendril {

/// Legendre tables of a chain's rule with which a piece is evaluated anywhere in tens of flops: the tangent's expansion
/// is integrated term by term.
class TENDRIL_API CurveTables {
 public:
  explicit CurveTables(const Quadrature& rule);  ///< For curves of chains with this rule.
  /// Coefficients of a series: the nodes of one interval.
  int per_interval() const { return static_cast<int>(transform_.rows()); }
  /// Smooth intervals of a piece.
  int intervals() const { return static_cast<int>(ends_.size()) - 1; }
  /// Where interval i begins on [0,1]; i = intervals(): 1.
  double end(int i) const { return ends_[static_cast<std::size_t>(i)]; }
  /// Coefficients = transform * values at the nodes of one interval.
  const Eigen::MatrixXd& transform() const { return transform_; }
  /// int over the interval from its start to each node, in units of half its width: cumulative * coefficients.
  const Eigen::MatrixXd& cumulative() const { return cumulative_; }

  /// Sum of coefficients[k] P_k(z) over k < count, which is at most per_interval() + 1.
  double sum(const double* coefficients, int count, double z) const;
  /// Two such sums.
  Vec2 sum(const double* x, const double* y, int count, double z) const;

 private:
  /// Clenshaw's recurrence for coefficient(k), k < count.
  template <class Coefficient>
  auto recur(double z, int count, const Coefficient& coefficient) const;

  std::vector<double> ends_;
  std::vector<double> rise_, fall_;  ///< of the recurrence that sums (Clenshaw)
  Eigen::MatrixXd transform_, cumulative_;
};

/// Legendre polynomials at evenly spaced places of a piece, with which the positions there are one product.
class TENDRIL_API CurveSamples {
 public:
  /// Of no place.
  CurveSamples() = default;
  /// Places sigma = 0, 1/steps, .., 1 of the pieces of curves with these tables.
  CurveSamples(const CurveTables& tables, int steps);
  /// Of these places, the first one not counted.
  int steps() const { return steps_; }
  /// Whether they are of curves with these tables, or others of as many nodes.
  bool fit(const CurveTables& tables) const {
    return !values_.empty() && values_.size() == static_cast<std::size_t>(tables.intervals()) &&
           values_.front().cols() == tables.per_interval() + 1;
  }
  /// Place k in [0,1].
  double sigma(int k) const { return static_cast<double>(k) / steps_; }
  /// Of the places in smooth interval i: a row per place, a column per polynomial.
  const Eigen::MatrixXd& values(int i) const { return values_[static_cast<std::size_t>(i)]; }

 private:
  int steps_ = 0;
  std::vector<Eigen::MatrixXd> values_;
};

/// The curve of a moved backbone as a series per smooth interval of each piece.
class TENDRIL_API Curve {
 public:
  /// Holds nothing before follow().
  explicit Curve(std::shared_ptr<const CurveTables> tables) : tables_(std::move(tables)) {}
  /// Becomes the curve of a moved backbone whose chain has these tables; it has to outlive what is asked of a body.
  void follow(const Backbone& backbone);
  /// Shifts every point.
  void translate(Vec2 by);

  /// A point of the curve and the unit tangent there.
  struct Point {
    Vec2 position{};  ///< units of L
    Vec2 tangent{};   ///< P' by the arc length: a unit vector, where the rod does not stretch
  };
  Point at(int piece, double sigma) const;       ///< Point at sigma in [0,1] of a piece.
  Vec2 position(int piece, double sigma) const;  ///< Its position alone.
  /// Positions at all places of `samples` on a piece, into vectors of that size.
  void positions(int piece, const CurveSamples& samples, VectorRef x, VectorRef y) const;
  /// Pieces of the backbone followed last.
  int piece_count() const { return pieces_; }
  /// Length of a piece, units of L.
  double length(int piece) const { return lengths_[static_cast<std::size_t>(piece)]; }
  /// Arc length at which a piece begins, units of L.
  double start(int piece) const { return starts_[static_cast<std::size_t>(piece)]; }
  /// Radius of the body there.
  double radius(int piece, double sigma) const {
    return bodies_.empty()
               ? 0.0
               : bodies_[static_cast<std::size_t>(piece)]->radius_at(start(piece) + sigma * length(piece)).value;
  }
  /// Bounds of its derivatives over a piece.
  Rod::Jet radius_bounds(int piece) const {
    return bodies_.empty() ? Rod::Jet{} : bodies_[static_cast<std::size_t>(piece)]->radius_bounds();
  }
  /// Becomes the backbone alone.
  void strip() { bodies_.clear(); }
  /// No part of a piece is longer than that for each unit of its arc length.
  double stretch_bound(int piece) const { return stretch_bounds_[static_cast<std::size_t>(piece)]; }
  /// No piece is longer than that, units of L.
  double arc_bound(int piece) const { return length(piece) * stretch_bound(piece); }
  /// max of the curve's |curvature| over a piece, from the sizes of its coordinates.
  double curvature_bound(int piece) const { return curvature_bounds_[static_cast<std::size_t>(piece)]; }

 private:
  /// The column of a place, which becomes the place in its interval, in [-1,1].
  int locate(int piece, double& sigma) const;

  std::shared_ptr<const CurveTables> tables_;
  int pieces_ = 0;
  std::vector<double> lengths_, starts_, curvature_bounds_, stretch_bounds_;
  std::vector<const Rod::Segment*> bodies_;  // of the pieces' chain, borrowed; empty: there is none
  Eigen::MatrixXd series_x_, series_y_;      // of the tangent, a column per piece and interval
  Eigen::MatrixXd place_x_, place_y_;        // of the position
  std::vector<int> counts_;                  // coefficients of a column that are more than rounding
};

}  // namespace tendril
