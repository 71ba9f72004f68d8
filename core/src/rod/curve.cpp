#include "rod/curve.hpp"

#include <cmath>

#include "tendril/error.hpp"

namespace tendril {

CurveTables::CurveTables(const Quadrature& rule) {
  const int n = rule.nodes_per_interval();
  const Quadrature local(n);
  // The ends of the smooth intervals show in the sums of the weights.
  ends_.push_back(0.0);
  for (int i = 0; i < rule.size() / n; ++i) ends_.push_back(ends_.back() + rule.weights().segment(i * n, n).sum());
  ends_.back() = 1.0;
  Eigen::MatrixXd p(n + 1, n);
  for (int g = 0; g < n; ++g) {
    legendre_polynomials(2.0 * local.nodes()[g] - 1.0, {p.col(g).data(), static_cast<std::size_t>(n) + 1});
  }
  transform_.resize(n, n);
  cumulative_.resize(n, n);
  for (int k = 0; k < n; ++k) {
    for (int g = 0; g < n; ++g) {
      transform_(k, g) = (2.0 * k + 1.0) * local.weights()[g] * p(k, g);
      cumulative_(g, k) = k == 0 ? 1.0 + p(1, g) : (p(k + 1, g) - p(k - 1, g)) / (2.0 * k + 1.0);
    }
  }
}

void Curve::follow(const Backbone& backbone) {
  const Chain& chain = backbone.chain();
  const int n = tables_->per_interval();
  const int intervals = tables_->intervals();
  if (chain.nodes() != n * intervals) throw Error("curve tables belong to another rule");
  pieces_ = chain.piece_count();
  lengths_.resize(static_cast<std::size_t>(pieces_));
  starts_.resize(lengths_.size());
  curvature_bounds_.resize(lengths_.size());
  stretch_bounds_.resize(lengths_.size());
  bodies_.clear();
  for (int j = 0; j < pieces_ && chain.is_thick(); ++j) bodies_.push_back(&chain.segment(j));
  interval_start_.resize(lengths_.size() * static_cast<std::size_t>(intervals));
  series_x_.resize(n, pieces_ * intervals);
  series_y_.resize(n, pieces_ * intervals);
  for (int j = 0; j < pieces_; ++j) {
    const auto piece = static_cast<std::size_t>(j);
    lengths_[piece] = backbone.length(j);
    starts_[piece] = backbone.start(j);
    double bound = 0.0;
    for (int i = 0; i < chain.bends(); ++i)
      bound += std::abs(backbone.coordinates(j)[i]) * chain.table().slope_bound[i];
    const auto [least, most] = backbone.stretch_bounds(j);
    stretch_bounds_[piece] = most;
    curvature_bounds_[piece] = bound / lengths_[piece];
    if (chain.stretches() > 0) curvature_bounds_[piece] = least > 0.0 ? curvature_bounds_[piece] / least : infinity;
    Vec2 at = backbone.knot_point(j);
    for (int i = 0; i < intervals; ++i) {
      const int column = j * intervals + i;
      const Eigen::Map<const Eigen::VectorXd> c(backbone.cosine_.col(j).data() + i * n, n);
      const Eigen::Map<const Eigen::VectorXd> s(backbone.sine_.col(j).data() + i * n, n);
      series_x_.col(column).noalias() = tables_->transform() * c;
      series_y_.col(column).noalias() = tables_->transform() * s;
      interval_start_[static_cast<std::size_t>(column)] = at;
      // The first coefficient is the mean.
      const double width = lengths_[piece] * (tables_->end(i + 1) - tables_->end(i));
      at += width * Vec2{series_x_(0, column), series_y_(0, column)};
    }
  }
}

void Curve::translate(Vec2 by) {
  for (Vec2& start : interval_start_) start += by;
}

Curve::Point Curve::at(int piece, double sigma) const {
  int interval = 0;
  while (interval + 1 < tables_->intervals() && sigma > tables_->end(interval + 1)) ++interval;
  const int column = piece * tables_->intervals() + interval;
  const double from = tables_->end(interval);
  const double to = tables_->end(interval + 1);
  const double z = 2.0 * (sigma - from) / (to - from) - 1.0;
  const double half = 0.5 * (to - from) * length(piece);
  const auto n = tables_->per_interval();
  const double* x = series_x_.col(column).data();
  const double* y = series_y_.col(column).data();
  // Sum of c_k P_k and of c_k int P_k, with int_{-1}^z P_k = (P_(k+1) - P_(k-1)) / (2k+1).
  double before = 1.0;
  double now = z;
  Vec2 tangent{x[0], y[0]};
  Vec2 offset = (z + 1.0) * tangent;
  for (int k = 1; k < n; ++k) {
    const double next = ((2.0 * k + 1.0) * z * now - k * before) / (k + 1.0);
    const double integral = (next - before) / (2.0 * k + 1.0);
    tangent.x += x[k] * now;
    tangent.y += y[k] * now;
    offset.x += x[k] * integral;
    offset.y += y[k] * integral;
    before = now;
    now = next;
  }
  return {interval_start_[static_cast<std::size_t>(column)] + half * offset, tangent};
}

Vec2 Curve::position(int piece, double sigma) const { return at(piece, sigma).position; }

}  // namespace tendril
