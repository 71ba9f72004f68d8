#include <cmath>

#include "program/pose_program_data.hpp"

namespace tendril {

PoseProgram::Data::Side PoseProgram::Data::side_of(int contact, int which) const {
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
  const int j = contact_piece[k];
  if (contact_moving[k] < 0) return which == 0 || j + 1 == pieces ? at_end(j) : at_start(j + 1);
  const MovingPoint& m = moving[static_cast<std::size_t>(contact_moving[k])];
  if (which == 0 && m.sigma() <= 0.0 && j > 0) return at_end(j - 1);
  if (which == 1 && m.sigma() >= 1.0 && j + 1 < pieces) return at_start(j + 1);
  return {j, Side::inside, m.curvature()};
}

PoseProgram::Data::Side PoseProgram::Data::convex_side(int contact) const {
  const auto k = static_cast<std::size_t>(contact);
  // The curvature jumps only by what the basis cannot follow; the larger value decides (model.md section 7).
  const double turn = dot(turned(contacts[k].tangent), contacts[k].surface.normal);
  const Side before = side_of(contact, 0);
  const Side behind = side_of(contact, 1);
  return behind.curvature * turn > before.curvature * turn ? behind : before;
}

double PoseProgram::Data::convexity(int contact, const Side& side) const {
  const ContactState& c = contacts[static_cast<std::size_t>(contact)];
  const double along = dot(turned(c.surface.normal), c.tangent);
  return side.curvature * dot(turned(c.tangent), c.surface.normal) + c.surface.curvature * along * along;
}

void PoseProgram::Data::convexity_gradient(int contact, const Side& side, VectorRef gradient) const {
  const auto k = static_cast<std::size_t>(contact);
  const ContactState& c = contacts[k];
  const Vec2 normal_out = c.surface.normal;
  const Vec2 tau = turned(normal_out);
  const Vec2 normal = turned(c.tangent);
  const double curvature = c.surface.curvature;
  const double turn = dot(normal, normal_out);
  const double along = dot(tau, c.tangent);
  const double slope = dot(c.tangent, normal_out);

  // By the point's motion across and along the obstacle, and by its angle: dn = k tau (tau . dP), dk = -k^2 (n . dP) +
  // k_tau (tau . dP).
  const double by_across = -curvature * curvature * along * along;
  const double by_along = side.curvature * curvature * dot(normal, tau) + c.surface.curvature_rate * along * along -
                          2.0 * curvature * curvature * along * slope;
  const double by_angle = -side.curvature * slope + 2.0 * curvature * along * dot(tau, normal);
  const BaseIndex::Point& p = index.contacts[k].point;
  const Vec2 by_point = by_across * normal_out + by_along * tau;
  gradient = by_point.x * rows.row(p.x).transpose() + by_point.y * rows.row(p.y).transpose() +
             by_angle * rows.row(p.angle).transpose();

  // By the rod's curvature.
  const double h = length(side.piece);
  const int first = side.piece * n;
  if (side.place == Side::inside) {
    const MovingPoint& m = moving[static_cast<std::size_t>(contact_moving[k])];
    for (int i = 0; i < n; ++i) gradient[first + i] += turn * m.beta1()[i] / h;
    gradient[layout.first_arc_length + contact] += turn * m.bend() / (h * h);
    return;
  }
  gradient.segment(first, n) +=
      turn / h * (side.place == Side::end ? chain.table().slope_end : chain.table().slope_start);
  for (int l = 0; l < s_count; ++l) {
    gradient[layout.first_arc_length + l] -= turn * side.curvature / h * length_rate(side.piece, l);
  }
}

void PoseProgram::Data::convexity_rows(ConstVectorRef x, bool derivatives, Workspace& out) {
  for (int k = 0; k < s_count; ++k) {
    for (int which = 0; which < 2; ++which) {
      const Side side = side_of(k, which);
      const int i = 2 * k + which;
      const int row = layout.first_convexity + i;
      out.constraints[row] = convexity(k, side);
      if (!derivatives) continue;
      convexity_gradient(k, side, row_buffer);
      out.jacobian.row(row) = row_buffer.transpose();
      convex[static_cast<std::size_t>(i)].learn(x, row_buffer);
    }
  }
}

double PoseProgram::contact_convexity(int contact) const {
  const Data& d = *data_;
  if (d.spec.contacts[static_cast<std::size_t>(contact)].at_tip) return infinity;
  return d.convexity(contact, d.convex_side(contact));
}

double PoseProgram::contact_convexity(int contact, VectorRef gradient) const {
  const Data& d = *data_;
  const Data::Side side = d.convex_side(contact);
  d.convexity_gradient(contact, side, gradient);
  return d.convexity(contact, side);
}

}  // namespace tendril
