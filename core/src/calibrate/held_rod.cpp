#include "calibrate/held_rod.hpp"

#include <algorithm>
#include <cmath>

#include "nlp/newton.hpp"

namespace tendril {
namespace {

/// Newton ends when no coordinate moves by more than this (radians), after one step more.
constexpr double newton_tolerance = 1e-9;
constexpr int most_newton_steps = 30;
/// A coordinate never moves by more than this in one step (radians): beyond it the linearization means nothing.
constexpr double longest_newton_step = 0.5;
/// Loads grow by this share at a time, and by no less than the other one.
constexpr double first_share = 0.25;
constexpr double least_share = 1.0 / 128.0;

Vec2 turned_back(Vec2 v) { return -turned(v); }

/// The rod with its base at the origin.
Rod at_origin(Rod rod) {
  rod.base = {};
  return rod;
}

/// -dV_c/dq of a rod where its coordinates are 0.
Eigen::VectorXd bent(const Rod& rod, const Chain& chain) {
  Places places(rod, chain, 0);
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(chain.coordinate_count());
  places.move(zero, {});
  Eigen::VectorXd out = zero;
  places.add_energy_row(-1.0, {out.data(), nullptr});
  return out;
}

}  // namespace

HeldRod::HeldRod(const Rod& rod, int order, double turn)
    : basis_(order), chain_(rod, basis_, {}, suggested_nodes(order, turn)), places_(at_origin(rod), chain_, 0) {
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(size());
  for (const Rod::Load& load : rod.loads) {
    if (!load.at_point()) continue;
    int piece = -1;
    while (piece + 1 < chain_.piece_count() && chain_.start(piece + 1, {}) < load.to - knot_merge_distance) ++piece;
    load_place_.push_back(piece < 0 ? -1 : places_.add_knot(piece));
  }
  tip_ = places_.add_tip();
  forces_.on.resize(static_cast<std::size_t>(places_.count()));
  bent_ = bent(rod, chain_);
  rest_.resize(size(), static_cast<Eigen::Index>(rod.segments.size()));
  for (std::size_t i = 0; i < rod.segments.size(); ++i) {
    // The forces are linear in the rest curvature: a difference is their rate.
    Rod other = rod;
    other.segments[i].rest_curvature += 1.0;
    const Chain bent_more(other, basis_, {}, chain_.nodes());
    rest_.col(static_cast<Eigen::Index>(i)) = bent(other, bent_more) - bent_;
  }
  places_.move(zero, {});
  moment_.setZero(size(), static_cast<Eigen::Index>(rod.actuators.size()));
  for (Eigen::Index a = 0; a < moment_.cols(); ++a) {
    places_.pull_back_moment(static_cast<int>(a), 1.0, moment_.col(a).data());
  }
  stiffness_.setZero(size(), size());
  Eigen::MatrixXd none(size(), 0);
  places_.add_energy_second(1.0, nullptr, {stiffness_, none, none.topRows(0)});
  residual_ = zero;
}

void HeldRod::add_bending(const Properties& properties, const Eigen::VectorXd& q, int segment, double factor,
                          Eigen::VectorXd& out) const {
  const int n = chain_.functions();
  for (int j = 0; j < chain_.piece_count(); ++j) {
    if (chain_.piece(j).segment != segment) continue;
    out.segment(j * n, n) +=
        factor * (bent_.segment(j * n, n) - stiffness_.block(j * n, j * n, n, n) * q.segment(j * n, n) +
                  properties.rest_curvature[segment] * rest_.col(segment).segment(j * n, n));
  }
}

void HeldRod::move(const Properties& properties, const Loads& loads, const Eigen::VectorXd& q) {
  places_.move(q, {});
  for (std::size_t i = 0; i < load_place_.size(); ++i) {
    if (load_place_[i] >= 0) forces_.on[static_cast<std::size_t>(load_place_[i])] = loads.at[i];
  }
  forces_.on[static_cast<std::size_t>(tip_)] = loads.tip;
  forces_.gravity = properties.density * loads.gravity;
  forces_.dead = loads.line;
}

const Eigen::VectorXd& HeldRod::residual(const Properties& properties, const Loads& loads, const Eigen::VectorXd& q) {
  move(properties, loads, q);
  residual_.noalias() = moment_ * loads.moments;
  for (int s = 0; s < segments(); ++s) add_bending(properties, q, s, properties.stiffness[s], residual_);
  places_.pull_back(forces_, residual_.data());
  return residual_;
}

bool HeldRod::factor(const Properties& properties) {
  const int n = chain_.functions();
  hessian_.setZero(size(), size());
  Eigen::MatrixXd none(size(), 0);
  places_.second_pull_back(forces_, nullptr, {hessian_, none, none.topRows(0)});
  hessian_ = -hessian_;
  for (int j = 0; j < chain_.piece_count(); ++j) {
    hessian_.block(j * n, j * n, n, n) +=
        properties.stiffness[chain_.piece(j).segment] * stiffness_.block(j * n, j * n, n, n);
  }
  // Positive definite where the equilibrium is stable (model.md section 7): no other one is what was measured.
  factors_.compute(hessian_);
  return factors_.info() == Eigen::Success;
}

bool HeldRod::solve(const Properties& properties, const Loads& loads, Eigen::VectorXd& q) {
  const auto correct = [&](const Eigen::VectorXd& at, Eigen::VectorXd& step) {
    const Eigen::VectorXd& out_of_balance = residual(properties, loads, at);
    if (!out_of_balance.allFinite() || !factor(properties)) return infinity;
    step = factors_.solve(out_of_balance);
    return step.lpNorm<Eigen::Infinity>();
  };
  // The simplified next step tells whether this one helps (natural level function).
  const auto share = [&](const Eigen::VectorXd& at, const Eigen::VectorXd& step, double size) {
    for (double part = std::min(1.0, longest_newton_step / size); part >= 1e-3; part *= 0.5) {
      if (size <= 1e-6) return part;
      const double next = factors_.solve(residual(properties, loads, at + part * step)).lpNorm<Eigen::Infinity>();
      if (std::isfinite(next) && next <= (1.0 - 0.25 * part) * size) return part;
    }
    return 0.0;
  };
  Eigen::VectorXd step;
  return newton(q, step, most_newton_steps, newton_tolerance, correct, share).converged;
}

Eigen::VectorXd HeldRod::unloaded(const Properties& properties) const {
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(size());
  Eigen::VectorXd forces = zero;
  for (int s = 0; s < segments(); ++s) add_bending(properties, zero, s, 1.0, forces);
  return stiffness_.llt().solve(forces);
}

bool HeldRod::load_up(const Properties& properties, const Loads& loads, Eigen::VectorXd& q) {
  q = unloaded(properties);
  double reached = 0.0;
  for (double share = first_share; reached < 1.0;) {
    const double next = std::min(1.0, reached + share);
    Loads part = loads;
    part.moments *= next;
    part.gravity = next * loads.gravity;
    part.line = next * loads.line;
    const auto scale = [next](Push& push) { push = {next * push.force, next * push.moment}; };
    for (Push& push : part.at) scale(push);
    scale(part.tip);
    Eigen::VectorXd trial = q;
    if (solve(properties, part, trial)) {
      q = std::move(trial);
      reached = next;
    } else if ((share *= 0.5) < least_share) {
      return false;
    }
  }
  return true;
}

bool HeldRod::stand(const Properties& properties, const Loads& loads, const Eigen::VectorXd& q) {
  move(properties, loads, q);
  q_ = q;
  properties_ = properties;
  return factor(properties);
}

Eigen::VectorXd HeldRod::by_stiffness(int segment) const {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(size());
  add_bending(properties_, q_, segment, 1.0, out);
  return out;
}

Eigen::VectorXd HeldRod::by_rest_curvature(int segment) const {
  return properties_.stiffness[segment] * rest_.col(segment);
}

Eigen::VectorXd HeldRod::by_density() {
  Forces weight;
  weight.gravity = (1.0 / properties_.density) * forces_.gravity;
  Eigen::VectorXd out = Eigen::VectorXd::Zero(size());
  places_.pull_back(weight, out.data());
  return out;
}

/// Seen from the base, all fixed forces turn back.
Eigen::VectorXd HeldRod::by_base_angle() {
  Forces turning = forces_;
  for (Push& push : turning.on) push = {turned_back(push.force)};
  turning.gravity = turned_back(forces_.gravity);
  turning.dead = 0.0;
  Eigen::VectorXd out = Eigen::VectorXd::Zero(size());
  places_.pull_back(turning, out.data());
  return out;
}

}  // namespace tendril
