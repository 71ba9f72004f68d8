#include <algorithm>
#include <cmath>

#include "obstacle/surface.hpp"
#include "program/pose_program_data.hpp"
#include "rod/kernels.hpp"

// Second derivatives of  sigma f + multipliers . c.  With lambda the multipliers of the equilibrium rows, lambda . h_e
// is the virtual work along lambda: forces times virtual displacements delta P = int N psi ds, psi = B lambda, plus
// moments times virtual rotations. Everything is then a function of a few base quantities (points, angles, virtual
// displacements), whose outer second derivative is pulled back by their rows, plus first derivatives with respect to
// points (adjoints c) and virtual displacements (c') times the points' own second derivatives, which are weights on the
// nodes of one Gram product.

namespace tendril {
namespace {

void add_symmetric(Eigen::MatrixXd& h, int i, int k, double value) {
  h(i, k) += value;
  h(k, i) += value;
}

}  // namespace

void PoseProgram::do_hessian(ConstVectorRef x, double sigma, ConstVectorRef multipliers, Workspace& out) {
  Data& d = *data_;
  Eigen::MatrixXd& h = out.hessian;
  h.setZero();
  const BasisTable& table = d.chain.table();
  const int n = d.n;
  const Layout& layout = d.layout;
  const double* lambda = multipliers.data();
  const double* end = table.end.data();

  // Virtual rotation and displacement along lambda.
  d.backbone.along(lambda, d.psi, d.psi_knot);
  d.virtual_turn.col(0).setZero();
  for (int j = 0; j < d.pieces; ++j) {
    const double length = d.length(j);
    const double* c = d.backbone.cosines(j);
    const double* s = d.backbone.sines(j);
    const double* psi = d.psi.col(j).data();
    double nx = 0.0;
    double ny = 0.0;
    double* z = d.node_buffer.data();
    for (int g = 0; g < d.nodes; ++g) {
      const double w = table.weight[g] * psi[g];
      nx -= w * s[g];
      ny += w * c[g];
      z[g] = length * w;
    }
    double* sum = d.virtual_sum.col(j).data();
    std::fill_n(sum, 2 * n, 0.0);
    d.backbone.add_turned(j, z, 1, sum);
    d.virtual_chord(0, j) = nx;
    d.virtual_chord(1, j) = ny;
    // int t psi ds = turned clockwise from int N psi ds.
    d.virtual_turn(0, j + 1) = d.virtual_turn(0, j) + length * ny;
    d.virtual_turn(1, j + 1) = d.virtual_turn(1, j) - length * nx;
  }

  // Rows of the contacts' virtual displacements.
  for (std::size_t k = 0; k < d.contacts.size(); ++k) {
    double* rx = d.rows.row(d.delta_row + 2 * static_cast<int>(k)).data();
    double* ry = d.rows.row(d.delta_row + 2 * static_cast<int>(k) + 1).data();
    const int last = d.contact_piece[k];
    const bool at_knot = d.contact_moving[k] < 0;
    Vec2 turn{d.virtual_turn(0, last + 1), d.virtual_turn(1, last + 1)};
    if (!at_knot) {
      const MovingPoint& m = d.moving[static_cast<std::size_t>(d.contact_moving[k])];
      turn = {d.virtual_turn(0, last), d.virtual_turn(1, last)};
      std::fill_n(rx + last * n, n, 0.0);
      std::fill_n(ry + last * n, n, 0.0);
      for (int g = 0; g < m.node_count(); ++g) {
        const double* beta = m.node_beta(g);
        double psi = d.psi_knot[last];
        for (int i = 0; i < n; ++i) psi += lambda[last * n + i] * beta[i];
        const Vec2 t = m.node_tangent(g);
        const double w = d.length(last) * m.weight(g) * psi;
        turn += w * t;
        for (int i = 0; i < n; ++i) {
          rx[last * n + i] -= w * t.x * beta[i];
          ry[last * n + i] -= w * t.y * beta[i];
        }
      }
    }
    for (int i = 0; i <= (at_knot ? last : last - 1); ++i) {
      const double tx = turn.x - d.virtual_turn(0, i + 1);
      const double ty = turn.y - d.virtual_turn(1, i + 1);
      for (int b = 0; b < n; ++b) {
        // -t = N turned once more.
        rx[i * n + b] = -d.virtual_sum(n + b, i) - tx * end[b];
        ry[i * n + b] = d.virtual_sum(b, i) - ty * end[b];
      }
    }
    for (int l = 0; l < d.s_count; ++l) {
      Vec2 rate{};
      for (int i = 0; i <= (at_knot ? last : last - 1); ++i) {
        rate += d.length_rate(i, l) * Vec2{d.virtual_chord(0, i), d.virtual_chord(1, i)};
      }
      if (!at_knot) {
        const MovingPoint& m = d.moving[static_cast<std::size_t>(d.contact_moving[k])];
        double psi = d.psi_knot[last];
        for (int i = 0; i < n; ++i) psi += lambda[last * n + i] * m.beta()[i];
        rate += d.own_rate(m, static_cast<int>(k), l) * psi * m.normal();
      }
      rx[layout.first_arc_length + l] = rate.x;
      ry[layout.first_arc_length + l] = rate.y;
    }
  }

  // Outer second derivatives with respect to base quantities and virtual displacements.
  Eigen::MatrixXd& hb = d.base_hessian;
  hb.setZero();
  d.terms.add_hessian(d.values, sigma, hb);
  d.base_gradient = sigma * d.term_gradient;
  const int delta0 = d.index.count;
  for (std::size_t k = 0; k < d.contacts.size(); ++k) {
    const ContactState& c = d.contacts[k];
    const BaseIndex::Contact& at = d.index.contacts[k];
    const int dx = delta0 + 2 * static_cast<int>(k);
    const int dy = dx + 1;
    const double gap = multipliers[layout.first_gap + static_cast<int>(k)];
    const double closest = multipliers[layout.first_closest + static_cast<int>(k)];
    const Vec2 n0 = c.surface.normal;
    const Vec2 tau = turned(n0);
    const double curvature = c.surface.curvature;
    Vec2 delta{};
    const int last = d.contact_piece[k];
    for (int i = 0; i < last + (d.contact_moving[k] < 0 ? 1 : 0); ++i) {
      delta += d.length(i) * Vec2{d.virtual_chord(0, i), d.virtual_chord(1, i)};
    }
    if (d.contact_moving[k] >= 0) {
      const MovingPoint& m = d.moving[static_cast<std::size_t>(d.contact_moving[k])];
      for (int g = 0; g < m.node_count(); ++g) {
        double psi = d.psi_knot[last];
        for (int i = 0; i < n; ++i) psi += lambda[last * n + i] * m.node_beta(g)[i];
        delta += d.length(last) * m.weight(g) * psi * turned(m.node_tangent(g));
      }
    }
    // The balance row f n(P) . axis has the form of the virtual work along a constant displacement.
    if (layout.balances > 0) delta += multipliers[layout.first_balance] * d.spec.palm->axis;
    // gap: d;  closest point: t(phi) . n(P);  virtual work of the force: f n(P) . delta.
    const double along = closest * curvature * dot(tau, c.tangent) + c.force * curvature * dot(tau, delta);
    d.base_gradient[at.point.x] += gap * n0.x + along * tau.x;
    d.base_gradient[at.point.y] += gap * n0.y + along * tau.y;
    d.base_gradient[at.point.angle] += closest * dot(turned(c.tangent), n0);
    const Symmetric2 of_distance = distance_hessian(c.surface);
    const Symmetric2 of_normal = normal_hessian(c.surface, closest * c.tangent + c.force * delta);
    hb(at.point.x, at.point.x) += gap * of_distance.xx + of_normal.xx;
    hb(at.point.y, at.point.y) += gap * of_distance.yy + of_normal.yy;
    add_symmetric(hb, at.point.x, at.point.y, gap * of_distance.xy + of_normal.xy);
    const double turning = closest * curvature * dot(tau, turned(c.tangent));
    add_symmetric(hb, at.point.x, at.point.angle, turning * tau.x);
    add_symmetric(hb, at.point.y, at.point.angle, turning * tau.y);
    hb(at.point.angle, at.point.angle) -= closest * dot(c.tangent, n0);
    add_symmetric(hb, at.point.x, dx, c.force * of_distance.xx);
    add_symmetric(hb, at.point.x, dy, c.force * of_distance.xy);
    add_symmetric(hb, at.point.y, dx, c.force * of_distance.xy);
    add_symmetric(hb, at.point.y, dy, c.force * of_distance.yy);
    const double sliding = curvature * dot(tau, delta);
    add_symmetric(hb, at.point.x, at.force, sliding * tau.x);
    add_symmetric(hb, at.point.y, at.force, sliding * tau.y);
    add_symmetric(hb, dx, at.force, n0.x);
    add_symmetric(hb, dy, at.force, n0.y);
  }

  // Pull back: dense rows and rows of single variables.
  const int total = delta0 + 2 * static_cast<int>(d.contacts.size());
  const auto unit = [&](int b) {
    return b >= d.dense_count && b < delta0 ? d.unit_variable[static_cast<std::size_t>(b - d.dense_count)] : -1;
  };
  const auto row_of = [&](int b) { return d.rows.row(b < d.dense_count ? b : d.delta_row + (b - delta0)).data(); };
  double* pulled = d.row_buffer.data();
  for (int a = 0; a < total; ++a) {
    std::fill_n(pulled, d.x_count, 0.0);
    bool any = false;
    for (int b = 0; b < total; ++b) {
      const double value = hb(a, b);
      if (value == 0.0) continue;
      any = true;
      if (const int variable = unit(b); variable >= 0) {
        pulled[variable] += value;
      } else {
        const double* row = row_of(b);
        for (int i = 0; i < d.x_count; ++i) pulled[i] += value * row[i];
      }
    }
    if (!any) continue;
    if (const int variable = unit(a); variable >= 0) {
      double* out_column = h.col(variable).data();
      for (int i = 0; i < d.x_count; ++i) out_column[i] += pulled[i];
    } else {
      const double* row = row_of(a);
      for (int column = 0; column < d.x_count; ++column) {
        if (row[column] == 0.0) continue;
        double* out_column = h.col(column).data();
        for (int i = 0; i < d.x_count; ++i) out_column[i] += row[column] * pulled[i];
      }
    }
  }
  d.add_inner_second(x, sigma, multipliers, h);
  if (d.margin && multipliers[layout.first_margin] != 0.0) h += multipliers[layout.first_margin] * d.margin->hessian();
  for (std::size_t i = 0; i < d.convex.size(); ++i) {
    const double multiplier = multipliers[layout.first_convexity + static_cast<int>(i)];
    if (multiplier != 0.0) h += multiplier * d.convex[i].matrix();
  }
}

/// Sums the adjoints of the check rows at each station, and all of them. False: no row has a multiplier.
bool PoseProgram::Data::gather_check_adjoints(CheckStations& at, ConstVectorRef multipliers, Vec2& sum) const {
  at.adjoint_x.setZero();
  at.adjoint_y.setZero();
  bool any = false;
  for (std::size_t use = 0; use < at.rows.size(); ++use) {
    const double multiplier = multipliers[layout.first_check + at.rows[use]];
    if (multiplier == 0.0) continue;
    any = true;
    const Vec2 adj = multiplier * check_surface[static_cast<std::size_t>(at.rows[use])].normal;
    at.adjoint_x[at.station[use]] += adj.x;
    at.adjoint_y[at.station[use]] += adj.y;
    sum += adj;
  }
  return any;
}

void PoseProgram::Data::add_inner_second(ConstVectorRef x, double sigma, ConstVectorRef multipliers,
                                         Eigen::MatrixXd& h) {
  (void)sigma;
  const BasisTable& table = chain.table();
  const double* lambda = multipliers.data();
  const Vec2 g = loads.gravity;
  const int s0 = layout.first_arc_length;

  // Adjoints of points beyond each piece, of their virtual displacements, and of check points.
  Vec2 c_sum{};
  Vec2 v_sum = loads.tip_force;
  if (index.tip.x >= 0) c_sum += {base_gradient[index.tip.x], base_gradient[index.tip.y]};
  const std::size_t first_sample = moving.size() - index.samples.size();
  gram_sums.set_zero();
  for (PieceSums& r : rate_sums) r.set_zero();
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    if (!spec.contacts[k].at_tip) continue;
    const BaseIndex::Point& p = index.contacts[k].point;
    c_sum += {base_gradient[p.x], base_gradient[p.y]};
    v_sum += contacts[k].force * contacts[k].surface.normal;
  }
  double* z = node_buffer.data();
  double* check_push = check_buffer.data();
  for (int j = pieces - 1; j >= 0; --j) {
    const double length_j = length(j);
    for (std::size_t k = 0; k < contacts.size(); ++k) {
      if (spec.contacts[k].at_tip || contact_moving[k] >= 0 || contact_piece[k] != j) continue;
      const BaseIndex::Point& p = index.contacts[k].point;
      c_sum += {base_gradient[p.x], base_gradient[p.y]};
      v_sum += contacts[k].force * contacts[k].surface.normal;
    }
    const double* c = backbone.cosines(j);
    const double* s = backbone.sines(j);
    const double* turn = psi.col(j).data();
    CheckStations& at = stations[static_cast<std::size_t>(j)];
    const double own = chain.piece(j).weight * length_j;
    const double mass = mass_beyond[j];

    // Weights of the Gram product: -h (C . t + (C' + gravity) . N psi).
    for (int i = 0; i < nodes; ++i) {
      const double m = gravity ? mass + own * (1.0 - table.sigma[i]) : 0.0;
      const double force_n = (v_sum.y + m * g.y) * c[i] - (v_sum.x + m * g.x) * s[i];
      z[i] = -length_j * table.weight[i] * (c_sum.x * c[i] + c_sum.y * s[i] + force_n * turn[i]);
    }
    Vec2 check_sum{};
    const bool checked = gather_check_adjoints(at, multipliers, check_sum);
    if (checked) {
      const auto count = static_cast<int>(at.by_node.rows());
      for (int i = 0; i < nodes; ++i) {
        const double* a = at.by_node.col(i).data();
        double ax = 0.0;
        double ay = 0.0;
        for (int k = 0; k < count; ++k) {
          ax += a[k] * at.adjoint_x[k];
          ay += a[k] * at.adjoint_y[k];
        }
        z[i] -= length_j * (ax * c[i] + ay * s[i]);
        check_push[i] = ay * c[i] - ax * s[i];
      }
    }
    backbone.add_gram_nodes(gram_sums, j, z);

    // Mixed with arc lengths: d/ds_l of the same sums' first derivatives.
    for (int l = 0; l < s_count; ++l) {
      const double rate = length_rate(j, l);
      const double mass_l = rate * mass + length_j * mass_rate(j, l);
      if (rate == 0.0 && mass_l == 0.0) continue;
      const double own_l = 2.0 * chain.piece(j).weight * length_j * rate;
      for (int i = 0; i < nodes; ++i) {
        const double m = gravity ? mass_l + own_l * (1.0 - table.sigma[i]) : 0.0;
        const double push = rate * (c_sum.y * c[i] - c_sum.x * s[i]);
        const double turning = (rate * v_sum.x + m * g.x) * c[i] + (rate * v_sum.y + m * g.y) * s[i];
        z[i] = table.weight[i] * (push - turning * turn[i]);
      }
      if (checked) {
        for (int i = 0; i < nodes; ++i) z[i] += rate * check_push[i];
      }
      backbone.add_nodes(rate_sums[static_cast<std::size_t>(l)], j, z);
    }
    c_sum += check_sum;

    // Points inside the piece act on its own nodes up to themselves, and on all earlier pieces.
    for (std::size_t i = 0; i < moving.size(); ++i) {
      const MovingPoint& m = moving[i];
      if (m.piece() != j) continue;
      const int variable = moving_variable[i];
      const BaseIndex::Point& p =
          variable >= 0 ? index.contacts[static_cast<std::size_t>(variable)].point : index.samples[i - first_sample];
      const Vec2 adj{base_gradient[p.x], base_gradient[p.y]};
      const double adj_angle = base_gradient[p.angle];
      const double adj_curvature = p.curvature >= 0 ? base_gradient[p.curvature] : 0.0;
      Vec2 virtual_adj{};
      if (variable >= 0) {
        const ContactState& contact = contacts[static_cast<std::size_t>(variable)];
        virtual_adj = contact.force * contact.surface.normal;
      }
      const auto psi_of = [&](const double* beta) {
        double value = psi_knot[j];
        for (int b = 0; b < n; ++b) value += lambda[j * n + b] * beta[b];
        return value;
      };
      for (int node = 0; node < m.node_count(); ++node) {
        const Vec2 t = m.node_tangent(node);
        const Vec2 normal = turned(t);
        const double node_psi = psi_of(m.node_beta(node));
        const double w = m.weight(node);
        gram_sums.add_gram_point(j, -length_j * w * (dot(adj, t) + dot(virtual_adj, normal) * node_psi),
                                 m.node_beta(node));
        for (int l = 0; l < s_count; ++l) {
          const double rate = length_rate(j, l);
          if (rate == 0.0) continue;
          rate_sums[static_cast<std::size_t>(l)].add_point(
              j, rate * w * (dot(adj, normal) - dot(virtual_adj, t) * node_psi), m.node_beta(node));
        }
      }
      const double end_psi = psi_of(m.beta());
      double end_psi_slope = 0.0;
      for (int b = 0; b < n; ++b) end_psi_slope += lambda[j * n + b] * m.beta1()[b];
      if (adj_curvature != 0.0) m.third_derivative(third.data());
      for (int l = 0; l < s_count; ++l) {
        const double run = own_rate(m, variable, l);
        const double sigma_l = run / length_j;
        const double h_l = length_rate(j, l);
        rate_sums[static_cast<std::size_t>(l)].add_point(
            j, run * (dot(adj, m.normal()) - dot(virtual_adj, m.tangent()) * end_psi), m.beta());
        // Angle and curvature see the own piece's coordinates only.
        for (int b = 0; b < n; ++b) {
          const double mixed = adj_angle * m.beta1()[b] * sigma_l +
                               adj_curvature * (m.beta2()[b] * sigma_l - m.beta1()[b] * h_l / length_j) / length_j;
          h(j * n + b, s0 + l) += mixed;
          h(s0 + l, j * n + b) += mixed;
        }
        for (int k = 0; k < s_count; ++k) {
          const double run_k = own_rate(m, variable, k);
          const double sigma_k = run_k / length_j;
          const double h_k = length_rate(j, k);
          const double sigma_lk = -(h_l * sigma_k + h_k * sigma_l) / length_j;
          double value = run * run_k / length_j *
                         (dot(adj, m.normal()) * m.slope() - dot(virtual_adj, m.tangent()) * m.slope() * end_psi +
                          dot(virtual_adj, m.normal()) * end_psi_slope);
          value += adj_angle * (m.bend() * sigma_l * sigma_k + m.slope() * sigma_lk);
          if (adj_curvature != 0.0) {
            double jerk = 0.0;
            const double* q = backbone.coordinates(j);
            for (int b = 0; b < n; ++b) jerk += q[b] * third[b];
            value += adj_curvature *
                     (jerk * sigma_l * sigma_k + m.bend() * sigma_lk -
                      m.bend() * (sigma_l * h_k + sigma_k * h_l) / length_j +
                      2.0 * m.slope() * h_l * h_k / (length_j * length_j)) /
                     length_j;
          }
          h(s0 + l, s0 + k) += value;
        }
      }
      c_sum += adj;
      v_sum += virtual_adj;
    }
  }
  backbone.spread_gram(gram_sums, h.topLeftCorner(q_count, q_count));
  for (int l = 0; l < s_count; ++l) {
    double* out = vector_buffer.data();
    std::fill_n(out, q_count, 0.0);
    backbone.spread(rate_sums[static_cast<std::size_t>(l)], out);
    for (int i = 0; i < q_count; ++i) {
      h(i, s0 + l) += out[i];
      h(s0 + l, i) += out[i];
    }
  }

  // Bending: -(EI/h) lambda . K q in the equilibrium rows, EI/(2h) q . K q where a term reads the energy. Gravity:
  // quadratic in h.
  const double energy = index.energy >= 0 ? base_gradient[index.energy] : 0.0;
  for (int j = 0; j < pieces; ++j) {
    const Chain::Piece& p = chain.piece(j);
    const double length_j = length(j);
    const double* q = backbone.coordinates(j);
    double lambda_kq = 0.0;
    double q_kq = 0.0;
    for (int i = 0; i < n; ++i) {
      double kq = 0.0;
      double klambda = 0.0;
      for (int b = 0; b < n; ++b) {
        kq += table.stiffness(i, b) * q[b];
        klambda += table.stiffness(i, b) * lambda[j * n + b];
        if (energy != 0.0) h(j * n + i, j * n + b) += energy * p.stiffness / length_j * table.stiffness(i, b);
      }
      lambda_kq += lambda[j * n + i] * kq;
      q_kq += q[i] * kq;
      const double by_length = p.stiffness / (length_j * length_j) * (klambda - energy * kq);
      for (int l = 0; l < s_count; ++l) {
        const double mixed = by_length * length_rate(j, l);
        h(j * n + i, s0 + l) += mixed;
        h(s0 + l, j * n + i) += mixed;
      }
    }
    const double curved = p.stiffness / (length_j * length_j * length_j) * (energy * q_kq - 2.0 * lambda_kq);
    double e0 = 0.0;
    double e1 = 0.0;
    if (gravity && s_count > 0) {
      const double* c = backbone.cosines(j);
      const double* s = backbone.sines(j);
      const double* turn = psi.col(j).data();
      for (int i = 0; i < nodes; ++i) {
        const double work = table.weight[i] * (g.y * c[i] - g.x * s[i]) * turn[i];
        e0 += work;
        e1 += work * (1.0 - table.sigma[i]);
      }
    }
    for (int l = 0; l < s_count; ++l) {
      for (int k = 0; k < s_count; ++k) {
        const double h_l = length_rate(j, l);
        const double h_k = length_rate(j, k);
        h(s0 + l, s0 + k) +=
            curved * h_l * h_k + (h_l * mass_rate(j, k) + h_k * mass_rate(j, l)) * e0 + 2.0 * p.weight * h_l * h_k * e1;
      }
    }
  }

  // Check points: the obstacle's curvature, as one product over all rows. Rows vanish behind their piece.
  int rows_used = 0;
  const int width = q_count + s_count + (layout.palm >= 0 ? 1 : 0);
  for (int j = 0; j < pieces; ++j) {
    const CheckStations& at = stations[static_cast<std::size_t>(j)];
    for (std::size_t use = 0; use < at.rows.size(); ++use) {
      const auto check = static_cast<std::size_t>(at.rows[use]);
      const double factor = multipliers[layout.first_check + at.rows[use]] * check_surface[check].curvature;
      if (factor == 0.0) continue;
      double* row = check_rows.col(rows_used).data();
      std::fill_n(row + (j + 1) * n, q_count - (j + 1) * n, 0.0);
      check_row(j, at, use, turned(check_surface[check].normal), row, row + q_count);
      double* scaled = scaled_rows.data() + rows_used;
      const auto stride = scaled_rows.rows();
      for (int i = 0; i < width; ++i) scaled[i * stride] = factor * row[i];
      ++rows_used;
    }
  }
  if (rows_used > 0) {
    double* column = row_buffer.data();
    for (int i = 0; i < width; ++i) {
      std::fill_n(column, width, 0.0);
      kernels::add_weighted_columns(width, width, rows_used, check_rows.data(), scaled_rows.col(i).data(), 1, column);
      double* out = h.col(i < q_count ? i : i < q_count + s_count ? s0 + i - q_count : layout.palm).data();
      for (int k = 0; k < q_count; ++k) out[k] += column[k];
      for (int l = 0; l < s_count; ++l) out[s0 + l] += column[q_count + l];
      if (layout.palm >= 0) out[layout.palm] += column[width - 1];
    }
  }
  (void)x;
}

}  // namespace tendril
