#include "rod/quadrature.hpp"

#include <cmath>
#include <numbers>

#include "tendril/error.hpp"

namespace tendril {
namespace {

/// Nodes and weights of the n-point Gauss-Legendre rule on [-1,1], by Newton from the asymptotic roots.
void gauss_legendre(int n, Eigen::VectorXd& x, Eigen::VectorXd& w) {
  x.resize(n);
  w.resize(n);
  for (int i = 0; 2 * i < n; ++i) {
    double z = std::cos(std::numbers::pi * (i + 0.75) / (n + 0.5));
    double derivative = 1.0;
    for (int iteration = 0; iteration < 12; ++iteration) {
      double previous = 1.0;
      double current = z;
      for (int k = 2; k <= n; ++k) {
        const double next = ((2.0 * k - 1.0) * z * current - (k - 1.0) * previous) / k;
        previous = current;
        current = next;
      }
      derivative = n * (z * current - previous) / (z * z - 1.0);
      const double step = current / derivative;
      z -= step;
      // The weight needs the slope at the root itself: go on until the root does not move any more.
      if (std::abs(step) < 1e-15) break;
    }
    if (2 * i + 1 == n) z = 0.0;
    // Roots come in descending order and in pairs; rules are used in ascending order.
    x[n - 1 - i] = z;
    x[i] = -z;
    w[n - 1 - i] = w[i] = 2.0 / ((1.0 - z * z) * derivative * derivative);
  }
}

}  // namespace

void legendre_polynomials(double x, std::span<double> values) {
  if (!values.empty()) values[0] = 1.0;
  if (values.size() > 1) values[1] = x;
  for (std::size_t k = 2; k < values.size(); ++k) {
    const auto order = static_cast<double>(k);
    values[k] = ((2.0 * order - 1.0) * x * values[k - 1] - (order - 1.0) * values[k - 2]) / order;
  }
}

Quadrature::Quadrature(int nodes_per_interval, std::span<const double> breaks) : per_interval_(nodes_per_interval) {
  if (nodes_per_interval < 1) throw Error("a quadrature rule needs at least one node");
  ends_.push_back(0.0);
  for (const double b : breaks) {
    if (!(b > ends_.back() && b < 1.0)) throw Error("breaks of a coordinate model must ascend inside (0,1)");
    ends_.push_back(b);
  }
  ends_.push_back(1.0);
  Eigen::VectorXd x;
  Eigen::VectorXd w;
  gauss_legendre(per_interval_, x, w);
  legendre_.resize(per_interval_, per_interval_);
  for (int g = 0; g < per_interval_; ++g) {
    legendre_polynomials(x[g], {legendre_.col(g).data(), static_cast<std::size_t>(per_interval_)});
  }
  const auto intervals = static_cast<int>(ends_.size()) - 1;
  nodes_.resize(intervals * per_interval_);
  weights_.resize(nodes_.size());
  for (int i = 0; i < intervals; ++i) {
    const double from = ends_[static_cast<std::size_t>(i)];
    const double length = ends_[static_cast<std::size_t>(i) + 1] - from;
    nodes_.segment(i * per_interval_, per_interval_) = (from + 0.5 * length * (1.0 + x.array())).matrix();
    weights_.segment(i * per_interval_, per_interval_) = 0.5 * length * w;
  }
}

void Quadrature::partial_weights(double sigma, std::span<double> out) const {
  const int n = per_interval_;
  std::vector<double> at_end(static_cast<std::size_t>(n) + 1);
  Eigen::VectorXd integrals(n);
  for (int i = 0; i + 1 < static_cast<int>(ends_.size()); ++i) {
    const double from = ends_[static_cast<std::size_t>(i)];
    const double to = ends_[static_cast<std::size_t>(i) + 1];
    Eigen::Map<Eigen::VectorXd> weights(out.data() + i * n, n);
    if (sigma >= to) {
      weights = weights_.segment(i * n, n);
    } else if (sigma <= from) {
      weights.setZero();
    } else {
      // Expand in Legendre polynomials on the interval; int_0^z P_k = (P_(k+1) - P_(k-1)) / (2 (2k+1)).
      const double z = 2.0 * (sigma - from) / (to - from) - 1.0;
      legendre_polynomials(z, at_end);
      integrals[0] = 0.5 * (z + 1.0);
      for (int k = 1; k < n; ++k) {
        const auto above = static_cast<std::size_t>(k) + 1;
        integrals[k] = 0.5 * (at_end[above] - at_end[above - 2]);
      }
      weights.noalias() = weights_.segment(i * n, n).cwiseProduct(legendre_.transpose() * integrals);
    }
  }
}

}  // namespace tendril
