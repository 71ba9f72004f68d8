// How a rod stretches (model.md section 14): P' = (1 + eps) t, V_e = 1/2 int EA eps^2 ds. The angle turns all beyond a
// node, the stretch moves it along the tangent there; a second derivative by two coordinates of the stretch is 0.

#include <algorithm>
#include <cmath>

#include "rod/sweep.hpp"

namespace tendril {

double Places::stretch_energy() const {
  double energy = 0.0;
  for (int j = 0; j < chain_->piece_count(); ++j) {
    const Eigen::VectorXd& axial = sections_.axial(j).value;
    for (int g = 0; g < chain_->nodes(); ++g) {
      energy += 0.5 * backbone_.length(j) * chain_->table().weight[g] * axial[g] * strain_(g, j) * strain_(g, j);
    }
  }
  return energy;
}

void Places::add_stretch_energy_row(double factor, RowPart out) const {
  const BasisTable& table = chain_->table();
  for (int j = 0; j < chain_->piece_count(); ++j) {
    const Sections::Axial& a = sections_.axial(j);
    const double h = backbone_.length(j);
    along_nodes_ = factor * h * table.weight.cwiseProduct(a.value).cwiseProduct(strain_.col(j));
    for (int k = 0; k < table.stretch.order; ++k) {
      out.q[j * table.functions + table.bends + k] += along_nodes_.dot(table.stretch_by_function.col(k));
    }
    for (int l = 0; out.s != nullptr && l < arc_lengths_; ++l) {
      for (int g = 0; g < table.nodes; ++g) {
        const double stiffer = length_rate_(j, l) * a.value[g] + h * a.slope[g] * run(j, table.sigma[g], l);
        out.s[l] += 0.5 * factor * table.weight[g] * stiffer * strain_(g, j) * strain_(g, j);
      }
    }
  }
}

void Places::add_stretch_energy_second(double factor, const double* lambda, SecondPart out) const {
  const BasisTable& table = chain_->table();
  const int m = table.stretch.order;
  for (int j = 0; j < chain_->piece_count(); ++j) {
    const Sections::Axial& a = sections_.axial(j);
    const double h = backbone_.length(j);
    const int first = j * table.functions + table.bends;
    for (int k = 0; factor != 0.0 && k < m; ++k) {
      along_nodes_ = factor * h * table.weight.cwiseProduct(a.value).cwiseProduct(table.stretch_by_function.col(k));
      for (int i = 0; i < m; ++i) out.qq(first + i, first + k) += along_nodes_.dot(table.stretch_by_function.col(i));
    }
    if (arc_lengths_ == 0) continue;
    virtual_bent_.setZero();
    if (lambda != nullptr) {
      virtual_bent_.noalias() = table.stretch_by_function * Eigen::Map<const Eigen::VectorXd>(lambda + first, m);
    }
    for (int l = 0; l < arc_lengths_; ++l) {
      for (int g = 0; g < table.nodes; ++g) {
        const double s_l = run(j, table.sigma[g], l);
        const double h_l = length_rate_(j, l);
        const double e = strain_(g, j);
        along_nodes_[g] = table.weight[g] * (h_l * a.value[g] + h * a.slope[g] * s_l) * (factor * e - virtual_bent_[g]);
        for (int k = 0; l < out.ss.rows() && k < out.ss.cols(); ++k) {
          const double s_k = run(j, table.sigma[g], k);
          const double stiffer = (h_l * s_k + length_rate_(j, k) * s_l) * a.slope[g] + h * a.bend[g] * s_l * s_k;
          out.ss(l, k) += table.weight[g] * stiffer * e * (0.5 * factor * e - virtual_bent_[g]);
        }
      }
      for (int k = 0; k < m; ++k) out.qs(first + k, l) += along_nodes_.dot(table.stretch_by_function.col(k));
    }
  }
}

/// Adds the derivatives of the stretch beside a place, times a factor.
void Places::add_stretch_row(int place, const Side& side, double factor, RowPart out) const {
  const Place& p = at(place);
  const BasisTable& table = chain_->table();
  double* own = out.q + side.piece * table.functions + table.bends;
  const MovingPoint* m = side.where == Side::inside ? &moving_[static_cast<std::size_t>(p.own)] : nullptr;
  for (int k = 0; k < table.stretch.order; ++k) {
    own[k] += factor * (m != nullptr                ? m->stretch_functions()[k]
                        : side.where == Side::start ? table.stretch_start[k]
                                                    : table.stretch.factor);
  }
  for (int l = 0; m != nullptr && l < arc_lengths_; ++l) {
    out.s[l] += factor * m->stretch_slope() * own_rate(p, l) / backbone_.length(p.piece);
  }
}

/// What the stretch adds to second derivatives of the work of a force on a place inside of its piece, and of a virtual
/// one, v.
void Places::add_inside_stretch(const Place& p, const Push& push, Vec2 v, bool turns, SecondPart& out) {
  const int j = p.piece;
  const double h = backbone_.length(j);
  const MovingPoint& m = moving_[static_cast<std::size_t>(p.own)];
  // Derivative by the growth at a node, and by a rotation of what has grown there.
  const auto along = [&](Vec2 t, double psi) { return dot(push.force, t) + psi * dot(v, turned(t)); };
  const auto across = [&](Vec2 t, double psi) { return dot(push.force, turned(t)) - psi * dot(v, t); };
  for (int i = 0; i < m.node_count(); ++i) {
    const Vec2 t = m.node_unit(i);
    const double psi = turns ? m.node_psi(i) : 0.0;
    const double eta = turns ? m.node_eta(i) : 0.0;
    const double w = m.weight(i);
    gram_sums_.add_gram_point(j, -h * w * eta * dot(v, t), m.node_beta(i));
    gram_sums_.add_mixed_point(j, h * w * across(t, psi), m.node_beta(i), m.node_stretch(i));
    for (int l = 0; l < arc_lengths_; ++l) {
      const double rate = length_rate_(j, l);
      if (rate == 0.0) continue;
      PieceSums& sums = rate_sums_[static_cast<std::size_t>(l)];
      sums.add_point(j, rate * w * eta * dot(v, turned(t)), m.node_beta(i));
      sums.add_stretch_point(j, rate * w * along(t, psi), m.node_stretch(i));
    }
  }
  const double psi = turns ? m.psi() : 0.0;
  const double eta = turns ? m.eta() : 0.0;
  const double turning = eta * dot(v, turned(m.tangent()));
  const double growing = along(m.tangent(), psi);
  double bent = turning * m.slope() + growing * m.stretch_slope();
  if (turns) bent += m.eta_slope() * dot(v, m.tangent());
  const int first = j * chain_->functions() + chain_->bends();
  const double bend =
      push.strain != 0.0 ? chain_->table().stretch.bend(m.sigma(), backbone_.coordinates(j) + chain_->bends()) : 0.0;
  for (int l = 0; l < arc_lengths_; ++l) {
    PieceSums& sums = rate_sums_[static_cast<std::size_t>(l)];
    const double run_l = own_rate(p, l);
    sums.add_point(j, run_l * turning, m.beta());
    sums.add_stretch_point(j, run_l * growing, m.stretch_functions());
    for (int k = 0; push.strain != 0.0 && k < chain_->stretches(); ++k) {
      out.qs(first + k, l) += push.strain * run_l / h * m.stretch_function_slopes()[k];
    }
    for (int i = 0; l < out.ss.rows() && i < out.ss.cols(); ++i) {
      const double run_i = own_rate(p, i);
      out.ss(l, i) += bent * run_l * run_i / h;
      // sigma of a place that stands still moves as the piece does.
      const double mixed = length_rate_(j, l) * run_i + length_rate_(j, i) * run_l;
      out.ss(l, i) += push.strain * (bend * run_l * run_i - m.stretch_slope() * mixed) / (h * h);
    }
  }
}

double Places::stretch_defect(const Forces& forces, std::span<const double> moments) {
  if (chain_->stretches() == 0) return 0.0;
  Sweep sweep(*this, forces);
  double worst = 0.0;
  for (int j = chain_->piece_count() - 1; j >= 0; --j) {
    sweep.enter(j);
    const Ramp load = sweep.load(j);
    double pulled = 0.0;
    for (int a = 0; a < chain_->actuator_count(); ++a)
      pulled += chain_->thrust(a, j) * chain_->pull(a, moments[static_cast<std::size_t>(a)]).value;
    for (int g = 0; g < chain_->nodes(); ++g) {
      Vec2 force = load.end + left_[g] * load.slope;
      if (load.share != nullptr) force += load.share[g] * load.heavy;
      force = (1.0 / backbone_.length(j)) * force;
      for (const int k : inside_) {
        if (at(k).piece == j && moving_[own(k)].sigma() > chain_->table().sigma[g]) force += sweep.on(k).force;
      }
      const double tension = dot(force, backbone_.unit_tangent(j, g)) + pulled;
      worst = std::max(worst, std::abs(strain_(g, j) - tension / sections_.axial(j).value[g]));
    }
    sweep.leave(j);
  }
  return worst;
}

}  // namespace tendril
