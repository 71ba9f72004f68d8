// The bending energy (model.md section 3) and its derivatives. Where a section varies along a piece they are sums over
// its nodes of h/2 EI(s) e^2, e = phi'/h - kappa0(s): moving knots change h and s.

#include "rod/places.hpp"

namespace tendril {

double Places::energy() const {
  const int n = chain_->functions();
  double energy = 0.0;
  for (int j = 0; j < chain_->piece_count(); ++j) {
    const Chain::Piece& p = chain_->piece(j);
    if (!p.bends_evenly) {
      energy += varying_energy(j);
      continue;
    }
    const Eigen::Map<const Eigen::VectorXd> q(backbone_.coordinates(j), n);
    const double bend = q.dot(stiff_.segment(j * n, n));
    energy += p.stiffness * (0.5 * bend / backbone_.length(j) - p.rest_curvature * q.dot(chain_->table().end) +
                             0.5 * p.rest_curvature * p.rest_curvature * backbone_.length(j));
  }
  if (chain_->stretches() > 0) energy += stretch_energy();
  return energy;
}

void Places::add_energy_row(double factor, RowPart out) const {
  const int n = chain_->functions();
  if (chain_->stretches() > 0) add_stretch_energy_row(factor, out);
  for (int j = 0; j < chain_->piece_count(); ++j) {
    const Chain::Piece& p = chain_->piece(j);
    if (!p.bends_evenly) {
      add_varying_row(j, factor, out);
      continue;
    }
    const double* q = backbone_.coordinates(j);
    const double h = backbone_.length(j);
    const double stiffness = factor * p.stiffness;
    double bend = 0.0;
    for (int i = 0; i < n; ++i) {
      const double kq = stiff_[j * n + i];
      bend += q[i] * kq;
      out.q[j * n + i] += stiffness * (kq / h - p.rest_curvature * chain_->table().end[i]);
    }
    if (out.s == nullptr) continue;
    const double along = 0.5 * stiffness * (p.rest_curvature * p.rest_curvature - bend / (h * h));
    for (int l = 0; l < arc_lengths_; ++l) out.s[l] += along * length_rate_(j, l);
  }
}

void Places::add_energy_second(double factor, const double* lambda, SecondPart out) const {
  const int n = chain_->functions();
  if (chain_->stretches() > 0) add_stretch_energy_second(factor, lambda, out);
  for (int j = 0; j < chain_->piece_count(); ++j) {
    if (!chain_->piece(j).bends_evenly) {
      add_varying_second(j, factor, lambda, out);
      continue;
    }
    const double stiffness = chain_->piece(j).stiffness / backbone_.length(j);
    const double h = backbone_.length(j);
    const double* q = backbone_.coordinates(j);
    const double by_length = stiffness / h;
    double lambda_kq = 0.0;
    double q_kq = 0.0;
    for (int i = 0; i < n; ++i) {
      const double* k = chain_->table().stiffness.col(i).data();
      const double kq = stiff_[j * n + i];
      double mixed = -factor * kq;
      for (int b = 0; lambda != nullptr && b < n; ++b) mixed += k[b] * lambda[j * n + b];
      double* column = out.qq.data() + (j * n + i) * out.qq.outerStride() + j * n;
      for (int b = 0; factor != 0.0 && b < n; ++b) column[b] += factor * stiffness * k[b];
      lambda_kq += (mixed + factor * kq) * q[i];
      q_kq += q[i] * kq;
      for (int l = 0; l < arc_lengths_; ++l) {
        out.qs.data()[j * n + i + l * out.qs.outerStride()] += by_length * mixed * length_rate_(j, l);
      }
    }
    const double curved = stiffness / (h * h) * (factor * q_kq - 2.0 * lambda_kq);
    for (int l = 0; l < out.ss.rows(); ++l) {
      for (int k = 0; k < out.ss.cols(); ++k) out.ss(l, k) += curved * length_rate_(j, l) * length_rate_(j, k);
    }
  }
}

namespace {

/// At a node: how its strain e changes with an arc length, and how EI e^2 does.
struct Change {
  double h, s, e, square;
};

}  // namespace

double Places::varying_energy(int j) const {
  const Sections::Bending& b = *sections_.bending(j);
  const double h = backbone_.length(j);
  double sum = 0.0;
  for (int g = 0; g < chain_->nodes(); ++g) {
    const double e = bent_(g, j) / h - b.rest[g];
    sum += chain_->table().weight[g] * b.stiffness[g] * e * e;
  }
  return 0.5 * h * sum;
}

void Places::add_varying_row(int j, double factor, RowPart out) const {
  const Sections::Bending& b = *sections_.bending(j);
  const BasisTable& table = chain_->table();
  const double h = backbone_.length(j);
  for (int g = 0; g < table.nodes; ++g) {
    const double e = bent_(g, j) / h - b.rest[g];
    const double weight = factor * table.weight[g];
    along_nodes_[g] = weight * b.stiffness[g] * e;
    for (int l = 0; out.s != nullptr && l < arc_lengths_; ++l) {
      const double h_l = length_rate_(j, l);
      const double s_l = run(j, table.sigma[g], l);
      const double e_l = -bent_(g, j) * h_l / (h * h) - b.rest_slope[g] * s_l;
      out.s[l] += weight * (0.5 * (h_l * b.stiffness[g] + h * b.stiffness_slope[g] * s_l) * e * e +
                            h * b.stiffness[g] * e * e_l);
    }
  }
  for (int i = 0; i < table.functions; ++i) out.q[j * table.functions + i] += along_nodes_.dot(table.slope.col(i));
}

void Places::add_varying_second(int j, double factor, const double* lambda, SecondPart out) const {
  const Sections::Bending& b = *sections_.bending(j);
  const BasisTable& table = chain_->table();
  const int n = table.functions;
  const double h = backbone_.length(j);
  if (factor != 0.0) out.qq.block(j * n, j * n, n, n) += factor / h * sections_.stiffness(j);
  if (arc_lengths_ == 0) return;
  virtual_bent_.setZero();
  if (lambda != nullptr) virtual_bent_.noalias() = table.slope * Eigen::Map<const Eigen::VectorXd>(lambda + j * n, n);
  const auto change = [&](int g, double e, int l) {
    Change c{length_rate_(j, l), run(j, table.sigma[g], l), 0.0, 0.0};
    c.e = -bent_(g, j) * c.h / (h * h) - b.rest_slope[g] * c.s;
    c.square = b.stiffness_slope[g] * c.s * e * e + 2.0 * b.stiffness[g] * e * c.e;
    return c;
  };
  for (int l = 0; l < arc_lengths_; ++l) {
    for (int g = 0; g < table.nodes; ++g) {
      const double e = bent_(g, j) / h - b.rest[g];
      const Change c = change(g, e, l);
      const double stiffer = b.stiffness_slope[g] * c.s;
      along_nodes_[g] = table.weight[g] * (factor * (stiffer * e + b.stiffness[g] * c.e) -
                                           virtual_bent_[g] * (stiffer - b.stiffness[g] * c.h / h) / h);
      for (int k = 0; l < out.ss.rows() && k < out.ss.cols(); ++k) {
        const Change d = change(g, e, k);
        const double e_lk = 2.0 * bent_(g, j) * c.h * d.h / (h * h * h) - b.rest_bend[g] * c.s * d.s;
        const double bent = b.stiffness_bend[g] * c.s * d.s;
        const double turned = b.stiffness_slope[g] * (c.s * d.e + d.s * c.e);
        const double square = bent * e * e + 2.0 * e * turned + 2.0 * b.stiffness[g] * (c.e * d.e + e * e_lk);
        out.ss(l, k) += table.weight[g] * (0.5 * factor * (c.h * d.square + d.h * c.square + h * square) -
                                           virtual_bent_[g] * (bent * e + turned + b.stiffness[g] * e_lk));
      }
    }
    for (int i = 0; i < n; ++i) out.qs(j * n + i, l) += along_nodes_.dot(table.slope.col(i));
  }
}

}  // namespace tendril
