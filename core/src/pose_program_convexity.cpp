#include <cmath>

#include "pose_program_data.hpp"

namespace tendril {

PoseProgram::Data::Side PoseProgram::Data::convex_side(int contact) const {
  const auto k = static_cast<std::size_t>(contact);
  const BasisTable& table = chain.table();
  const auto at_end = [&](int j) {
    const Eigen::Map<const Eigen::VectorXd> q(backbone.coordinates(j), n);
    return Side{j, Side::end, table.slope_end.dot(q) / length(j)};
  };
  const auto at_start = [&](int j) {
    const Eigen::Map<const Eigen::VectorXd> q(backbone.coordinates(j), n);
    return Side{j, Side::start, table.slope_start.dot(q) / length(j)};
  };
  const double turn = dot(turned(contacts[k].tangent), contacts[k].surface.normal);
  Side best;
  const auto consider = [&](const Side& side) {
    if (side.curvature * turn > best.curvature * turn) best = side;
  };
  const int j = contact_piece[k];
  if (contact_moving[k] < 0) {
    // The curvature jumps only by what the basis cannot follow; the larger value decides (model.md section 7).
    best = at_end(j);
    if (j + 1 < pieces) consider(at_start(j + 1));
    return best;
  }
  const MovingPoint& m = moving[static_cast<std::size_t>(contact_moving[k])];
  best = {j, Side::inside, m.curvature()};
  if (m.sigma() <= 0.0 && j > 0) consider(at_end(j - 1));
  if (m.sigma() >= 1.0 && j + 1 < pieces) consider(at_start(j + 1));
  return best;
}

double PoseProgram::contact_convexity(int contact) const {
  const Data& d = *data_;
  const auto k = static_cast<std::size_t>(contact);
  if (d.spec.contacts[k].at_tip) return infinity;
  const ContactState& c = d.contacts[k];
  const double turn = dot(turned(c.tangent), c.surface.normal);
  const double along = dot(turned(c.surface.normal), c.tangent);
  return d.convex_side(contact).curvature * turn + c.surface.curvature * along * along;
}

double PoseProgram::contact_convexity(int contact, VectorRef gradient) const {
  const Data& d = *data_;
  const auto k = static_cast<std::size_t>(contact);
  const ContactState& c = d.contacts[k];
  const Vec2 n = c.surface.normal;
  const Vec2 tau = turned(n);
  const Vec2 normal = turned(c.tangent);
  const double curvature = c.surface.curvature;
  const double turn = dot(normal, n);
  const double along = dot(tau, c.tangent);
  const double slope = dot(c.tangent, n);
  const Data::Side side = d.convex_side(contact);

  // By the point's motion across and along the obstacle, and by its angle: dn = k tau (tau . dP), dk = -k^2 (n . dP) +
  // k_tau (tau . dP).
  const double by_across = -curvature * curvature * along * along;
  const double by_along = side.curvature * curvature * dot(normal, tau) + c.surface.curvature_rate * along * along -
                          2.0 * curvature * curvature * along * slope;
  const double by_angle = -side.curvature * slope + 2.0 * curvature * along * dot(tau, normal);
  const BaseIndex::Point& p = d.index.contacts[k].point;
  const Vec2 by_point = by_across * n + by_along * tau;
  gradient = by_point.x * d.rows.row(p.x).transpose() + by_point.y * d.rows.row(p.y).transpose() +
             by_angle * d.rows.row(p.angle).transpose();

  // By the rod's curvature.
  const double h = d.length(side.piece);
  const int first = side.piece * d.n;
  const BasisTable& table = d.chain.table();
  if (side.place == Data::Side::inside) {
    const MovingPoint& m = d.moving[static_cast<std::size_t>(d.contact_moving[k])];
    for (int i = 0; i < d.n; ++i) gradient[first + i] += turn * m.beta1()[i] / h;
    gradient[arc_length_variable(contact)] += turn * m.bend() / (h * h);
    return side.curvature * turn + curvature * along * along;
  }
  gradient.segment(first, d.n) += turn / h * (side.place == Data::Side::end ? table.slope_end : table.slope_start);
  for (int l = 0; l < d.s_count; ++l) {
    gradient[d.layout.first_arc_length + l] -= turn * side.curvature / h * d.length_rate(side.piece, l);
  }
  return side.curvature * turn + curvature * along * along;
}

}  // namespace tendril
