#include "rod/curve.hpp"

#include <cmath>

#include "tendril/error.hpp"

namespace tendril {
namespace {

/// Of a position on the unit circle: what all dropped coefficients come to.
constexpr double rounding = 4e-15;

/// Coefficients of start + scale int_{-1}^z of a series with `count` of them; one more than these. The integral of P_k
/// is (P_(k+1) - P_(k-1)) / (2k+1).
void integrate(const double* series, int count, double scale, double start, double* out) {
  const auto share = [&](int k) { return k < count ? scale * series[k] / (2.0 * k + 1.0) : 0.0; };
  out[0] = start + share(0) - share(1);
  for (int k = 1; k <= count; ++k) out[k] = share(k - 1) - share(k + 1);
}

/// How many coefficients are left if those at the end go that come to nothing.
int significant(const double* x, const double* y, int count) {
  double dropped = 0.0;
  while (count > 1) {
    dropped += std::abs(x[count - 1]) + std::abs(y[count - 1]);
    if (dropped > rounding) break;
    --count;
  }
  return count;
}

}  // namespace

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
  for (int k = 0; k <= n; ++k) {
    rise_.push_back((2.0 * k + 1.0) / (k + 1.0));
    fall_.push_back((k + 1.0) / (k + 2.0));
  }
}

double CurveTables::sum(const double* coefficients, int count, double z) const {
  double sum = 0.0;
  double above = 0.0;
  for (int k = count - 1; k >= 0; --k) {
    const auto i = static_cast<std::size_t>(k);
    const double own = coefficients[k] + rise_[i] * z * sum - fall_[i] * above;
    above = sum;
    sum = own;
  }
  return sum;
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
  series_x_.resize(n, pieces_ * intervals);
  series_y_.resize(n, pieces_ * intervals);
  place_x_.resize(n + 1, pieces_ * intervals);
  place_y_.resize(n + 1, pieces_ * intervals);
  counts_.resize(lengths_.size() * static_cast<std::size_t>(intervals));
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
      // The first coefficient is the mean.
      const double width = lengths_[piece] * (tables_->end(i + 1) - tables_->end(i));
      integrate(series_x_.col(column).data(), n, 0.5 * width, at.x, place_x_.col(column).data());
      integrate(series_y_.col(column).data(), n, 0.5 * width, at.y, place_y_.col(column).data());
      counts_[static_cast<std::size_t>(column)] =
          significant(place_x_.col(column).data(), place_y_.col(column).data(), n + 1);
      at += width * Vec2{series_x_(0, column), series_y_(0, column)};
    }
  }
}

void Curve::translate(Vec2 by) {
  place_x_.row(0).array() += by.x;
  place_y_.row(0).array() += by.y;
}

int Curve::locate(int piece, double& sigma) const {
  int interval = 0;
  while (interval + 1 < tables_->intervals() && sigma > tables_->end(interval + 1)) ++interval;
  const double from = tables_->end(interval);
  sigma = 2.0 * (sigma - from) / (tables_->end(interval + 1) - from) - 1.0;
  return piece * tables_->intervals() + interval;
}

Curve::Point Curve::at(int piece, double sigma) const {
  const Vec2 point = position(piece, sigma);
  const int column = locate(piece, sigma);
  const int count = tables_->per_interval();
  return {point,
          {tables_->sum(series_x_.col(column).data(), count, sigma),
           tables_->sum(series_y_.col(column).data(), count, sigma)}};
}

Vec2 Curve::position(int piece, double sigma) const {
  const int column = locate(piece, sigma);
  const int count = counts_[static_cast<std::size_t>(column)];
  return {tables_->sum(place_x_.col(column).data(), count, sigma),
          tables_->sum(place_y_.col(column).data(), count, sigma)};
}

}  // namespace tendril
