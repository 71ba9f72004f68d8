// What the shooting's unknowns violate, and its derivatives by complex steps.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "support/rod_shooting.hpp"

namespace tendril::support {
namespace {

constexpr double kComplexStep = 1e-40;

/// Derivatives of an obstacle's normal and gap in the point.
Eigen::Matrix<double, 3, 2> surface_derivatives(const BvpContact& c, double x, double y) {
  Eigen::Matrix<double, 3, 2> d;
  for (int i = 0; i < 2; ++i) {
    const Surface<Complex> o = surface<Complex>(c, {x, i == 0 ? kComplexStep : 0.0}, {y, i == 1 ? kComplexStep : 0.0});
    d.col(i) << o.nx.imag(), o.ny.imag(), o.gap.imag();
  }
  return d / kComplexStep;
}

}  // namespace

Eigen::VectorXd Shooting::assemble(const Eigen::VectorXd& u, Eigen::MatrixXd* jacobian) const {
  const Eigen::Index size = u.size();
  Eigen::VectorXd r = Eigen::VectorXd::Zero(size);
  if (jacobian) jacobian->setZero(size, size);
  const auto put = [&](Eigen::Index row, Eigen::Index column, double value) {
    if (jacobian) (*jacobian)(row, column) += value;
  };

  r[0] = u[kAngle] - rod_.base_angle;
  r[1] = u[kX] - rod_.base.x;
  r[2] = u[kY] - rod_.base.y;
  put(0, kAngle, 1.0);
  put(1, kX, 1.0);
  put(2, kY, 1.0);
  Eigen::Index row = 3;

  State<double> end{};
  for (const Piece& p : pieces_) {
    const Field<double> f = field(p, u);
    const double h = interval_length(p, u);
    for (std::size_t i = 0; i < p.count; ++i) {
      const std::size_t interval = p.first + i;
      const bool last = interval + 1 == interval_count_;
      const State<double> z = state(u, interval);
      end = flow(f, z, h);
      // Rows of this interval's end: all six states at an interior node; at the tip moment and force, then the angle.
      const auto target_row = [&](Eigen::Index component) -> Eigen::Index {
        if (!last) return row + component;
        return component >= kMoment ? row + component - kMoment : -1;
      };
      const auto column = static_cast<Eigen::Index>(kStates * interval);
      const auto add_end = [&](Eigen::Index unknown, const State<double>& derivative) {
        for (Eigen::Index c = 0; c < kStates; ++c) {
          const double value = derivative[static_cast<std::size_t>(c)];
          if (target_row(c) >= 0) put(target_row(c), unknown, value);
          if (last && c == kAngle && free_actuator_) put(moment_index_, unknown, value);
        }
        if (!last) return;
        for (std::size_t k = 0; k < contacts_.size(); ++k) {
          if (!contacts_[k].at_tip) continue;
          const Eigen::Matrix<double, 3, 2> d = surface_derivatives(contacts_[k], end[kX], end[kY]);
          const Eigen::Vector3d change = d * Eigen::Vector2d(derivative[kX], derivative[kY]);
          put(row + 1, unknown, -u[force_index_[k]] * change[0]);
          put(row + 2, unknown, -u[force_index_[k]] * change[1]);
          put(force_index_[k], unknown, change[2]);
        }
      };
      if (jacobian) {
        const Field<Complex> fc{f.stiffness, f.free_curvature, f.weight};
        const auto imaginary = [](const State<Complex>& v) {
          State<double> d;
          for (std::size_t c = 0; c < kStates; ++c) d[c] = v[c].imag() / kComplexStep;
          return d;
        };
        for (std::size_t c = 0; c < kStates; ++c) {
          State<Complex> zc;
          std::copy(z.begin(), z.end(), zc.begin());
          zc[c] += Complex(0.0, kComplexStep);
          add_end(column + static_cast<Eigen::Index>(c), imaginary(flow(fc, zc, h)));
        }
        if (free_actuator_ && p.spanned[*free_actuator_]) {
          State<Complex> zc;
          std::copy(z.begin(), z.end(), zc.begin());
          Field<Complex> moved = fc;
          moved.free_curvature += Complex(0.0, kComplexStep / f.stiffness);
          add_end(moment_index_, imaginary(flow(moved, zc, h)));
        }
        const State<double> speed = rate(f, end);
        for (const auto& [knot, sign] : {std::pair{p.left, -1.0}, std::pair{p.right, 1.0}}) {
          if (!knots_[knot].contact) continue;
          State<double> d = speed;
          for (double& v : d) v *= sign / static_cast<double>(p.count);
          add_end(arc_index_[*knots_[knot].contact], d);
        }
      }
      if (last) break;
      const State<double> next = state(u, interval + 1);
      for (Eigen::Index c = 0; c < kStates; ++c) {
        r[row + c] = end[static_cast<std::size_t>(c)] - next[static_cast<std::size_t>(c)];
        put(row + c, column + kStates + c, -1.0);
      }
      const auto contact = i + 1 == p.count ? knots_[p.right].contact : std::nullopt;
      if (contact) {
        // The point of the node beyond the contact stands for the contact point: both sides agree at the solution.
        const std::size_t k = *contact;
        const Surface<double> o = surface(contacts_[k], next[kX], next[kY]);
        const double force = u[force_index_[k]];
        r[row + kForceX] -= force * o.nx;
        r[row + kForceY] -= force * o.ny;
        const double tx = std::cos(next[kAngle]);
        const double ty = std::sin(next[kAngle]);
        const Eigen::Index gap = arc_index_[k];
        const Eigen::Index tangency = force_index_[k];
        r[gap] = o.gap;
        r[tangency] = tx * o.nx + ty * o.ny;
        if (jacobian) {
          const Eigen::Matrix<double, 3, 2> d = surface_derivatives(contacts_[k], next[kX], next[kY]);
          put(row + kForceX, force_index_[k], -o.nx);
          put(row + kForceY, force_index_[k], -o.ny);
          for (Eigen::Index c = 0; c < 2; ++c) {
            const Eigen::Index point = column + kStates + kX + c;
            put(row + kForceX, point, -force * d(0, c));
            put(row + kForceY, point, -force * d(1, c));
            put(gap, point, d(2, c));
            put(tangency, point, tx * d(0, c) + ty * d(1, c));
          }
          put(tangency, column + kStates + kAngle, -ty * o.nx + tx * o.ny);
        }
      }
      row += kStates;
    }
  }

  r[row] = end[kMoment];
  r[row + 1] = end[kForceX] - rod_.tip_force.x - rod_.payload * rod_.gravity.x;
  r[row + 2] = end[kForceY] - rod_.tip_force.y - rod_.payload * rod_.gravity.y;
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    if (!contacts_[k].at_tip) continue;
    const Surface<double> o = surface(contacts_[k], end[kX], end[kY]);
    r[row + 1] -= u[force_index_[k]] * o.nx;
    r[row + 2] -= u[force_index_[k]] * o.ny;
    put(row + 1, force_index_[k], -o.nx);
    put(row + 2, force_index_[k], -o.ny);
    r[force_index_[k]] = o.gap;
  }
  if (free_actuator_) r[moment_index_] = end[kAngle] - tip_angle_;
  return r;
}

}  // namespace tendril::support
