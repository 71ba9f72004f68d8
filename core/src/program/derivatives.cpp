// First derivatives of what pose_program_values.cpp computes.

#include <algorithm>
#include <cmath>
#include <span>

#include "program/pose_program_data.hpp"

namespace tendril {

double PoseProgram::Data::own_rate(const MovingPoint& m, int variable, int l) const {
  // d(h sigma)/ds_l minus sigma dh/ds_l: how fast the point runs along its piece.
  return (variable == l ? 1.0 : 0.0) - start_rate(m.piece(), l) - m.sigma() * length_rate(m.piece(), l);
}

void PoseProgram::Data::point_row_of_moving(const MovingPoint& m, int variable, double* x, double* y, double* angle,
                                            double* curvature) {
  const int j = m.piece();
  const double h = length(j);
  const double* end = chain.table().end.data();
  backbone.row_before(j, m.position(), {1.0, 0.0}, x);
  backbone.row_before(j, m.position(), {0.0, 1.0}, y);
  m.own_rows(x + j * n, y + j * n);
  for (int i = 0; i < j * n; ++i) angle[i] = end[i % n];
  for (int i = 0; i < n; ++i) angle[j * n + i] = m.beta()[i];
  if (curvature != nullptr) {
    for (int i = 0; i < n; ++i) curvature[j * n + i] = m.beta1()[i] / h;
  }
  for (int l = 0; l < s_count; ++l) {
    Vec2 rate = length_rate(j, l) * m.chord() + own_rate(m, variable, l) * m.tangent();
    for (int i = 0; i < j; ++i) rate += length_rate(i, l) * backbone.chord(i);
    const double sigma_rate = own_rate(m, variable, l) / h;
    x[layout.first_arc_length + l] = rate.x;
    y[layout.first_arc_length + l] = rate.y;
    angle[layout.first_arc_length + l] = m.slope() * sigma_rate;
    if (curvature != nullptr) {
      curvature[layout.first_arc_length + l] = (m.bend() * sigma_rate - m.slope() * length_rate(j, l) / h) / h;
    }
  }
}

void PoseProgram::Data::base_rows() {
  const auto row = [this](int i) { return rows.row(i).data(); };
  const double* end = chain.table().end.data();
  const auto knot_point_rows = [&](int j, const BaseIndex::Point& p) {
    backbone.point_rows(j, row(p.x), row(p.y));
    double* angle = row(p.angle);
    for (int i = 0; i <= j; ++i) std::copy_n(end, n, angle + i * n);
    for (int l = 0; l < s_count; ++l) {
      Vec2 rate{};
      for (int i = 0; i <= j; ++i) rate += length_rate(i, l) * backbone.chord(i);
      row(p.x)[layout.first_arc_length + l] = rate.x;
      row(p.y)[layout.first_arc_length + l] = rate.y;
    }
  };
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const BaseIndex::Point& p = index.contacts[k].point;
    if (contact_moving[k] < 0) {
      knot_point_rows(contact_piece[k], p);
    } else {
      const auto m = static_cast<std::size_t>(contact_moving[k]);
      point_row_of_moving(moving[m], moving_variable[m], row(p.x), row(p.y), row(p.angle), nullptr);
    }
  }
  if (index.tip.x >= 0) knot_point_rows(pieces - 1, index.tip);
  const std::size_t first_sample = moving.size() - index.samples.size();
  for (std::size_t i = 0; i < index.samples.size(); ++i) {
    // The piece that holds a fixed arc length may change when knots move.
    const BaseIndex::Point& p = index.samples[i];
    for (const int r : {p.x, p.y, p.angle, p.curvature}) rows.row(r).setZero();
    point_row_of_moving(moving[first_sample + i], -1, row(p.x), row(p.y), row(p.angle), row(p.curvature));
  }
  if (index.energy >= 0) {
    const BasisTable& table = chain.table();
    double* energy = row(index.energy);
    for (int l = 0; l < s_count; ++l) energy[layout.first_arc_length + l] = 0.0;
    for (int j = 0; j < pieces; ++j) {
      const Chain::Piece& p = chain.piece(j);
      const Eigen::Map<const Eigen::VectorXd> q(backbone.coordinates(j), n);
      const double h = length(j);
      double bend = 0.0;
      for (int i = 0; i < n; ++i) {
        const double kq = table.stiffness.col(i).dot(q);
        bend += q[i] * kq;
        energy[j * n + i] = p.stiffness * (kq / h - p.rest_curvature * end[i]);
      }
      const double along = 0.5 * p.stiffness * (p.rest_curvature * p.rest_curvature - bend / (h * h));
      for (int l = 0; l < s_count; ++l) energy[layout.first_arc_length + l] += along * length_rate(j, l);
    }
  }
}

void PoseProgram::Data::mark_palm_column() {
  if (layout.palm < 0) return;
  const auto mark = [this](const BaseIndex::Point& p) {
    rows(p.x, layout.palm) = -spec.palm->axis.x;
    rows(p.y, layout.palm) = -spec.palm->axis.y;
  };
  for (const BaseIndex::Contact& contact : index.contacts) mark(contact.point);
  if (index.tip.x >= 0) mark(index.tip);
  for (const BaseIndex::Point& sample : index.samples) mark(sample);
}

void PoseProgram::Data::equilibrium_jacobian(ConstVectorRef x, Eigen::MatrixXd& jacobian) {
  (void)x;
  const BasisTable& table = chain.table();
  const double* weight = table.weight.data();
  const Vec2 g = loads.gravity;
  jacobian.topRows(q_count).setZero();

  // Turning of the transmitted force with the shape.
  gram_sums.set_zero();
  for (std::size_t l = 0; l < rate_sums.size(); ++l) rate_sums[l].set_zero();
  for (int j = 0; j < pieces; ++j) {
    const double h = length(j);
    const double* tangent = force_tangent.col(j).data();
    double* z = node_buffer.data();
    for (int i = 0; i < nodes; ++i) z[i] = -h * weight[i] * tangent[i];
    backbone.add_gram_nodes(gram_sums, j, z);
    const double* c = backbone.cosines(j);
    const double* s = backbone.sines(j);
    for (int l = 0; l < s_count; ++l) {
      const double rate = length_rate(j, l);
      const double mass = rate * mass_beyond[j] + h * mass_rate(j, l);
      if (rate == 0.0 && mass == 0.0) continue;
      const double own = 2.0 * chain.piece(j).weight * h * rate;
      const double fx0 = rate * force(0, j) + mass * g.x;
      const double fy0 = rate * force(1, j) + mass * g.y;
      for (int i = 0; i < nodes; ++i) {
        const double m = own * (1.0 - table.sigma[i]);
        z[i] = weight[i] * ((fy0 + m * g.y) * c[i] - (fx0 + m * g.x) * s[i]);
      }
      backbone.add_nodes(rate_sums[static_cast<std::size_t>(l)], j, z);
    }
  }
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    if (contact_moving[k] < 0) continue;
    const MovingPoint& m = moving[static_cast<std::size_t>(contact_moving[k])];
    const Vec2 f = contacts[k].force * contacts[k].surface.normal;
    for (int i = 0; i < m.node_count(); ++i) {
      gram_sums.add_gram_point(m.piece(), -length(m.piece()) * m.weight(i) * dot(f, m.node_tangent(i)), m.node_beta(i));
    }
    // An unsplit rod has no moving knots: only the contact itself runs along its piece.
    rate_sums[k].add_point(m.piece(), dot(f, m.normal()), m.beta());
  }
  backbone.spread_gram(gram_sums, jacobian.topLeftCorner(q_count, q_count));
  for (int l = 0; l < s_count; ++l) {
    backbone.spread(rate_sums[static_cast<std::size_t>(l)], jacobian.col(layout.first_arc_length + l).data());
  }

  for (int j = 0; j < pieces; ++j) {
    const Chain::Piece& p = chain.piece(j);
    const double h = length(j);
    const double* q = backbone.coordinates(j);
    const double stiffness = p.stiffness / h;
    for (int k = 0; k < n; ++k) {
      const double* column = table.stiffness.col(k).data();
      double* out = jacobian.col(j * n + k).data() + j * n;
      double sum = 0.0;
      for (int i = 0; i < n; ++i) {
        out[i] -= stiffness * column[i];
        sum += column[i] * q[i];
      }
      for (int l = 0; l < s_count; ++l) {
        jacobian(j * n + k, layout.first_arc_length + l) += stiffness / h * length_rate(j, l) * sum;
      }
    }
    for (std::size_t a = 0; a < moment_variable.size(); ++a) {
      if (moment_variable[a] < 0 || !chain.actuated(static_cast<int>(a), j)) continue;
      for (int i = 0; i < n; ++i) jacobian(j * n + i, moment_variable[a]) = table.end[i];
    }
  }

  // Contact forces act along normals that turn with the contact point.
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const ContactState& c = contacts[k];
    const BaseIndex::Point& p = index.contacts[k].point;
    const Vec2 normal = c.surface.normal;
    const Vec2 tau = turned(normal);
    const double* rx = rows.row(p.x).data();
    const double* ry = rows.row(p.y).data();
    double* along = row_buffer.data();
    for (int i = 0; i < x_count; ++i) along[i] = tau.x * rx[i] + tau.y * ry[i];
    double* by_force = jacobian.col(layout.first_force + static_cast<Eigen::Index>(k)).data();
    for (int i = 0; i < q_count; ++i) by_force[i] = normal.x * rx[i] + normal.y * ry[i];
    // Along a surface it is that which bends the normal, else the rod itself turns it.
    const bool turns_with_rod = spec.contacts[k].obstacle < 0;
    const double* turning = turns_with_rod ? rows.row(p.angle).data() : along;
    const double factor = turns_with_rod ? c.force : c.force * c.surface.curvature;
    if (factor == 0.0) continue;
    for (int column = 0; column < x_count; ++column) {
      const double scaled = factor * turning[column];
      if (scaled == 0.0) continue;
      double* out = jacobian.col(column).data();
      for (int i = 0; i < q_count; ++i) out[i] += scaled * along[i];
    }
  }
}

void PoseProgram::Data::contact_jacobian(Eigen::MatrixXd& jacobian) {
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const ContactState& c = contacts[k];
    const BaseIndex::Point& p = index.contacts[k].point;
    const Vec2 normal = c.surface.normal;
    const Vec2 tau = turned(normal);
    const double turn = dot(turned(c.tangent), normal);
    const double bend = c.surface.curvature * dot(tau, c.tangent);
    const double* rx = rows.row(p.x).data();
    const double* ry = rows.row(p.y).data();
    const double* ra = rows.row(p.angle).data();
    const Eigen::Index gap = layout.first_gap + static_cast<Eigen::Index>(k);
    const Eigen::Index closest = layout.first_closest + static_cast<Eigen::Index>(k);
    for (int i = 0; i < x_count; ++i) {
      jacobian(gap, i) = normal.x * rx[i] + normal.y * ry[i];
      jacobian(closest, i) = turn * ra[i] + bend * (tau.x * rx[i] + tau.y * ry[i]);
    }
  }
  int order = layout.first_order;
  for (int k = 0; k + 1 < s_count; ++k) {
    if (spec.contacts[static_cast<std::size_t>(k)].region != spec.contacts[static_cast<std::size_t>(k) + 1].region)
      continue;
    jacobian(order, layout.first_arc_length + k) = -1.0;
    jacobian(order++, layout.first_arc_length + k + 1) = 1.0;
  }
}

void PoseProgram::Data::balance_jacobian(Eigen::MatrixXd& jacobian) const {
  if (layout.balances == 0) return;
  jacobian.row(layout.first_balance).setZero();
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const ContactState& c = contacts[k];
    const BaseIndex::Point& p = index.contacts[k].point;
    const Vec2 tau = turned(c.surface.normal);
    const double turning = c.force * c.surface.curvature * dot(tau, spec.palm->axis);
    jacobian.row(layout.first_balance) += turning * (tau.x * rows.row(p.x) + tau.y * rows.row(p.y));
    jacobian(layout.first_balance, layout.first_force + static_cast<Eigen::Index>(k)) +=
        dot(c.surface.normal, spec.palm->axis);
  }
}

void PoseProgram::Data::check_row(int j, const CheckStations& at, std::size_t use, Vec2 direction, double* row,
                                  double* others) const {
  const auto check = static_cast<std::size_t>(at.rows[use]);
  const Vec2 point = check_point[check];
  backbone.row_before(j, point, direction, row);
  const double h = length(j);
  const double dx = h * direction.x;
  const double dy = h * direction.y;
  const double* sum = at.turned.col(at.station[use]).data();
  double* own = row + j * n;
  for (int i = 0; i < n; ++i) own[i] = dx * sum[i] + dy * sum[n + i];
  for (int l = 0; l < s_count; ++l) {
    Vec2 rate = length_rate(j, l) / h * (point - backbone.knot_point(j));
    for (int i = 0; i < j; ++i) rate += length_rate(i, l) * backbone.chord(i);
    others[l] = dot(direction, rate);
  }
  if (layout.palm >= 0) others[s_count] = carried(spec.checks[check].obstacle) ? 0.0 : -dot(direction, spec.palm->axis);
}

void PoseProgram::Data::check_jacobian(Eigen::MatrixXd& jacobian) {
  for (int j = 0; j < pieces; ++j) {
    CheckStations& at = stations[static_cast<std::size_t>(j)];
    at.turned.setZero();
    const auto stride = static_cast<int>(at.by_node.rows());
    for (int i = 0; i < stride; ++i) backbone.add_turned(j, at.by_node.data() + i, stride, at.turned.col(i).data());
    for (std::size_t use = 0; use < at.rows.size(); ++use) {
      const auto check = static_cast<std::size_t>(at.rows[use]);
      double* row = row_buffer.data();
      double* others = vector_buffer.data();
      check_row(j, at, use, check_surface[check].normal, row, others);
      const Eigen::Index r = layout.first_check + at.rows[use];
      const int active = (j + 1) * n;
      for (int i = 0; i < active; ++i) jacobian(r, i) = row[i];
      for (int l = 0; l < s_count; ++l) jacobian(r, layout.first_arc_length + l) = others[l];
      if (layout.palm >= 0) jacobian(r, layout.palm) = others[s_count];
    }
  }
}

}  // namespace tendril
