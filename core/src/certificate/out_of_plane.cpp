#include "certificate/out_of_plane.hpp"

#include <algorithm>

#include "tendril/coordinate_model.hpp"

namespace tendril {
namespace {

/// Panels shorter than this (sigma) are none.
constexpr double rounding = 1e-9;
/// Functions per component of w on all panels together, and on one of them at least.
constexpr int functions_together = 32, least_functions = 6;

}  // namespace

OutOfPlane::OutOfPlane(int most_functions) : most_functions_(most_functions) {}

/// Pieces, cut where their basis is less smooth and where something pushes inside of them.
void OutOfPlane::cut(const PoseProgram& program, const Curve& curve) {
  panels_.clear();
  const CurveTables& tables = *program.chain().curve_tables();
  for (int j = 0; j < curve.piece_count(); ++j) {
    ends_.clear();
    for (int i = 0; i <= tables.intervals(); ++i) ends_.push_back(tables.end(i));
    for (const PoseProgram::ContactState& c : program.contacts()) {
      if (c.force == 0.0) continue;
      const double sigma = (c.arc_length - curve.start(j)) / curve.length(j);
      if (sigma > rounding && sigma < 1.0 - rounding) ends_.push_back(sigma);
    }
    std::sort(ends_.begin(), ends_.end());
    for (std::size_t e = 0; e + 1 < ends_.size(); ++e) {
      if (!(ends_[e + 1] - ends_[e] > rounding)) continue;
      panels_.push_back({j, ends_[e], ends_[e + 1], curve.start(j) + ends_[e] * curve.length(j),
                         (ends_[e + 1] - ends_[e]) * curve.length(j)});
    }
  }
}

void OutOfPlane::find_forces(const PoseProgram& program) {
  const Rod& rod = *program.spec().rod;
  const Loads& loads = program.loads();
  forces_.clear();
  forces_.push_back({1.0, loads.tip_force + rod.payload * loads.gravity});
  for (const PoseProgram::ContactState& c : program.contacts()) {
    // What is tangential acts on the surface.
    forces_.push_back({c.arc_length, c.force * c.push + c.shear * turned(c.surface.normal),
                       -(c.force * c.lean + c.shear) * c.radius.value});
  }
  for (const Rod::Load& l : rod.loads) {
    if (l.at_point()) forces_.push_back({l.from, loads.dead * l.force + l.weight * loads.gravity});
  }
}

void OutOfPlane::choose_functions(int count) {
  if (count == functions_) return;
  functions_ = count;
  rule_ = Quadrature(2 * count + 8);
  const int nodes = rule_.size();
  value_.setOnes(nodes, 1 + count);
  slope_.setZero(nodes, 1 + count);
  Eigen::MatrixXd second(nodes, count);
  LegendreBasis(count).evaluate({rule_.nodes().data(), static_cast<std::size_t>(nodes)}, value_.rightCols(count),
                                slope_.rightCols(count), second);
  up_to_.resize(nodes, nodes);
  Eigen::VectorXd row(nodes);
  for (int g = 0; g < nodes; ++g) {
    rule_.partial_weights(rule_.nodes()[g], {row.data(), static_cast<std::size_t>(nodes)});
    up_to_.row(g) = row;
  }
  for (Eigen::VectorXd* v :
       {&shear_, &passed_, &by_xx_, &by_xy_, &by_yy_, &by_turn_, &stiff_xx_, &stiff_xy_, &stiff_yy_}) {
    v->resize(nodes);
  }
}

double OutOfPlane::margin(const PoseProgram& program, const Curve& curve) {
  cut(program, curve);
  find_forces(program);
  const auto panels = static_cast<int>(panels_.size());
  choose_functions(std::clamp(functions_together / panels, least_functions, most_functions_));
  geometric_.setZero(2 * functions_ * panels, 2 * functions_ * panels);
  Transmitted beyond;
  factors_.resize(panels_.size());
  for (std::size_t p = panels_.size(); p-- > 0;) {
    weigh(program, curve, p, beyond);
    form(p);
    add_to_whole(p);
  }
  // The first two terms couple no panels: in coordinates in which they are the unit matrix Q is 1 - G.
  const Eigen::Index n = 2 * functions_;
  for (std::size_t p = 0; p < panels_.size(); ++p) {
    auto columns = geometric_.middleCols(static_cast<Eigen::Index>(p) * n, n);
    factors_[p].matrixU().solveInPlace<Eigen::OnTheRight>(columns);
  }
  for (std::size_t p = 0; p < panels_.size(); ++p) {
    auto rows = geometric_.middleRows(static_cast<Eigen::Index>(p) * n, n);
    factors_[p].matrixL().solveInPlace(rows);
  }
  if (!geometric_.allFinite()) return -infinity;
  return 1.0 - eigen_.compute(geometric_, Eigen::EigenvaluesOnly).eigenvalues().tail<1>()[0];
}

/// What its nodes weigh in the quadratic forms of one panel, and what is transmitted at its start.
void OutOfPlane::weigh(const PoseProgram& program, const Curve& curve, std::size_t p, Transmitted& beyond) {
  const Panel& panel = panels_[p];
  const Rod& rod = *program.spec().rod;
  const Loads& loads = program.loads();
  const Rod::Segment& segment = program.chain().segment(panel.piece);
  const double end = panel.start + panel.length;
  for (const PointForce& f : forces_) {
    const bool last = p + 1 == panels_.size();
    if (f.s > panel.start + 0.5 * panel.length && (last || f.s < end + 0.5 * panels_[p + 1].length)) {
      beyond.force += f.force;
      beyond.moment += f.moment;
    }
  }
  Vec2 line{};
  for (const Rod::Load& l : rod.loads) {
    const double middle = panel.start + 0.5 * panel.length;
    if (!l.at_point() && middle > l.from && middle < l.to) line += loads.dead * l.force;
  }
  const double whole = segment.weight_up_to(end);
  const auto force_at = [&](double s) {
    return beyond.force + (whole - segment.weight_up_to(s)) * loads.gravity + (end - s) * line;
  };
  for (int g = 0; g < rule_.size(); ++g) {
    const double s = panel.start + rule_.nodes()[g] * panel.length;
    const Vec2 along = curve.at(panel.piece, panel.from + rule_.nodes()[g] * (panel.to - panel.from)).tangent;
    const Vec2 t = rod.stretches() ? (1.0 / norm(along)) * along : along;
    const Vec2 force = force_at(s);
    const double h = rule_.weights()[g] * panel.length;
    // Forces work on the rod as long as it is.
    shear_[g] = panel.length * cross(along, force);
    by_xx_[g] = -h * along.y * force.y;
    by_yy_[g] = -h * along.x * force.x;
    by_xy_[g] = h * (along.y * force.x + along.x * force.y);
    const double bending = segment.stiffness_at(s).value;
    const double twist = segment.torsion * bending;
    const double across = segment.across * bending;
    const double over = rule_.weights()[g] / panel.length;
    stiff_xx_[g] = over * (twist * t.x * t.x + across * t.y * t.y);
    stiff_yy_[g] = over * (twist * t.y * t.y + across * t.x * t.x);
    stiff_xy_[g] = over * (twist - across) * t.x * t.y;
  }
  const double moment = beyond.moment + rule_.weights().dot(shear_);
  passed_.noalias() = up_to_ * shear_;
  by_turn_ = rule_.weights().cwiseProduct((moment - passed_.array()).matrix());
  beyond = {force_at(panel.start), moment};
}

void OutOfPlane::form(std::size_t p) {
  const Eigen::Index n = functions_;
  const auto slopes = slope_.rightCols(n);
  stiffness_.resize(2 * n, 2 * n);
  stiffness_.topLeftCorner(n, n).noalias() = slopes.transpose() * stiff_xx_.asDiagonal() * slopes;
  stiffness_.bottomRightCorner(n, n).noalias() = slopes.transpose() * stiff_yy_.asDiagonal() * slopes;
  stiffness_.bottomLeftCorner(n, n).noalias() = slopes.transpose() * stiff_xy_.asDiagonal() * slopes;
  factors_[p].compute(stiffness_);

  // w x w' twice by parts of one product; slopes are by sigma, which takes up the length.
  const Eigen::Index m = n + 1;
  local_.resize(2 * m, 2 * m);
  coupled_.noalias() = value_.transpose() * by_turn_.asDiagonal() * slope_;
  local_.topLeftCorner(m, m).noalias() = value_.transpose() * by_xx_.asDiagonal() * value_;
  local_.bottomRightCorner(m, m).noalias() = value_.transpose() * by_yy_.asDiagonal() * value_;
  local_.topRightCorner(m, m).noalias() = value_.transpose() * (0.5 * by_xy_).asDiagonal() * value_;
  local_.topRightCorner(m, m) += 0.5 * (coupled_ - coupled_.transpose());
  local_.bottomLeftCorner(m, m) = local_.topRightCorner(m, m).transpose();
}

/// w at the panel's start is the sum of the first functions of the panels before it: all others vanish at their ends.
void OutOfPlane::add_to_whole(std::size_t p) {
  const Eigen::Index n = functions_;
  const Eigen::Index own = static_cast<Eigen::Index>(p) * 2 * n;
  const auto part = [&](Eigen::Index from_row, Eigen::Index from_column) {
    return local_.block(from_row * (n + 1) + 1, from_column * (n + 1) + 1, n, n);
  };
  for (Eigen::Index a = 0; a < 2; ++a) {
    for (Eigen::Index b = 0; b < 2; ++b) {
      geometric_.block(own + a * n, own + b * n, n, n) += part(a, b);
      const auto row = local_.row(a * (n + 1)).segment(b * (n + 1) + 1, n);
      const double corner = local_(a * (n + 1), b * (n + 1));
      for (Eigen::Index q = 0; q < static_cast<Eigen::Index>(p); ++q) {
        const Eigen::Index first = q * 2 * n + a * n;
        geometric_.row(first).segment(own + b * n, n) += row;
        geometric_.col(first).segment(own + b * n, n) += row.transpose();
        for (Eigen::Index r = 0; r < static_cast<Eigen::Index>(p); ++r) {
          geometric_(first, r * 2 * n + b * n) += corner;
        }
      }
    }
  }
}

}  // namespace tendril
