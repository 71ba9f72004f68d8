#include "rod/curve.hpp"

#include <cmath>

#include "rod/kernels.hpp"
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

template <class Coefficient>
auto CurveTables::recur(double z, int count, const Coefficient& coefficient) const {
  decltype(coefficient(0)) sum{}, above{};
  for (int k = count - 1; k >= 0; --k) {
    const auto i = static_cast<std::size_t>(k);
    // What waits for the sum before is one product: the chain of these is what a point costs.
    const auto rest = coefficient(k) - fall_[i] * above;
    above = sum;
    sum = rise_[i] * z * sum + rest;
  }
  return sum;
}

double CurveTables::sum(const double* coefficients, int count, double z) const {
  return recur(z, count, [&](int k) { return coefficients[k]; });
}

Vec2 CurveTables::sum(const double* x, const double* y, int count, double z) const {
  return recur(z, count, [&](int k) { return Vec2{x[k], y[k]}; });
}

CurveSamples::CurveSamples(const CurveTables& tables, int steps)
    : steps_(steps), values_(static_cast<std::size_t>(tables.intervals())) {
  const int most = tables.per_interval() + 1;
  Eigen::VectorXd column(most);
  int from = 0;
  for (int i = 0; i < tables.intervals(); ++i) {
    int to = from;
    while (to <= steps && (i + 1 == tables.intervals() || sigma(to) <= tables.end(i + 1))) ++to;
    Eigen::MatrixXd& values = values_[static_cast<std::size_t>(i)];
    values.resize(to - from, most);
    for (int k = from; k < to; ++k) {
      const double z = 2.0 * (sigma(k) - tables.end(i)) / (tables.end(i + 1) - tables.end(i)) - 1.0;
      legendre_polynomials(z, {column.data(), static_cast<std::size_t>(most)});
      values.row(k - from) = column.transpose();
    }
    from = to;
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
      const auto transform = [&](const Eigen::MatrixXd& tangent, Eigen::MatrixXd& series) {
        series.col(column).setZero();
        kernels::add_weighted_columns(n, n, n, tables_->transform().data(), tangent.col(j).data() + i * n, 1,
                                      series.col(column).data());
      };
      transform(backbone.cosine_, series_x_);
      transform(backbone.sine_, series_y_);
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
  return {point,
          tables_->sum(series_x_.col(column).data(), series_y_.col(column).data(), tables_->per_interval(), sigma)};
}

Vec2 Curve::position(int piece, double sigma) const {
  const int column = locate(piece, sigma);
  return tables_->sum(place_x_.col(column).data(), place_y_.col(column).data(),
                      counts_[static_cast<std::size_t>(column)], sigma);
}

void Curve::positions(int piece, const CurveSamples& samples, VectorRef x, VectorRef y) const {
  x.setZero();
  y.setZero();
  Eigen::Index from = 0;
  for (int i = 0; i < tables_->intervals(); ++i) {
    const Eigen::MatrixXd& values = samples.values(i);
    const auto own = static_cast<int>(values.rows());
    const int column = piece * tables_->intervals() + i;
    const int count = counts_[static_cast<std::size_t>(column)];
    kernels::add_weighted_columns(own, own, count, values.data(), place_x_.col(column).data(), 1, x.data() + from);
    kernels::add_weighted_columns(own, own, count, values.data(), place_y_.col(column).data(), 1, y.data() + from);
    from += own;
  }
}

}  // namespace tendril
