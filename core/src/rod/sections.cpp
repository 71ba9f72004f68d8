#include "rod/sections.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace tendril {
namespace {

Eigen::MatrixXd inverse_root(const Eigen::MatrixXd& stiffness) {
  const Eigen::LLT<Eigen::MatrixXd> llt(stiffness);
  return llt.matrixU().solve(Eigen::MatrixXd::Identity(stiffness.rows(), stiffness.cols()));
}

}  // namespace

Sections::Sections(const Chain& chain) : chain_(&chain) {
  const int pieces = chain.piece_count();
  const int nodes = chain.nodes();
  start_.setConstant(pieces, -1.0);
  length_.setConstant(pieces, -1.0);
  own_.resize(static_cast<std::size_t>(pieces));
  turn_.setZero(std::max(nodes, chain.functions()));
  for (int j = 0; j < pieces; ++j) {
    Own& o = own_[static_cast<std::size_t>(j)];
    Bending& b = o.bending;
    if (!chain.piece(j).bends_evenly) {
      for (Eigen::VectorXd* v : {&b.stiffness, &b.stiffness_slope, &b.stiffness_bend}) v->setZero(nodes);
      for (Eigen::VectorXd* v : {&b.rest, &b.rest_slope, &b.rest_bend}) v->setZero(nodes);
      o.stiffness.setZero(chain.functions(), chain.functions());
      weighted_.setZero(nodes, chain.functions());
    }
    if (chain.stretches() > 0) {
      for (Eigen::VectorXd* v : {&o.axial.value, &o.axial.slope, &o.axial.bend}) v->setZero(nodes);
    }
    if (chain.piece(j).weighs_evenly) continue;
    for (Eigen::VectorXd* v : {&o.weight.value, &o.weight.slope, &o.weight.beyond}) v->setZero(nodes);
  }
}

void Sections::move(const Backbone& backbone) {
  const Eigen::VectorXd& sigma = chain_->table().sigma;
  for (int j = 0; j < chain_->piece_count(); ++j) {
    const Chain::Piece& p = chain_->piece(j);
    const double start = backbone.start(j);
    const double h = backbone.length(j);
    if (start_[j] == start && length_[j] == h) continue;
    start_[j] = start;
    length_[j] = h;
    const bool stretches = chain_->stretches() > 0;
    if (p.bends_evenly && p.weighs_evenly && !stretches) continue;
    Own& o = own_[static_cast<std::size_t>(j)];
    o.known = o.factored = false;
    const Rod::Segment& segment = chain_->segment(j);
    if (!p.weighs_evenly) o.weight.whole = segment.weight_up_to(start + h) - segment.weight_up_to(start);
    for (Eigen::Index g = 0; g < sigma.size(); ++g) {
      const double s = start + sigma[g] * h;
      if (stretches) {
        const Rod::Jet axial = segment.axial_at(s);
        o.axial.value[g] = axial.value;
        o.axial.slope[g] = axial.slope;
        o.axial.bend[g] = axial.bend;
      }
      if (!p.bends_evenly) {
        const Rod::Jet stiffness = segment.stiffness_at(s);
        const Rod::Jet rest = segment.rest_curvature_at(s);
        Bending& b = o.bending;
        b.stiffness[g] = stiffness.value;
        b.stiffness_slope[g] = stiffness.slope;
        b.stiffness_bend[g] = stiffness.bend;
        b.rest[g] = rest.value;
        b.rest_slope[g] = rest.slope;
        b.rest_bend[g] = rest.bend;
      }
      if (p.weighs_evenly) continue;
      const Rod::Jet weight = segment.weight_at(s);
      o.weight.value[g] = weight.value;
      o.weight.slope[g] = weight.slope;
      o.weight.beyond[g] = segment.weight_up_to(start + h) - segment.weight_up_to(s);
    }
  }
}

const Eigen::MatrixXd& Sections::stiffness(int j) const {
  Own& o = own_[static_cast<std::size_t>(j)];
  if (o.known) return o.stiffness;
  const BasisTable& table = chain_->table();
  weighted_ = table.weight.cwiseProduct(o.bending.stiffness).asDiagonal() * table.slope;
  for (int i = 0; i < table.functions; ++i) {
    for (int k = i; k < table.functions; ++k) {
      o.stiffness(i, k) = o.stiffness(k, i) = weighted_.col(i).dot(table.slope.col(k));
    }
  }
  o.known = true;
  return o.stiffness;
}

/// The energy of the angle and that of the stretch have no part in common.
Sections::Unit Sections::unit_with_stretch(int j) const {
  Own& o = own_[static_cast<std::size_t>(j)];
  if (o.factored) return {o.inverse, 1.0};
  const BasisTable& table = chain_->table();
  const int n = table.bends;
  const int m = table.stretch.order;
  const Chain::Piece& p = chain_->piece(j);
  const Eigen::MatrixXd bending = p.bends_evenly ? Eigen::MatrixXd(p.stiffness * table.stiffness) : stiffness(j);
  o.inverse.setZero(n + m, n + m);
  o.inverse.topLeftCorner(n, n) = std::sqrt(length_[j]) * inverse_root(bending.topLeftCorner(n, n));
  const Eigen::VectorXd weight = length_[j] * table.weight.cwiseProduct(o.axial.value);
  o.inverse.bottomRightCorner(m, m) =
      inverse_root(table.stretch_by_node * weight.asDiagonal() * table.stretch_by_function);
  o.factored = true;
  return {o.inverse, 1.0};
}

/// d (v . K v) by arc length l, K the second derivative of the energy of the stretch.
double Sections::by_stretch(int j, const double* v, int l) const {
  const BasisTable& table = chain_->table();
  const Axial& a = own(j).axial;
  const double rate = chain_->length_rate()(j, l);
  auto grown = turn_.head(table.nodes);
  grown.noalias() = table.stretch_by_function * Eigen::Map<const Eigen::VectorXd>(v + table.bends, table.stretch.order);
  double sum = 0.0;
  for (int g = 0; g < table.nodes; ++g) {
    const double run = chain_->start_rate()(j, l) + table.sigma[g] * rate;
    sum += table.weight[g] * grown[g] * grown[g] * (rate * a.value[g] + length_[j] * a.slope[g] * run);
  }
  return sum;
}

Sections::Unit Sections::unit(int j) const {
  if (chain_->stretches() > 0) return unit_with_stretch(j);
  const Chain::Piece& p = chain_->piece(j);
  if (p.bends_evenly) {
    if (even_inverse_.size() == 0) even_inverse_ = inverse_root(chain_->table().stiffness);
    return {even_inverse_, std::sqrt(length_[j] / p.stiffness)};
  }
  Own& o = own_[static_cast<std::size_t>(j)];
  if (!o.factored) o.inverse = inverse_root(stiffness(j));
  o.factored = true;
  return {o.inverse, std::sqrt(length_[j])};
}

double Sections::stretching(int j, double factor, const double* v, int l) const {
  const BasisTable& table = chain_->table();
  const Chain::Piece& p = chain_->piece(j);
  const double h = length_[j];
  const double rate = chain_->length_rate()(j, l);
  const Eigen::Map<const Eigen::VectorXd> own(v, table.functions);
  const double along = chain_->stretches() > 0 ? factor * by_stretch(j, v, l) : 0.0;
  if (p.bends_evenly) {
    // The energy of a turn falls as the piece grows.
    auto bent = turn_.head(table.functions);
    bent.noalias() = table.stiffness * own;
    const double energy = p.stiffness / h * own.dot(bent);
    return along - factor * energy / h * rate;
  }
  const Bending& b = *bending(j);
  auto bent = turn_.head(table.nodes);
  bent.noalias() = table.slope * own;
  double sum = 0.0;
  for (int g = 0; g < table.nodes; ++g) {
    const double run = chain_->start_rate()(j, l) + table.sigma[g] * rate;
    sum += table.weight[g] * bent[g] * bent[g] * (b.stiffness_slope[g] * run - b.stiffness[g] * rate / h);
  }
  return along + factor * sum / h;
}

}  // namespace tendril
