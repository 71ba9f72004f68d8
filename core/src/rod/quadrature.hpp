#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "tendril/export.hpp"

namespace tendril {

/// Legendre polynomials P_0..P_(values.size()-1) at x in [-1,1], by the three-term recurrence.
TENDRIL_API void legendre_polynomials(double x, std::span<double> values);

/// A Gauss-Legendre rule on [0,1], possibly composed of one rule per smooth interval.
class TENDRIL_API Quadrature {
 public:
  /// `nodes_per_interval` nodes on each of the intervals that the ascending `breaks` in (0,1) cut [0,1] into.
  explicit Quadrature(int nodes_per_interval, std::span<const double> breaks = {});

  /// Number of nodes.
  int size() const { return static_cast<int>(nodes_.size()); }
  /// Nodes on each smooth interval.
  int nodes_per_interval() const { return per_interval_; }
  /// Ascending in (0,1).
  const Eigen::VectorXd& nodes() const { return nodes_; }
  /// Positive, one per node; they sum to 1.
  const Eigen::VectorXd& weights() const { return weights_; }

  /// Weights a with  int_0^sigma F = sum_g a_g F(nodes_g)  for F that is a polynomial of degree below
  /// nodes_per_interval on each interval: the interpolating polynomial is integrated exactly.
  void partial_weights(double sigma, std::span<double> out) const;

 private:
  int per_interval_;
  std::vector<double> ends_;  // 0, breaks, 1
  Eigen::VectorXd nodes_, weights_;
  Eigen::MatrixXd legendre_;  // P_k at the nodes of one interval, a column per node
};

}  // namespace tendril
