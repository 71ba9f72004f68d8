#include "rod/moving_point.hpp"

#include <algorithm>
#include <cmath>

namespace tendril {

MovingPoint::MovingPoint(const Chain& chain) : chain_(&chain), breaks_(chain.model().breaks()) {
  const auto take = [this](const Quadrature& rule) {
    local_nodes_ = rule.nodes();
    local_weights_ = rule.weights();
  };
  // Without breaks the chain's rule is the one of an interval, which takes long to find anew.
  if (breaks_.empty()) {
    take(chain.rule());
  } else {
    take(Quadrature(chain.rule().nodes_per_interval()));
  }
  const auto most = static_cast<Eigen::Index>(breaks_.size() + 1) * local_nodes_.size() + 1;
  const int n = chain.functions();
  for (Eigen::VectorXd* v : {&weight_, &sigma_nodes_, &cosine_, &sine_, &psi_}) v->setZero(most);
  for (Eigen::VectorXd* v : {&beta_, &beta1_, &beta2_}) v->setZero(n);
  for (Eigen::MatrixXd* m : {&value_, &first_, &second_}) m->setZero(most, n);
  by_node_.setZero(n, most);
  if (chain.stretches() == 0) return;
  for (Eigen::VectorXd* v : {&unit_cosine_, &unit_sine_, &eta_}) v->setZero(most);
  stretch_slopes_.setZero(chain.stretches());
  by_stretch_.setZero(chain.stretches(), most);
}

void MovingPoint::move(const Backbone& backbone, int j, double s) {
  move_to(backbone, j, std::clamp((s - backbone.start(j)) / backbone.length(j), 0.0, 1.0));
}

void MovingPoint::move_to(const Backbone& backbone, int j, double sigma) {
  piece_ = j;
  length_ = backbone.length(j);
  sigma_ = sigma;
  const int n = chain_->bends();
  const auto local = static_cast<int>(local_nodes_.size());
  node_count_ = 0;
  double from = 0.0;
  for (std::size_t b = 0; b <= breaks_.size() && from < sigma_; ++b) {
    const double to = b < breaks_.size() ? std::min(breaks_[b], sigma_) : sigma_;
    for (int g = 0; g < local; ++g, ++node_count_) {
      sigma_nodes_[node_count_] = from + (to - from) * local_nodes_[g];
      weight_[node_count_] = (to - from) * local_weights_[g];
    }
    from = to;
  }
  // The point itself is evaluated in the same call as its nodes.
  sigma_nodes_[node_count_] = sigma_;
  const Eigen::Index rows = node_count_ + 1;
  chain_->model().evaluate({sigma_nodes_.data(), static_cast<std::size_t>(rows)}, value_.topLeftCorner(rows, n),
                           first_.topLeftCorner(rows, n), second_.topLeftCorner(rows, n));
  const double* q = backbone.coordinates(j);
  chord_ = {};
  for (int g = 0; g < node_count_; ++g) {
    double angle = backbone.knot_angle(j);
    for (int i = 0; i < n; ++i) {
      by_node_(i, g) = value_(g, i);
      angle += q[i] * value_(g, i);
    }
    cosine_[g] = std::cos(angle);
    sine_[g] = std::sin(angle);
    if (chain_->stretches() > 0) {
      unit_cosine_[g] = cosine_[g];
      unit_sine_[g] = sine_[g];
      const double stretched = find_stretch(g, q + n);
      cosine_[g] *= stretched;
      sine_[g] *= stretched;
    }
    chord_ += weight_[g] * Vec2{cosine_[g], sine_[g]};
  }
  angle_ = backbone.knot_angle(j);
  slope_ = bend_ = 0.0;
  for (int i = 0; i < n; ++i) {
    beta_[i] = value_(node_count_, i);
    beta1_[i] = first_(node_count_, i);
    beta2_[i] = second_(node_count_, i);
    angle_ += q[i] * beta_[i];
    slope_ += q[i] * beta1_[i];
    bend_ += q[i] * beta2_[i];
  }
  if (chain_->stretches() > 0) {
    stretch_ = find_stretch(node_count_, q + n);
    stretch_slope_ = 0.0;
    for (int k = 0; k < chain_->stretches(); ++k) stretch_slope_ += q[n + k] * stretch_slopes_[k];
  }
  tangent_ = {std::cos(angle_), std::sin(angle_)};
  position_ = backbone.knot_point(j) + length_ * chord_;
}

/// 1 + eps at a node, from the coordinates of the stretch.
double MovingPoint::find_stretch(int g, const double* e) {
  chain_->table().stretch.evaluate(sigma_nodes_[g], by_stretch_.col(g).data(), stretch_slopes_.data());
  double sum = 1.0;
  for (int k = 0; k < chain_->stretches(); ++k) sum += e[k] * by_stretch_(k, g);
  return sum;
}

void MovingPoint::third_derivative(double* third) const {
  std::size_t interval = 0;
  while (interval < breaks_.size() && sigma_ > breaks_[interval]) ++interval;
  const double from = interval == 0 ? 0.0 : breaks_[interval - 1];
  const double to = interval < breaks_.size() ? breaks_[interval] : 1.0;
  const double z = 2.0 * (sigma_ - from) / (to - from) - 1.0;
  const Eigen::MatrixXd& c = chain_->table().bend_series[interval];
  std::fill_n(third, c.rows(), 0.0);
  // P'_k = P'_(k-2) + (2k-1) P_(k-1), carried along with the three-term recurrence of P itself.
  double p_before = 1.0;
  double p = z;
  double d_before = 0.0;
  double d = 1.0;
  for (Eigen::Index k = 1; k < c.cols(); ++k) {
    for (Eigen::Index i = 0; i < c.rows(); ++i) third[i] += c(i, k) * d * 2.0 / (to - from);
    const auto order = static_cast<double>(k + 1);
    const double p_next = ((2.0 * order - 1.0) * z * p - (order - 1.0) * p_before) / order;
    const double d_next = d_before + (2.0 * order - 1.0) * p;
    p_before = p;
    p = p_next;
    d_before = d;
    d = d_next;
  }
}

void MovingPoint::own_row(Vec2 n, bool displaced, double* row) const {
  const int bends = chain_->bends();
  std::fill_n(row, chain_->functions(), 0.0);
  for (int g = 0; g < node_count_; ++g) {
    const Vec2 t = node_tangent(g);
    double w = length_ * weight_[g] * (displaced ? -psi_[g] * dot(n, t) : dot(n, turned(t)));
    if (chain_->stretches() > 0) {
      const Vec2 unit = node_unit(g);
      const Vec2 grown = displaced ? psi_[g] * turned(unit) : unit;
      const double along = length_ * weight_[g] * dot(n, grown);
      for (int k = 0; k < chain_->stretches(); ++k) row[bends + k] += along * node_stretch(g)[k];
      if (displaced) w += length_ * weight_[g] * eta_[g] * dot(n, turned(unit));
    }
    for (int i = 0; i < bends; ++i) row[i] += w * node_beta(g)[i];
  }
}

void MovingPoint::displace(const double* lambda, double psi) {
  const int functions = chain_->bends();
  virtual_chord_ = {};
  psi_slope_ = 0.0;
  for (int g = 0; g <= node_count_; ++g) {
    const double* beta = g < node_count_ ? node_beta(g) : beta_.data();
    psi_[g] = psi;
    for (int i = 0; i < functions; ++i) psi_[g] += lambda[i] * beta[i];
    if (g < node_count_) virtual_chord_ += weight_[g] * psi_[g] * turned(node_tangent(g));
  }
  for (int i = 0; i < functions; ++i) psi_slope_ += lambda[i] * beta1_[i];
  if (chain_->stretches() > 0) grow(lambda + functions);
}

void MovingPoint::grow(const double* lambda) {
  eta_slope_ = 0.0;
  for (int g = 0; g <= node_count_; ++g) {
    eta_[g] = 0.0;
    for (int k = 0; k < chain_->stretches(); ++k) eta_[g] += lambda[k] * by_stretch_(k, g);
    if (g < node_count_) virtual_chord_ += weight_[g] * eta_[g] * node_unit(g);
  }
  for (int k = 0; k < chain_->stretches(); ++k) eta_slope_ += lambda[k] * stretch_slopes_[k];
}

}  // namespace tendril
