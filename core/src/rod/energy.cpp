// The bending energy (model.md section 3) and its derivatives.

#include "rod/places.hpp"

namespace tendril {

double Places::energy() const {
  const int n = chain_->functions();
  double energy = 0.0;
  for (int j = 0; j < chain_->piece_count(); ++j) {
    const Chain::Piece& p = chain_->piece(j);
    const Eigen::Map<const Eigen::VectorXd> q(backbone_.coordinates(j), n);
    const double bend = q.dot(stiff_.segment(j * n, n));
    energy += p.stiffness * (0.5 * bend / backbone_.length(j) - p.rest_curvature * q.dot(chain_->table().end) +
                             0.5 * p.rest_curvature * p.rest_curvature * backbone_.length(j));
  }
  return energy;
}

void Places::add_energy_row(double factor, RowPart out) const {
  const int n = chain_->functions();
  for (int j = 0; j < chain_->piece_count(); ++j) {
    const Chain::Piece& p = chain_->piece(j);
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
  for (int j = 0; j < chain_->piece_count(); ++j) {
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

}  // namespace tendril
