#include "rod/backbone.hpp"

#include <algorithm>
#include <cmath>

#include "rod/kernels.hpp"
#include "rod/moving_point.hpp"

namespace tendril {

PieceSums::PieceSums(const Chain& chain, bool with_gram) {
  const int n = chain.functions();
  vector.setZero(n, chain.piece_count());
  scalar.setZero(chain.piece_count());
  gram.setZero(with_gram ? n * (n + 1) / 2 : 0, chain.piece_count());
}

void PieceSums::set_zero() {
  vector.setZero();
  scalar.setZero();
  gram.setZero();
}

void PieceSums::add_point(int j, double weight, const double* beta) {
  double* v = vector.col(j).data();
  for (Eigen::Index i = 0; i < vector.rows(); ++i) v[i] += weight * beta[i];
  scalar[j] += weight;
}

void PieceSums::add_gram_point(int j, double weight, const double* beta) {
  add_point(j, weight, beta);
  double* g = gram.col(j).data();
  const auto n = static_cast<int>(vector.rows());
  for (int i = 0; i < n; ++i) {
    const double wi = weight * beta[i];
    for (int k = i; k < n; ++k) *g++ += wi * beta[k];
  }
}

Integrals::Integrals(const Chain& chain) {
  knot.setZero(2, chain.piece_count() + 1);
  chord.setZero(2, chain.piece_count());
  sum.setZero(2 * chain.functions(), chain.piece_count());
}

void Integrals::row_before(int last, Vec2 value, Vec2 n, const Eigen::VectorXd& end, double* row) const {
  const auto functions = static_cast<int>(end.size());
  for (int i = 0; i < last; ++i) {
    const double arm = n.x * (knot(1, i + 1) - value.y) + n.y * (value.x - knot(0, i + 1));
    const double* x = sum.col(i).data();
    const double* y = x + functions;
    for (int k = 0; k < functions; ++k) row[i * functions + k] = n.x * x[k] + n.y * y[k] + arm * end[k];
  }
}

Backbone::Backbone(const Chain& chain, Vec2 base, double base_angle)
    : chain_(&chain), base_(base), base_angle_(base_angle), tangent_(chain) {
  const int pieces = chain.piece_count();
  const int nodes = chain.nodes();
  q_.setZero(chain.coordinate_count());
  length_.setZero(pieces);
  start_.setZero(pieces);
  knot_angle_.setZero(pieces + 1);
  angle_.setZero(nodes, pieces);
  cosine_.setZero(nodes, pieces);
  sine_.setZero(nodes, pieces);
  node_buffer_.setZero(nodes);
  turned_.setZero(2 * chain.functions() * nodes, pieces);
}

void Backbone::move(ConstVectorRef q, std::span<const double> knots) {
  q_ = q;
  const int nodes = chain_->nodes();
  const double* weight = chain_->table().weight.data();
  knot_angle_[0] = base_angle_;
  along(q_.data(), angle_, knot_angle_);
  tangent_.knot.col(0) << base_.x, base_.y;
  for (int j = 0; j < chain_->piece_count(); ++j) {
    length_[j] = chain_->length(j, knots);
    start_[j] = chain_->start(j, knots);
    const double* angle = angle_.col(j).data();
    double* c = cosine_.col(j).data();
    double* s = sine_.col(j).data();
    double sum_c = 0.0;
    double sum_s = 0.0;
    for (int g = 0; g < nodes; ++g) {
      // Both from one call: neither may be stored before the other is computed.
      const double a = angle[g];
      const double cosine = std::cos(a);
      const double sine = std::sin(a);
      c[g] = cosine;
      s[g] = sine;
      sum_c += weight[g] * cosine;
      sum_s += weight[g] * sine;
    }
    tangent_.chord.col(j) << sum_c, sum_s;
    tangent_.knot.col(j + 1) = tangent_.knot.col(j) + length_[j] * tangent_.chord.col(j);
  }
}

Vec2 Backbone::knot_tangent(int j) const { return {std::cos(knot_angle_[j]), std::sin(knot_angle_[j])}; }

Backbone::Point Backbone::at(int j, double sigma) const {
  MovingPoint point(*chain_);
  point.move_to(*this, j, sigma);
  return {point.position(), point.angle(), point.curvature()};
}

Backbone::Point Backbone::at(double s) const {
  int j = 0;
  while (j + 1 < chain_->piece_count() && s > start_[j + 1]) ++j;
  return at(j, std::clamp((s - start_[j]) / length_[j], 0.0, 1.0));
}

void Backbone::sum_normals() {
  const BasisTable& table = chain_->table();
  const int nodes = table.nodes;
  const int n = table.functions;
  for (int j = 0; j < chain_->piece_count(); ++j) {
    const double* c = cosine_.col(j).data();
    const double* s = sine_.col(j).data();
    const double* __restrict beta = table.by_node.data();
    double* __restrict turned_beta = turned_.col(j).data();
    for (int g = 0; g < nodes; ++g, beta += n, turned_beta += 2 * n) {
      const double x = -s[g];
      const double y = c[g];
      for (int i = 0; i < n; ++i) {
        turned_beta[i] = x * beta[i];
        turned_beta[n + i] = y * beta[i];
      }
    }
    double* sum = tangent_.sum.col(j).data();
    std::fill_n(sum, 2 * n, 0.0);
    kernels::add_weighted_columns(2 * n, 2 * n, nodes, turned_.col(j).data(), table.weight.data(), 1, sum);
    for (int i = 0; i < 2 * n; ++i) sum[i] *= length_[j];
  }
}

void Backbone::add_turned(int j, const double* z, int stride, double* out) const {
  const int rows = 2 * chain_->functions();
  kernels::add_weighted_columns(rows, rows, chain_->nodes(), turned_.col(j).data(), z, stride, out);
}

void Backbone::add_tangents(int j, int rows, const double* columns, double* x, double* y) const {
  kernels::add_weighted_columns(rows, rows, chain_->nodes(), columns, cosine_.col(j).data(), 1, x);
  kernels::add_weighted_columns(rows, rows, chain_->nodes(), columns, sine_.col(j).data(), 1, y);
}

void Backbone::turn(const Eigen::MatrixXd& psi, Integrals& out) const {
  const BasisTable& table = chain_->table();
  const int n = table.functions;
  out.knot.col(0).setZero();
  for (int j = 0; j < chain_->piece_count(); ++j) {
    const double* c = cosine_.col(j).data();
    const double* s = sine_.col(j).data();
    double* z = node_buffer_.data();
    double x = 0.0;
    double y = 0.0;
    for (int g = 0; g < table.nodes; ++g) {
      const double w = table.weight[g] * psi(g, j);
      x -= w * s[g];
      y += w * c[g];
      z[g] = length_[j] * w;
    }
    out.chord.col(j) << x, y;
    out.knot.col(j + 1) = out.knot.col(j) + length_[j] * out.chord.col(j);
    double* sum = out.sum.col(j).data();
    std::fill_n(sum, 2 * n, 0.0);
    add_turned(j, z, 1, sum);
    // N turned once more is -t.
    for (int i = 0; i < n; ++i) {
      const double across = sum[i];
      sum[i] = -sum[n + i];
      sum[n + i] = across;
    }
  }
}

void Backbone::add_nodes(PieceSums& sums, int j, const double* z) const {
  const BasisTable& table = chain_->table();
  kernels::add_weighted_columns(table.functions, table.functions, table.nodes, table.by_node.data(), z, 1,
                                sums.vector.col(j).data());
  double total = 0.0;
  for (int g = 0; g < table.nodes; ++g) total += z[g];
  sums.scalar[j] += total;
}

void Backbone::add_gram_nodes(PieceSums& sums, int j, const double* weights) const {
  const BasisTable& table = chain_->table();
  add_nodes(sums, j, weights);
  double* out = sums.gram.col(j).data();
  if (table.products.size() > 0) {
    const auto size = static_cast<int>(table.products.rows());
    const double* products = table.products.data();
    kernels::add_weighted_columns(size, size, table.nodes, products, weights, 1, out);
    return;
  }
  // Larger bases: row i of the packed triangle is a sum of columns weighted by W beta_i.
  const int n = table.functions;
  double* weighted = node_buffer_.data();
  for (int i = 0; i < n; ++i) {
    const double* beta = table.by_function.col(i).data();
    for (int g = 0; g < table.nodes; ++g) weighted[g] = weights[g] * beta[g];
    kernels::add_weighted_columns(n - i, n, table.nodes, table.by_node.data() + i, weighted, 1, out);
    out += n - i;
  }
}

void Backbone::spread(const PieceSums& sums, double* out) const {
  const int n = chain_->functions();
  const double* end = chain_->table().end.data();
  double beyond = 0.0;
  for (int j = chain_->piece_count() - 1; j >= 0; --j) {
    const double* v = sums.vector.col(j).data();
    for (int i = 0; i < n; ++i) out[j * n + i] += v[i] + end[i] * beyond;
    beyond += sums.scalar[j];
  }
}

void Backbone::spread_gram(const PieceSums& sums, MatrixRef out) const {
  const int n = chain_->functions();
  const double* end = chain_->table().end.data();
  double beyond = 0.0;
  for (int j = chain_->piece_count() - 1; j >= 0; --j) {
    const double* g = sums.gram.col(j).data();
    const double* v = sums.vector.col(j).data();
    for (int i = 0; i < n; ++i) {
      for (int k = i; k < n; ++k) {
        const double value = *g++ + end[i] * end[k] * beyond;
        out(j * n + i, j * n + k) += value;
        if (k != i) out(j * n + k, j * n + i) += value;
      }
    }
    // Nodes of piece j see the end values of every earlier piece.
    for (int e = 0; e < j; ++e) {
      for (int k = 0; k < n; ++k) {
        const double value = v[k] + end[k] * beyond;
        for (int i = 0; i < n; ++i) {
          if (end[i] == 0.0) continue;
          out(e * n + i, j * n + k) += end[i] * value;
          out(j * n + k, e * n + i) += end[i] * value;
        }
      }
    }
    beyond += sums.scalar[j];
  }
}

void Backbone::along(const double* direction, MatrixRef node_values, VectorRef knot_values) const {
  const BasisTable& table = chain_->table();
  const int n = table.functions;
  for (int j = 0; j < chain_->piece_count(); ++j) {
    double end = knot_values[j];
    double* out = node_values.col(j).data();
    std::fill_n(out, table.nodes, end);
    kernels::add_weighted_columns(table.nodes, table.nodes, n, table.by_function.data(), direction + j * n, 1, out);
    for (int i = 0; i < n; ++i) end += direction[j * n + i] * table.end[i];
    knot_values[j + 1] = end;
  }
}

}  // namespace tendril
