// Work of actuators, u int p kappa ds, and its derivatives. Where the profile p is the same all over a piece only the
// angles at its ends count; where it varies, knots that move carry the piece along p. A thrust works along the stretch,
// u thrust int eps ds: of a piece that is its length times the mean, the first coordinate of its stretch. A pressure
// may pull by a law of its own, and then pull(u) stands for u there.

#include "rod/places.hpp"

namespace tendril {

void Places::pull_back_moment(int actuator, double moment, double pull, double* out) const {
  const int n = chain_->functions();
  const BasisTable& table = chain_->table();
  for (int j = 0; j < chain_->piece_count(); ++j) {
    if (const double thrust = chain_->thrust(actuator, j); thrust != 0.0) {
      out[j * n + table.bends] += pull * thrust * table.stretch.factor * backbone_.length(j);
    }
    if (const double level = chain_->level(actuator, j); level != 0.0) {
      for (int i = 0; i < n; ++i) out[j * n + i] += moment * level * table.end[i];
      continue;
    }
    const ProfilePart* part = chain_->varying(actuator, j);
    if (part == nullptr) continue;
    for (int g = 0; g < table.nodes; ++g) {
      const double s = backbone_.start(j) + backbone_.length(j) * table.sigma[g];
      const double here = moment * table.weight[g] * part->at(s);
      for (int i = 0; i < n; ++i) out[j * n + i] += here * table.slope(g, i);
    }
  }
}

double Places::stretch_along(int actuator, const double* coordinates) const {
  const BasisTable& table = chain_->table();
  double sum = 0.0;
  for (int j = 0; j < chain_->piece_count(); ++j) {
    const double thrust = chain_->thrust(actuator, j);
    if (thrust == 0.0) continue;
    sum += thrust * table.stretch.factor * backbone_.length(j) * coordinates[j * table.functions + table.bends];
  }
  return sum;
}

double Places::turn_along(int actuator) const {
  const BasisTable& table = chain_->table();
  double turn = stretch_along(actuator, backbone_.coordinates(0));
  for (int j = 0; j < chain_->piece_count(); ++j) {
    const Eigen::Map<const Eigen::VectorXd> q(backbone_.coordinates(j), table.functions);
    const ProfilePart* part = chain_->varying(actuator, j);
    if (part == nullptr) {
      turn += chain_->level(actuator, j) * table.end.dot(q);
      continue;
    }
    for (int g = 0; g < table.nodes; ++g) {
      const double s = backbone_.start(j) + backbone_.length(j) * table.sigma[g];
      turn += table.weight[g] * part->at(s) * table.slope.row(g).dot(q);
    }
  }
  return turn;
}

void Places::add_turn_row(int actuator, RowPart out) {
  pull_back_moment(actuator, 1.0, 1.0, out.q);
  if (out.s == nullptr || arc_lengths_ == 0 || !chain_->has_moving_work()) return;
  // It is linear in the coordinates: they are along themselves.
  add_moment_second(actuator, 0.0, 1.0, backbone_.coordinates(0), Eigen::Map<Eigen::VectorXd>(out.s, arc_lengths_),
                    still_);
}

void Places::add_turn_second(int actuator, double factor, const SecondPart& out) {
  if (factor == 0.0 || arc_lengths_ == 0 || !chain_->has_moving_work()) return;
  add_moment_rates(actuator, factor, factor, out.qs);
  by_s_.setZero();
  add_moment_second(actuator, factor, 1.0, backbone_.coordinates(0), by_s_, out.ss);
}

void Places::add_moment_rates(int actuator, double moment, double pull, MatrixRef by_q_and_s) {
  const int n = chain_->functions();
  const BasisTable& table = chain_->table();
  for (int j = 0; j < chain_->piece_count(); ++j) {
    if (const double thrust = chain_->thrust(actuator, j); thrust != 0.0) {
      by_q_and_s.row(j * n + table.bends) += pull * thrust * table.stretch.factor * length_rate_.row(j);
    }
    const ProfilePart* part = chain_->varying(actuator, j);
    if (part == nullptr) continue;
    for (int g = 0; g < table.nodes; ++g) {
      const double sigma = table.sigma[g];
      const double here = moment * table.weight[g] * part->at(backbone_.start(j) + backbone_.length(j) * sigma, 1);
      for (int l = 0; l < arc_lengths_; ++l) {
        by_q_and_s.col(l).segment(j * n, n) += here * run(j, sigma, l) * table.slope.row(g).transpose();
      }
    }
  }
}

void Places::add_moment_second(int actuator, double moment, double pull_slope, const double* lambda,
                               VectorRef by_moment_and_s, MatrixRef by_s_twice) {
  const int n = chain_->functions();
  const BasisTable& table = chain_->table();
  for (int j = 0; j < chain_->piece_count(); ++j) {
    if (const double thrust = chain_->thrust(actuator, j); thrust != 0.0) {
      by_moment_and_s +=
          pull_slope * thrust * table.stretch.factor * lambda[j * n + table.bends] * length_rate_.row(j).transpose();
    }
    const ProfilePart* part = chain_->varying(actuator, j);
    if (part == nullptr) continue;
    const Eigen::Map<const Eigen::VectorXd> along(lambda + j * n, n);
    for (int g = 0; g < table.nodes; ++g) {
      const double sigma = table.sigma[g];
      const double s = backbone_.start(j) + backbone_.length(j) * sigma;
      const double here = table.weight[g] * table.slope.row(g).dot(along);
      for (int l = 0; l < arc_lengths_; ++l) {
        by_moment_and_s[l] += here * part->at(s, 1) * run(j, sigma, l);
        for (int k = 0; k < arc_lengths_; ++k) {
          by_s_twice(l, k) += moment * here * part->at(s, 2) * run(j, sigma, l) * run(j, sigma, k);
        }
      }
    }
  }
}

}  // namespace tendril
