// Derivatives of the work of forces on places of a rod. A rotation of the rod at a node moves all beyond it across the
// tangent there: to the first order the work is that of the component across, to the second minus that along. All
// weights on one node are summed before they are spread to the coordinates.

#include <algorithm>

#include "rod/sweep.hpp"

namespace tendril {
namespace {

bool is_zero(Vec2 v) { return v == Vec2{}; }

}  // namespace

/// z = weight * (along + psi turning) . t at the nodes; `turning` may be null.
void Places::weigh(int j, const Ramp& along, const Ramp* turning, double* z) const {
  const double* weight = chain_->table().weight.data();
  const double* c = backbone_.cosine_.col(j).data();
  const double* s = backbone_.sine_.col(j).data();
  const double* psi = psi_.col(j).data();
  for (int i = 0; i < chain_->nodes(); ++i) {
    double x = along.end.x + left_[i] * along.slope.x;
    double y = along.end.y + left_[i] * along.slope.y;
    if (turning != nullptr) {
      x += psi[i] * (turning->end.x + left_[i] * turning->slope.x);
      y += psi[i] * (turning->end.y + left_[i] * turning->slope.y);
    }
    z[i] = weight[i] * (x * c[i] + y * s[i]);
  }
  const double* share = turning != nullptr && along.share == nullptr ? turning->share : along.share;
  for (int i = 0; share != nullptr && i < chain_->nodes(); ++i) {
    const double x = along.heavy.x + (turning != nullptr ? psi[i] * turning->heavy.x : 0.0);
    const double y = along.heavy.y + (turning != nullptr ? psi[i] * turning->heavy.y : 0.0);
    z[i] += weight[i] * share[i] * (x * c[i] + y * s[i]);
  }
}

/// z += weight factor (along . t) at the nodes of a rod that stretches, t the unit tangent; without factors these
/// are 1.
void Places::add_unit_weight(int j, const Ramp& along, const double* factors, double* z) const {
  const double* weight = chain_->table().weight.data();
  for (int i = 0; i < chain_->nodes(); ++i) {
    Vec2 force = along.end + left_[i] * along.slope;
    if (along.share != nullptr) force += along.share[i] * along.heavy;
    z[i] += weight[i] * (factors != nullptr ? factors[i] : 1.0) * dot(force, backbone_.unit_tangent(j, i));
  }
}

/// What the stretch of piece j adds to second derivatives by its coordinates: to the weights of the angle's that are in
/// node_buffer_, and by the angle and the stretch. `turning` may be null.
void Places::add_stretch_gram(int j, const Sweep& sweep, const Sweep* turning, bool pushed) {
  unit_buffer_.setZero();
  add_unit_weight(j, sweep.load(j).across(), nullptr, unit_buffer_.data());
  if (turning != nullptr) {
    const Ramp load = -1.0 * turning->load(j);
    add_unit_weight(j, load, eta_.col(j).data(), node_buffer_.data());
    add_unit_weight(j, load, psi_.col(j).data(), unit_buffer_.data());
  }
  if (pushed) unit_buffer_ += backbone_.length(j) * unit_push_across_;
  backbone_.add_mixed_nodes(gram_sums_, j, unit_buffer_.data());
}

/// The same of those by coordinates and arc length l.
void Places::add_stretch_rate(int j, int l, const Sweep& sweep, const Sweep* turning, bool pushed) {
  unit_buffer_.setZero();
  add_unit_weight(j, sweep.load_rate(j, l), nullptr, unit_buffer_.data());
  if (turning != nullptr) {
    const Ramp load = turning->load_rate(j, l).across();
    add_unit_weight(j, load, eta_.col(j).data(), node_buffer_.data());
    add_unit_weight(j, load, psi_.col(j).data(), unit_buffer_.data());
  }
  if (pushed) unit_buffer_ += length_rate_(j, l) * unit_push_along_;
  backbone_.add_stretch_nodes(rate_sums_[static_cast<std::size_t>(l)], j, unit_buffer_.data());
}

/// Sums forces on the stations of a piece at its nodes, along the tangent and across it. False: there are none.
bool Places::gather_pushes(int j, const Forces& forces) {
  Stations& at = stations_[static_cast<std::size_t>(j)];
  const auto count = static_cast<int>(at.place.size());
  bool any = false;
  if (!may_push(j, forces)) return false;
  for (int k = 0; k < count; ++k) {
    const Vec2 force = on(at.place[static_cast<std::size_t>(k)], forces).force;
    any = any || force.x != 0.0 || force.y != 0.0;
    at.push_x[k] = force.x;
    at.push_y[k] = force.y;
  }
  if (!any) return false;
  for (int i = 0; i < chain_->nodes(); ++i) {
    const double* weight = at.by_node.col(i).data();
    double x = 0.0;
    double y = 0.0;
    for (int k = 0; k < count; ++k) {
      x += weight[k] * at.push_x[k];
      y += weight[k] * at.push_y[k];
    }
    const Vec2 t = backbone_.tangent(j, i);
    push_along_[i] = x * t.x + y * t.y;
    push_across_[i] = y * t.x - x * t.y;
    if (chain_->stretches() == 0) continue;
    const Vec2 unit = backbone_.unit_tangent(j, i);
    unit_push_along_[i] = x * unit.x + y * unit.y;
    unit_push_across_[i] = y * unit.x - x * unit.y;
  }
  return true;
}

double Places::work(const Forces& forces) {
  const Vec2 base = backbone_.base();
  double sum = dot(forces.tip, backbone_.tip() - base);
  for (int k = 0; k < count(); ++k) sum += dot(on(k, forces).force, at(k).point - base);
  const bool dead = dead_ && !is_zero(forces.dead);
  if (is_zero(forces.gravity) && !dead) return sum;
  const Forces weight{{}, {}, forces.gravity, forces.payload, forces.dead};
  Sweep sweep(*this, weight);
  for (int j = chain_->piece_count() - 1; j >= 0; --j) {
    sweep.enter(j);
    weigh(j, sweep.load(j), nullptr, node_buffer_.data());
    sum += node_buffer_.sum();
    sweep.leave(j);
  }
  return sum;
}

void Places::pull_back(const Forces& forces, double* out) {
  double* z = node_buffer_.data();
  Sweep sweep(*this, forces);
  sums_.set_zero();
  for (int j = chain_->piece_count() - 1; j >= 0; --j) {
    const double h = backbone_.length(j);
    sweep.enter(j);
    const Ramp load = sweep.load(j);
    const bool pushed = gather_pushes(j, forces);
    if (pushed || !is_zero(load.end) || !is_zero(load.slope) || !is_zero(load.heavy)) {
      weigh(j, load.across(), nullptr, z);
      for (int i = 0; pushed && i < chain_->nodes(); ++i) z[i] += h * push_across_[i];
      backbone_.add_nodes(sums_, j, z);
      if (chain_->stretches() > 0) {
        unit_buffer_.setZero();
        add_unit_weight(j, load, nullptr, unit_buffer_.data());
        if (pushed) unit_buffer_ += h * unit_push_along_;
        backbone_.add_stretch_nodes(sums_, j, unit_buffer_.data());
      }
    }
    for (const int k : knots_) {
      if (at(k).piece == j && sweep.on(k).moment != 0.0) {
        sums_.add_point(j, sweep.on(k).moment, chain_->table().end.data());
      }
    }
    for (const int k : inside_) {
      const Push& push = sweep.on(k);
      if (at(k).piece != j) continue;
      const MovingPoint& m = moving_[own(k)];
      for (int i = 0; i < m.node_count(); ++i) {
        sums_.add_point(j, h * m.weight(i) * dot(push.force, turned(m.node_tangent(i))), m.node_beta(i));
        if (chain_->stretches() == 0) continue;
        sums_.add_stretch_point(j, h * m.weight(i) * dot(push.force, m.node_unit(i)), m.node_stretch(i));
      }
      if (push.moment != 0.0) sums_.add_point(j, push.moment, m.beta());
      for (int i = 0; i < chain_->bends(); ++i) sums_.vector(i, j) += push.bending / h * m.beta1()[i];
      if (push.strain != 0.0) sums_.add_stretch_point(j, push.strain, m.stretch_functions());
    }
    sweep.leave(j);
  }
  backbone_.spread(sums_, out);
}

void Places::second_pull_back(const Forces& forces, const Forces* virtual_forces, SecondPart out) {
  add_second(forces, virtual_forces, out);
  if (turn_ >= 0) add_turn(forces, virtual_forces, out);
}

/// By the angle of the base. Where it turns all places turn about it, and so do virtual displacements: to these forces
/// it is as if they turned back.
void Places::add_turn(const Forces& forces, const Forces* virtual_forces, SecondPart& out) {
  const auto turn_back = [this](const Forces& f) {
    back_.on.resize(f.on.size());
    for (std::size_t k = 0; k < f.on.size(); ++k) back_.on[k] = {turned_back(f.on[k].force)};
    back_.tip = turned_back(f.tip);
    back_.gravity = turned_back(f.gravity);
    back_.payload = f.payload;
    back_.dead = turned_back(f.dead);
  };
  turn_back(forces);
  pull_back(back_, out.qs.col(turn_).data());
  if (out.ss.size() == 0) return;
  const auto add = [&](int l, double value) {
    out.ss(turn_, l) += value;
    if (l != turn_) out.ss(l, turn_) += value;
  };
  const int n = chain_->coordinate_count();
  double* row = row_buffer_.data();
  for (int k = 0; k < count(); ++k) {
    if (is_zero(on(k, back_).force)) continue;
    row_from_base(k, on(k, back_).force, {row, row + n});
    for (int l = 0; l < arc_lengths_; ++l) add(l, row[n + l]);
  }
  if (virtual_forces == nullptr) return;
  turn_back(*virtual_forces);
  second_buffer_.setZero();
  SecondPart once{second_buffer_.leftCols(n), second_buffer_.rightCols(arc_lengths_), out.ss.topLeftCorner(0, 0)};
  add_second(back_, nullptr, once);
  out.qs.col(turn_) += once.qq * lambda_;
  for (int l = 0; l < arc_lengths_; ++l) {
    if (l != turn_) add(l, once.qs.col(l).dot(lambda_));
  }
  // And back once more by the angle twice.
  turn_back(back_);
  row_buffer_.setZero();
  pull_back(back_, row);
  add(turn_, lambda_.dot(row_buffer_.head(n)));
}

void Places::add_second(const Forces& forces, const Forces* virtual_forces, SecondPart& out) {
  double* z = node_buffer_.data();
  Sweep sweep(*this, forces);
  Sweep turning(*this, virtual_forces != nullptr ? *virtual_forces : forces);
  const Sweep* by_turning = virtual_forces != nullptr ? &turning : nullptr;
  const bool stretches = chain_->stretches() > 0;
  const auto pulls = [&](const Forces& f) { return !is_zero(f.gravity) || (dead_ && !is_zero(f.dead)); };
  const bool heavy =
      chain_->knot_count() > 0 && (pulls(forces) || (virtual_forces != nullptr && pulls(*virtual_forces)));
  gram_sums_.set_zero();
  for (PieceSums& sums : rate_sums_) sums.set_zero();
  for (int j = chain_->piece_count() - 1; j >= 0; --j) {
    const double h = backbone_.length(j);
    sweep.enter(j);
    if (virtual_forces != nullptr) turning.enter(j);
    const auto weights = [&](const Ramp& along, const Ramp& by_psi) {
      weigh(j, along, virtual_forces != nullptr ? &by_psi : nullptr, z);
    };
    const bool pushed = gather_pushes(j, forces);
    weights(-1.0 * sweep.load(j), -1.0 * turning.load(j).across());
    for (int i = 0; pushed && i < chain_->nodes(); ++i) z[i] -= h * push_along_[i];
    if (stretches) add_stretch_gram(j, sweep, by_turning, pushed);
    backbone_.add_gram_nodes(gram_sums_, j, z);
    for (int l = 0; l < arc_lengths_; ++l) {
      const double rate = length_rate_(j, l);
      if (still(j, l)) continue;
      weights(sweep.load_rate(j, l).across(), -1.0 * turning.load_rate(j, l));
      for (int i = 0; pushed && i < chain_->nodes(); ++i) z[i] += rate * push_across_[i];
      if (stretches) add_stretch_rate(j, l, sweep, by_turning, pushed);
      backbone_.add_nodes(rate_sums_[static_cast<std::size_t>(l)], j, z);
    }
    add_inside(forces, virtual_forces, j, out);
    for (int l = 0; heavy && l < out.ss.rows(); ++l) {
      for (int k = 0; k < out.ss.cols(); ++k) {
        weights(sweep.load_bend(j, l, k), turning.load_bend(j, l, k).across());
        if (stretches && by_turning != nullptr) add_unit_weight(j, turning.load_bend(j, l, k), eta_.col(j).data(), z);
        out.ss(l, k) += node_buffer_.sum();
      }
    }
    sweep.leave(j);
    if (virtual_forces != nullptr) turning.leave(j);
  }
  backbone_.spread_gram(gram_sums_, out.qq);
  for (int l = 0; l < arc_lengths_; ++l) {
    backbone_.spread(rate_sums_[static_cast<std::size_t>(l)], out.qs.col(l).data());
  }
}

/// Places inside of piece j: they act on its nodes up to themselves, and run along it.
void Places::add_inside(const Forces& forces, const Forces* virtual_forces, int j, SecondPart& out) {
  const double h = backbone_.length(j);
  const int n = chain_->functions();
  for (const int k : inside_) {
    const Place& p = at(k);
    if (p.piece != j) continue;
    const MovingPoint& m = moving_[static_cast<std::size_t>(p.own)];
    const Push& push = on(k, forces);
    const bool turns = virtual_forces != nullptr;
    const Vec2 v = turns ? on(k, *virtual_forces).force : Vec2{};
    // Derivative by a rotation at a node, there and across it.
    const auto along = [&](Vec2 t, double psi) { return dot(push.force, t) + psi * dot(v, turned(t)); };
    const auto across = [&](Vec2 t, double psi) { return dot(push.force, turned(t)) - psi * dot(v, t); };
    for (int i = 0; i < m.node_count(); ++i) {
      const Vec2 t = m.node_tangent(i);
      const double psi = turns ? m.node_psi(i) : 0.0;
      gram_sums_.add_gram_point(j, -h * m.weight(i) * along(t, psi), m.node_beta(i));
      for (int l = 0; l < arc_lengths_; ++l) {
        const double rate = length_rate_(j, l);
        if (rate == 0.0) continue;
        rate_sums_[static_cast<std::size_t>(l)].add_point(j, rate * m.weight(i) * across(t, psi), m.node_beta(i));
      }
    }
    const double at_end = across(m.velocity(), turns ? m.psi() : 0.0);
    for (int l = 0; l < arc_lengths_; ++l) {
      const double run = own_rate(p, l);
      const double sigma_l = run / h;
      const double h_l = length_rate_(j, l);
      rate_sums_[static_cast<std::size_t>(l)].add_point(j, run * at_end, m.beta());
      // Angle and curvature see the own piece's coordinates only.
      const double by_slope = push.moment * sigma_l - push.bending * h_l / (h * h);
      const double by_bend = push.bending * sigma_l / h;
      for (int i = 0; i < chain_->bends(); ++i) {
        out.qs(j * n + i, l) += by_slope * m.beta1()[i] + by_bend * m.beta2()[i];
      }
    }
    if (chain_->stretches() > 0) add_inside_stretch(p, push, v, turns, out);
    if (out.ss.size() == 0) continue;
    double jerk = 0.0;
    if (push.bending != 0.0) {
      m.third_derivative(third_.data());
      for (int i = 0; i < chain_->bends(); ++i) jerk += backbone_.coordinates(j)[i] * third_[i];
    }
    const double turn = at_end * m.slope() + (turns ? m.psi_slope() * dot(v, m.normal()) : 0.0);
    for (int l = 0; l < arc_lengths_; ++l) {
      for (int i = 0; i < arc_lengths_; ++i) {
        const double sl = own_rate(p, l) / h;
        const double si = own_rate(p, i) / h;
        const double hl = length_rate_(j, l) / h;
        const double hi = length_rate_(j, i) / h;
        const double mixed = -(hl * si + hi * sl);
        const double bent = jerk * sl * si + 2.0 * m.bend() * mixed + 2.0 * m.slope() * hl * hi;
        out.ss(l, i) +=
            turn * h * sl * si + push.moment * (m.bend() * sl * si + m.slope() * mixed) + push.bending / h * bent;
      }
    }
  }
}

}  // namespace tendril
