#include "rod/backbone.hpp"

#include <algorithm>
#include <cmath>

#include "rod/kernels.hpp"

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

Backbone::Backbone(const Chain& chain, Vec2 base, double base_angle)
    : chain_(&chain), base_(base), base_angle_(base_angle) {
  const int pieces = chain.piece_count();
  const int nodes = chain.nodes();
  q_.setZero(chain.coordinate_count());
  length_.setZero(pieces);
  start_.setZero(pieces);
  knot_angle_.setZero(pieces + 1);
  knot_x_.setZero(pieces + 1);
  knot_y_.setZero(pieces + 1);
  chord_x_.setZero(pieces);
  chord_y_.setZero(pieces);
  angle_.setZero(nodes, pieces);
  cosine_.setZero(nodes, pieces);
  sine_.setZero(nodes, pieces);
  normal_.setZero(2 * chain.functions(), pieces);
  gram_buffer_.setZero(nodes);
  turned_.setZero(2 * chain.functions() * nodes, pieces);
}

void Backbone::move(ConstVectorRef q, std::span<const double> knots) {
  q_ = q;
  const BasisTable& table = chain_->table();
  const int pieces = chain_->piece_count();
  const int nodes = table.nodes;
  const int n = table.functions;
  const double* weight = table.weight.data();
  knot_angle_[0] = base_angle_;
  knot_x_[0] = base_.x;
  knot_y_[0] = base_.y;
  for (int j = 0; j < pieces; ++j) {
    length_[j] = chain_->length(j, knots);
    start_[j] = chain_->start(j, knots);
    const double* qj = q_.data() + j * n;
    double* angle = angle_.col(j).data();
    double end = knot_angle_[j];
    std::fill_n(angle, nodes, end);
    for (int i = 0; i < n; ++i) {
      const double* beta = table.by_function.col(i).data();
      const double qi = qj[i];
      for (int g = 0; g < nodes; ++g) angle[g] += qi * beta[g];
      end += qi * table.end[i];
    }
    knot_angle_[j + 1] = end;
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
    chord_x_[j] = sum_c;
    chord_y_[j] = sum_s;
    knot_x_[j + 1] = knot_x_[j] + length_[j] * sum_c;
    knot_y_[j + 1] = knot_y_[j] + length_[j] * sum_s;
  }
}

Backbone::Point Backbone::at(int j, double sigma) const {
  const int n = chain_->functions();
  std::vector<double> breaks{0.0};
  for (const double b : chain_->model().breaks()) {
    if (b < sigma) breaks.push_back(b);
  }
  breaks.push_back(sigma);
  const Quadrature local(chain_->rule().nodes_per_interval());
  const Eigen::Map<const Eigen::VectorXd> q(coordinates(j), n);
  const int m = local.size();
  Eigen::MatrixXd value(m, n);
  Eigen::MatrixXd first(m, n);
  Eigen::MatrixXd second(m, n);
  Point p;
  p.position = knot_point(j);
  for (std::size_t b = 0; b + 1 < breaks.size(); ++b) {
    const double width = breaks[b + 1] - breaks[b];
    const Eigen::VectorXd nodes = (breaks[b] + width * local.nodes().array()).matrix();
    chain_->model().evaluate({nodes.data(), static_cast<std::size_t>(m)}, value, first, second);
    const Eigen::ArrayXd angle = (value * q).array() + knot_angle_[j];
    p.position.x += length_[j] * width * (local.weights().array() * angle.cos()).sum();
    p.position.y += length_[j] * width * (local.weights().array() * angle.sin()).sum();
  }
  const double at_sigma[1] = {sigma};
  chain_->model().evaluate(at_sigma, value.topRows(1), first.topRows(1), second.topRows(1));
  p.angle = knot_angle_[j] + value.row(0).dot(q);
  p.curvature = first.row(0).dot(q) / length_[j];
  return p;
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
    const double* c = cosines(j);
    const double* s = sines(j);
    const double* beta = table.by_node.data();
    double* turned_beta = turned_.col(j).data();
    for (int g = 0; g < nodes; ++g, beta += n, turned_beta += 2 * n) {
      const double x = -s[g];
      const double y = c[g];
      for (int i = 0; i < n; ++i) turned_beta[i] = x * beta[i];
      for (int i = 0; i < n; ++i) turned_beta[n + i] = y * beta[i];
    }
    double* sum = normal_.col(j).data();
    std::fill_n(sum, 2 * n, 0.0);
    kernels::add_weighted_columns(2 * n, 2 * n, nodes, turned_.col(j).data(), table.weight.data(), 1, sum);
    for (int i = 0; i < 2 * n; ++i) sum[i] *= length_[j];
  }
}

void Backbone::add_turned(int j, const double* z, int stride, double* out) const {
  const int rows = 2 * chain_->functions();
  kernels::add_weighted_columns(rows, rows, chain_->nodes(), turned_.col(j).data(), z, stride, out);
}

void Backbone::point_rows(int j, double* row_x, double* row_y) const {
  const int n = chain_->functions();
  const double* end = chain_->table().end.data();
  const double px = knot_x_[j + 1];
  const double py = knot_y_[j + 1];
  for (int i = 0; i <= j; ++i) {
    const double turned_x = knot_y_[i + 1] - py;
    const double turned_y = px - knot_x_[i + 1];
    const double* sx = normal_sum_x(i);
    const double* sy = normal_sum_y(i);
    for (int k = 0; k < n; ++k) {
      row_x[i * n + k] = sx[k] + turned_x * end[k];
      row_y[i * n + k] = sy[k] + turned_y * end[k];
    }
  }
}

void Backbone::row_before(int j, Vec2 point, Vec2 n, double* row) const {
  const int functions = chain_->functions();
  const double* end = chain_->table().end.data();
  for (int i = 0; i < j; ++i) {
    const double arm = n.x * (knot_y_[i + 1] - point.y) + n.y * (point.x - knot_x_[i + 1]);
    const double* sx = normal_sum_x(i);
    const double* sy = normal_sum_y(i);
    for (int k = 0; k < functions; ++k) row[i * functions + k] = n.x * sx[k] + n.y * sy[k] + arm * end[k];
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
  double* weighted = gram_buffer_.data();
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
  knot_values[0] = 0.0;
  for (int j = 0; j < chain_->piece_count(); ++j) {
    double end = knot_values[j];
    double* out = node_values.col(j).data();
    std::fill_n(out, table.nodes, end);
    for (int i = 0; i < n; ++i) {
      const double d = direction[j * n + i];
      const double* beta = table.by_function.col(i).data();
      for (int g = 0; g < table.nodes; ++g) out[g] += d * beta[g];
      end += d * table.end[i];
    }
    knot_values[j + 1] = end;
  }
}

}  // namespace tendril
