// The local balance of moments, EI (kappa - kappa0) = moments of actuators and of everything beyond, which an
// equilibrium in a basis keeps on the average only: what is left of it measures the basis (model.md section 7).

#include <algorithm>
#include <cmath>

#include "rod/curve.hpp"
#include "rod/sweep.hpp"

namespace tendril {

double Places::moment_defect(const Forces& forces, std::span<const double> moments, const Curve& curve) {
  Sweep sweep(*this, forces);
  double beyond = 0.0;
  double worst = 0.0;
  for (int j = chain_->piece_count() - 1; j >= 0; --j) {
    sweep.enter(j);
    worst = std::max(worst, moment_defect(j, sweep.load(j), forces, moments, curve, beyond));
    sweep.leave(j);
  }
  return worst;
}

/// The same of piece j; `beyond`: the moment of all forces behind its end about that, afterwards about its start.
double Places::moment_defect(int j, const Ramp& load, const Forces& forces, std::span<const double> moments,
                             const Curve& curve, double& beyond) {
  const Chain::Piece& p = chain_->piece(j);
  const BasisTable& table = chain_->table();
  const CurveTables& tables = *chain_->curve_tables();
  const int n = tables.per_interval();
  const double h = backbone_.length(j);
  const Eigen::Map<const Eigen::VectorXd> q(backbone_.coordinates(j), table.functions);
  const Rod::Segment* varying = p.bends_evenly ? nullptr : &chain_->segment(j);
  const auto applied = [&](double s) {
    double sum = varying != nullptr ? 0.0 : p.stiffness * p.rest_curvature;
    for (int a = 0; a < chain_->actuator_count(); ++a) {
      const ProfilePart* part = chain_->varying(a, j);
      const double profile = part != nullptr ? part->at(s) : chain_->level(a, j);
      if (profile != 0.0) sum += profile * moments[static_cast<std::size_t>(a)];
    }
    return sum;
  };
  /// Force times length on the piece from what is behind it and from its weight.
  const auto loaded = [&](double sigma, double left) {
    Vec2 force = load.end + left * load.slope;
    if (load.share == nullptr) return force;
    const Rod::Segment& heavy = chain_->segment(j);
    const double rest = heavy.weight_up_to(backbone_.start(j) + h) - heavy.weight_up_to(backbone_.start(j) + sigma * h);
    return force + h * rest * load.heavy;
  };
  const auto acts = [&](int k) { return at(k).piece == j && static_cast<std::size_t>(k) < forces.on.size(); };
  double worst = 0.0;
  const auto check = [&](double sigma, double curvature, double moment) {
    // A force inside the piece ends there, where no series over its nodes follows it: force times arm does.
    for (const int k : inside_) {
      if (!acts(k) || !(moving_[own(k)].sigma() > sigma)) continue;
      moment += cross(at(k).point - curve.position(j, sigma), on(k, forces).force);
    }
    const double s = backbone_.start(j) + sigma * h;
    double stiffness = p.stiffness;
    if (varying != nullptr) {
      stiffness = varying->stiffness_at(s).value;
      curvature -= varying->rest_curvature_at(s).value;
    }
    worst = std::max(worst, std::abs(stiffness * curvature - applied(s) - moment));
  };
  for (const int k : knots_) {
    if (acts(k)) beyond += on(k, forces).moment;
  }
  check(1.0, table.slope_end.dot(q) / h, beyond);
  auto shear = node_buffer_.head(n);
  auto coefficients = push_along_.head(n);
  auto up_to = push_across_.head(n);
  for (int i = tables.intervals() - 1; i >= 0; --i) {
    const double width = tables.end(i + 1) - tables.end(i);
    for (int g = 0; g < n; ++g) {
      shear[g] = cross(backbone_.tangent(j, i * n + g), loaded(table.sigma[i * n + g], left_[i * n + g]));
    }
    coefficients.noalias() = tables.transform() * shear;
    up_to.noalias() = 0.5 * width * (tables.cumulative() * coefficients);
    beyond += width * coefficients[0];
    for (int g = 0; g < n; ++g) {
      check(table.sigma[i * n + g], table.slope.row(i * n + g).dot(q) / h, beyond - up_to[g]);
    }
  }
  check(0.0, table.slope_start.dot(q) / h, beyond);
  const double at_start = beyond;
  for (const int k : inside_) {
    if (!acts(k)) continue;
    // The defect of a basis peaks where it cannot kink.
    const MovingPoint& m = moving_[own(k)];
    double moment = at_start;
    for (int i = 0; i < m.node_count(); ++i) {
      moment -= m.weight(i) * cross(m.node_tangent(i), loaded(m.node_sigma(i), 1.0 - m.node_sigma(i)));
    }
    check(m.sigma(), m.curvature(), moment);
    beyond += cross(at(k).point - backbone_.knot_point(j), on(k, forces).force);
  }
  return worst;
}

}  // namespace tendril
