#include "rod/backbone.hpp"

#include <algorithm>
#include <cmath>

#include "rod/kernels.hpp"
#include "rod/moving_point.hpp"

namespace tendril {

PieceSums::PieceSums(const Chain& chain, bool with_gram) : bends(chain.bends()) {
  vector.setZero(chain.functions(), chain.piece_count());
  scalar.setZero(chain.piece_count());
  gram.setZero(with_gram ? bends * (bends + 1) / 2 + bends * chain.stretches() : 0, chain.piece_count());
}

void PieceSums::set_zero() {
  vector.setZero();
  scalar.setZero();
  gram.setZero();
}

void PieceSums::add_point(int j, double weight, const double* beta) {
  double* v = vector.col(j).data();
  for (int i = 0; i < bends; ++i) v[i] += weight * beta[i];
  scalar[j] += weight;
}

void PieceSums::add_gram_point(int j, double weight, const double* beta) {
  add_point(j, weight, beta);
  double* g = gram.col(j).data();
  for (int i = 0; i < bends; ++i) {
    const double wi = weight * beta[i];
    for (int k = i; k < bends; ++k) *g++ += wi * beta[k];
  }
}

void PieceSums::add_stretch_point(int j, double weight, const double* stretch) {
  double* v = vector.col(j).data() + bends;
  for (Eigen::Index k = 0; k < vector.rows() - bends; ++k) v[k] += weight * stretch[k];
}

void PieceSums::add_mixed_point(int j, double weight, const double* beta, const double* stretch) {
  add_stretch_point(j, weight, stretch);
  double* g = gram.col(j).data() + bends * (bends + 1) / 2;
  for (int i = 0; i < bends; ++i) {
    for (Eigen::Index k = 0; k < vector.rows() - bends; ++k) *g++ += weight * beta[i] * stretch[k];
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
  if (chain.stretches() == 0) return;
  for (Eigen::MatrixXd* m : {&stretch_, &unit_cosine_, &unit_sine_}) m->setZero(nodes, pieces);
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
    if (chain_->stretches() > 0) {
      stretch_tangents(j);
      sum_c = chain_->table().weight.dot(cosine_.col(j));
      sum_s = chain_->table().weight.dot(sine_.col(j));
    }
    tangent_.chord.col(j) << sum_c, sum_s;
    tangent_.knot.col(j + 1) = tangent_.knot.col(j) + length_[j] * tangent_.chord.col(j);
  }
}

/// P' = (1 + eps) t.
void Backbone::stretch_tangents(int j) {
  const BasisTable& table = chain_->table();
  const int m = table.stretch.order;
  stretch_.col(j).setOnes();
  kernels::add_weighted_columns(table.nodes, table.nodes, m, table.stretch_by_function.data(),
                                coordinates(j) + table.bends, 1, stretch_.col(j).data());
  unit_cosine_.col(j) = cosine_.col(j);
  unit_sine_.col(j) = sine_.col(j);
  cosine_.col(j).array() *= stretch_.col(j).array();
  sine_.col(j).array() *= stretch_.col(j).array();
}

std::pair<double, double> Backbone::stretch_bounds(int j) const {
  const BasisTable& table = chain_->table();
  if (table.stretch.order == 0) return {1.0, 1.0};
  // No Legendre polynomial is larger than at the ends.
  const double* e = coordinates(j) + table.bends;
  double varies = 0.0;
  for (int k = 1; k < table.stretch.order; ++k) varies += std::abs(table.stretch.factor * e[k]);
  const double mean = 1.0 + table.stretch.factor * e[0];
  return {mean - varies, mean + varies};
}

Vec2 Backbone::knot_tangent(int j) const { return {std::cos(knot_angle_[j]), std::sin(knot_angle_[j])}; }

Backbone::Point Backbone::at(int j, double sigma) const {
  MovingPoint point(*chain_);
  point.move_to(*this, j, sigma);
  return {point.position(), point.angle(), point.curvature(), point.stretch()};
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
      for (int i = 0; i < table.bends; ++i) {
        turned_beta[i] = x * beta[i];
        turned_beta[n + i] = y * beta[i];
      }
      for (int k = 0; k < table.stretch.order; ++k) {
        turned_beta[table.bends + k] = unit_cosine_(g, j) * table.stretch_by_node(k, g);
        turned_beta[n + table.bends + k] = unit_sine_(g, j) * table.stretch_by_node(k, g);
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

void Backbone::turn(const Eigen::MatrixXd& psi, const Eigen::MatrixXd& eta, Integrals& out) const {
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
    if (table.stretch.order > 0) {
      x += (table.weight.array() * eta.col(j).array() * unit_cosine_.col(j).array()).sum();
      y += (table.weight.array() * eta.col(j).array() * unit_sine_.col(j).array()).sum();
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
    if (table.stretch.order > 0) turn_growth(j, eta, sum);
  }
}

/// sum += h int turned(eta t) beta dsigma.
void Backbone::turn_growth(int j, const Eigen::MatrixXd& eta, double* sum) const {
  const BasisTable& table = chain_->table();
  const auto add = [&](double factor, const Eigen::MatrixXd& unit, double* out) {
    node_buffer_ = factor * length_[j] * table.weight.cwiseProduct(eta.col(j)).cwiseProduct(unit.col(j));
    kernels::add_weighted_columns(table.bends, table.functions, table.nodes, table.by_node.data(), node_buffer_.data(),
                                  1, out);
  };
  add(-1.0, unit_sine_, sum);
  add(1.0, unit_cosine_, sum + table.functions);
}

void Backbone::add_nodes(PieceSums& sums, int j, const double* z) const {
  const BasisTable& table = chain_->table();
  kernels::add_weighted_columns(table.bends, table.functions, table.nodes, table.by_node.data(), z, 1,
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
  const int n = table.bends;
  double* weighted = node_buffer_.data();
  for (int i = 0; i < n; ++i) {
    const double* beta = table.by_function.col(i).data();
    for (int g = 0; g < table.nodes; ++g) weighted[g] = weights[g] * beta[g];
    kernels::add_weighted_columns(n - i, table.functions, table.nodes, table.by_node.data() + i, weighted, 1, out);
    out += n - i;
  }
}

void Backbone::add_stretch_nodes(PieceSums& sums, int j, const double* z) const {
  const BasisTable& table = chain_->table();
  const int m = table.stretch.order;
  kernels::add_weighted_columns(m, m, table.nodes, table.stretch_by_node.data(), z, 1,
                                sums.vector.col(j).data() + table.bends);
}

void Backbone::add_mixed_nodes(PieceSums& sums, int j, const double* weights) const {
  const BasisTable& table = chain_->table();
  const auto size = static_cast<int>(table.mixed.rows());
  add_stretch_nodes(sums, j, weights);
  kernels::add_weighted_columns(size, size, table.nodes, table.mixed.data(), weights, 1,
                                sums.gram.col(j).data() + table.bends * (table.bends + 1) / 2);
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
  const int bends = chain_->bends();
  const double* end = chain_->table().end.data();
  double beyond = 0.0;
  for (int j = chain_->piece_count() - 1; j >= 0; --j) {
    const double* g = sums.gram.col(j).data();
    const double* v = sums.vector.col(j).data();
    for (int i = 0; i < bends; ++i) {
      for (int k = i; k < bends; ++k) {
        const double value = *g++ + end[i] * end[k] * beyond;
        out(j * n + i, j * n + k) += value;
        if (k != i) out(j * n + k, j * n + i) += value;
      }
    }
    for (int i = 0; i < bends; ++i) {
      for (int k = bends; k < n; ++k) {
        const double value = *g++;
        out(j * n + i, j * n + k) += value;
        out(j * n + k, j * n + i) += value;
      }
    }
    // Nodes of piece j see the end values of every earlier piece.
    for (int e = 0; e < j; ++e) {
      for (int k = 0; k < n; ++k) {
        const double value = v[k] + end[k] * beyond;
        for (int i = 0; i < bends; ++i) {
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
    kernels::add_weighted_columns(table.nodes, table.nodes, table.bends, table.by_function.data(), direction + j * n, 1,
                                  out);
    for (int i = 0; i < table.bends; ++i) end += direction[j * n + i] * table.end[i];
    knot_values[j + 1] = end;
  }
}

}  // namespace tendril
