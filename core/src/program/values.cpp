// A pose program's shape, forces, rows and base quantities at a point.

#include <algorithm>
#include <cmath>
#include <span>

#include "program/pose_program_data.hpp"
#include "rod/kernels.hpp"

namespace tendril {

void PoseProgram::Data::evaluate_shape(ConstVectorRef x) {
  const double* s = x.data() + layout.first_arc_length;
  const std::span<const double> knots(s, spec.split ? static_cast<std::size_t>(s_count) : 0);
  if (spec.palm) {
    shift = -(layout.palm >= 0 ? x[layout.palm] : spec.palm->minimum) * spec.palm->axis;
    backbone.place(spec.rod->base + shift);
  }
  backbone.move(x.head(q_count), knots);
  for (std::size_t i = 0; i < moving.size(); ++i) {
    const int variable = moving_variable[i];
    if (variable >= 0) {
      moving[i].move(backbone, contact_piece[static_cast<std::size_t>(variable)], s[variable]);
    } else {
      const double at = moving_arc_length[i];
      int j = 0;
      while (j + 1 < pieces && at > backbone.start(j + 1)) ++j;
      moving[i].move(backbone, j, at);
    }
  }
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    ContactState& c = contacts[k];
    const auto variable = static_cast<int>(k);
    c.force = x[layout.first_force + variable];
    if (contact_moving[k] >= 0) {
      const MovingPoint& m = moving[static_cast<std::size_t>(contact_moving[k])];
      c.point = m.position();
      c.angle = m.angle();
      c.tangent = m.tangent();
      c.arc_length = s[variable];
    } else {
      c.point = backbone.knot_point(contact_piece[k] + 1);
      c.angle = backbone.knot_angle(contact_piece[k] + 1);
      c.tangent = {std::cos(c.angle), std::sin(c.angle)};
      c.arc_length = spec.contacts[k].at_tip ? 1.0 : s[variable];
    }
    const int obstacle = spec.contacts[k].obstacle;
    if (obstacle < 0) {
      c.surface = {0.0, turned(c.tangent)};
    } else {
      c.surface = spec.obstacles[static_cast<std::size_t>(obstacle)]->at(c.point);
      c.surface.distance += loads.shrink[static_cast<std::size_t>(obstacle)];
    }
    values.surfaces[k] = c.surface;
  }
  for (int j = 0; j < pieces; ++j) {
    CheckStations& at = stations[static_cast<std::size_t>(j)];
    const auto count = static_cast<int>(at.sigma.size());
    if (count == 0) continue;
    at.chord_x.setZero();
    at.chord_y.setZero();
    kernels::add_weighted_columns(count, count, nodes, at.by_node.data(), backbone.cosines(j), 1, at.chord_x.data());
    kernels::add_weighted_columns(count, count, nodes, at.by_node.data(), backbone.sines(j), 1, at.chord_y.data());
    const Vec2 start = backbone.knot_point(j);
    const double h = length(j);
    for (std::size_t use = 0; use < at.rows.size(); ++use) {
      const int i = at.station[use];
      const auto row = static_cast<std::size_t>(at.rows[use]);
      check_point[row] = start + h * Vec2{at.chord_x[i], at.chord_y[i]};
      const int obstacle = spec.checks[row].obstacle;
      const Vec2 seen = carried(obstacle) ? check_point[row] - shift : check_point[row];
      check_surface[row] = spec.obstacles[static_cast<std::size_t>(obstacle)]->at(seen);
      check_surface[row].distance += loads.shrink[static_cast<std::size_t>(obstacle)];
    }
  }
}

void PoseProgram::Data::evaluate_forces(ConstVectorRef x) {
  const BasisTable& table = chain.table();
  const double* weight = table.weight.data();
  const double* sigma = table.sigma.data();
  const Vec2 g = loads.gravity;
  Vec2 transmitted = loads.tip_force;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    if (spec.contacts[k].at_tip) transmitted += contacts[k].force * contacts[k].surface.normal;
  }
  double mass = spec.rod->payload;
  sums.set_zero();
  for (int j = pieces - 1; j >= 0; --j) {
    const double h = length(j);
    for (std::size_t k = 0; k < contacts.size(); ++k) {
      if (!spec.contacts[k].at_tip && contact_moving[k] < 0 && contact_piece[k] == j) {
        transmitted += contacts[k].force * contacts[k].surface.normal;
      }
    }
    force(0, j) = transmitted.x;
    force(1, j) = transmitted.y;
    mass_beyond[j] = mass;
    const double own = chain.piece(j).weight * h;
    const double* c = backbone.cosines(j);
    const double* s = backbone.sines(j);
    double* normal = force_normal.col(j).data();
    double* tangent = force_tangent.col(j).data();
    double* z = node_buffer.data();
    if (gravity) {
      for (int i = 0; i < nodes; ++i) {
        const double m = mass + own * (1.0 - sigma[i]);
        const double fx = transmitted.x + m * g.x;
        const double fy = transmitted.y + m * g.y;
        normal[i] = fy * c[i] - fx * s[i];
        tangent[i] = fx * c[i] + fy * s[i];
        z[i] = h * weight[i] * normal[i];
      }
      backbone.add_nodes(sums, j, z);
    } else if (transmitted.x != 0.0 || transmitted.y != 0.0) {
      for (int i = 0; i < nodes; ++i) {
        normal[i] = transmitted.y * c[i] - transmitted.x * s[i];
        tangent[i] = transmitted.x * c[i] + transmitted.y * s[i];
        z[i] = h * weight[i] * normal[i];
      }
      backbone.add_nodes(sums, j, z);
    } else {
      std::fill_n(normal, nodes, 0.0);
      std::fill_n(tangent, nodes, 0.0);
    }
    mass += own;
    for (std::size_t k = 0; k < contacts.size(); ++k) {
      if (contact_moving[k] < 0 || contact_piece[k] != j) continue;
      const MovingPoint& m = moving[static_cast<std::size_t>(contact_moving[k])];
      const Vec2 f = contacts[k].force * contacts[k].surface.normal;
      for (int i = 0; i < m.node_count(); ++i) {
        sums.add_point(j, h * m.weight(i) * dot(f, turned(m.node_tangent(i))), m.node_beta(i));
      }
      transmitted += f;
    }
  }
  (void)x;
}

void PoseProgram::Data::evaluate_rows(ConstVectorRef x, Eigen::VectorXd& c) {
  const BasisTable& table = chain.table();
  c.head(q_count).setZero();
  backbone.spread(sums, c.data());
  for (int j = 0; j < pieces; ++j) {
    const Chain::Piece& p = chain.piece(j);
    const double* q = backbone.coordinates(j);
    double bend = p.stiffness * p.rest_curvature;
    for (std::size_t a = 0; a < moment_variable.size(); ++a) {
      if (moment_variable[a] >= 0 && chain.actuated(static_cast<int>(a), j)) bend += x[moment_variable[a]];
    }
    const double stiffness = p.stiffness / length(j);
    double* out = c.data() + j * n;
    for (int i = 0; i < n; ++i) {
      double sum = 0.0;
      const double* k = table.stiffness.col(i).data();
      for (int m = 0; m < n; ++m) sum += k[m] * q[m];
      out[i] += bend * table.end[i] - stiffness * sum;
    }
  }
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    c[layout.first_gap + i] = contacts[k].surface.distance;
    c[layout.first_closest + i] = dot(contacts[k].tangent, contacts[k].surface.normal);
  }
  for (std::size_t i = 0; i < check_surface.size(); ++i) {
    c[layout.first_check + static_cast<Eigen::Index>(i)] = check_surface[i].distance;
  }
  int order = layout.first_order;
  for (int k = 0; k + 1 < s_count; ++k) {
    if (spec.contacts[static_cast<std::size_t>(k)].region != spec.contacts[static_cast<std::size_t>(k) + 1].region)
      continue;
    c[order++] = x[layout.first_arc_length + k + 1] - x[layout.first_arc_length + k];
  }
  if (layout.balances > 0) {
    double sum = 0.0;
    for (const ContactState& contact : contacts) sum += contact.force * dot(contact.surface.normal, spec.palm->axis);
    c[layout.first_balance] = sum;
  }
}

void PoseProgram::Data::fill_base(ConstVectorRef x) {
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const BaseIndex::Point& p = index.contacts[k].point;
    values.base[p.x] = contacts[k].point.x;
    values.base[p.y] = contacts[k].point.y;
    values.base[p.angle] = contacts[k].angle;
  }
  if (index.tip.x >= 0) {
    values.base[index.tip.x] = backbone.tip().x;
    values.base[index.tip.y] = backbone.tip().y;
    values.base[index.tip.angle] = backbone.tip_angle();
  }
  const std::size_t first_sample = moving.size() - index.samples.size();
  for (std::size_t i = 0; i < index.samples.size(); ++i) {
    const MovingPoint& m = moving[first_sample + i];
    values.base[index.samples[i].x] = m.position().x;
    values.base[index.samples[i].y] = m.position().y;
    values.base[index.samples[i].angle] = m.angle();
    values.base[index.samples[i].curvature] = m.curvature();
  }
  if (index.energy >= 0) {
    const BasisTable& table = chain.table();
    double energy = 0.0;
    for (int j = 0; j < pieces; ++j) {
      const Chain::Piece& p = chain.piece(j);
      const Eigen::Map<const Eigen::VectorXd> q(backbone.coordinates(j), n);
      double bend = 0.0;
      for (int i = 0; i < n; ++i) bend += q[i] * table.stiffness.col(i).dot(q);
      energy += p.stiffness * (0.5 * bend / length(j) - p.rest_curvature * q.dot(table.end) +
                               0.5 * p.rest_curvature * p.rest_curvature * length(j));
    }
    values.base[index.energy] = energy;
  }
  for (std::size_t i = 0; i < unit_variable.size(); ++i) {
    values.base[dense_count + static_cast<Eigen::Index>(i)] = x[unit_variable[i]];
  }
}

}  // namespace tendril
