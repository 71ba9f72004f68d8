#include "estimate/loaded_rod.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "rod/backbone.hpp"
#include "rod/moving_point.hpp"
#include "tendril/error.hpp"

namespace tendril {
namespace {

/// Newton ends when no coordinate moves by more than this (radians), after one step more.
constexpr double newton_tolerance = 1e-11;
constexpr int most_newton_steps = 40;
/// A coordinate never moves by more than this in one step (radians): beyond it the linearization means nothing.
constexpr double longest_newton_step = 1.0;

}  // namespace

/// One chain of pieces with its buffers: the equilibrium equations and their derivatives at one state.
class LoadedRod::Pieces {
 public:
  Pieces(const Rod& rod, const std::vector<double>& moments, const LegendreBasis& basis,
         const std::vector<int>& stretches, double turn)
      : rod_(rod),
        moments_(moments),
        chain_(rod, basis, stretches, suggested_nodes(basis.function_count(), turn)),
        backbone_(chain_, rod.base, rod.base_angle),
        sums_(chain_, false),
        gram_(chain_, true),
        load_(chain_.nodes()),
        weights_(chain_.nodes()) {}

  const Chain& chain() const { return chain_; }
  const Backbone& backbone() const { return backbone_; }

  void move(std::span<const NormalForce> forces, ConstVectorRef coordinates) {
    forces_.assign(forces.begin(), forces.end());
    arc_lengths_.clear();
    for (const NormalForce& f : forces_) arc_lengths_.push_back(f.arc_length);
    backbone_.move(coordinates, arc_lengths_);
    beyond_.assign(static_cast<std::size_t>(chain_.piece_count()), rod_.payload);
    for (int j = chain_.piece_count() - 2; j >= 0; --j) beyond_[at(j)] = beyond_[at(j + 1)] + weight(j + 1);
  }

  /// Left-hand side of the equilibrium equations, dPi/dq - sum f N^T J.
  Eigen::VectorXd residual() {
    Eigen::VectorXd r = Eigen::VectorXd::Zero(chain_.coordinate_count());
    sums_.set_zero();
    for (int j = 0; j < chain_.piece_count(); ++j) {
      for (int g = 0; g < chain_.nodes(); ++g) load_[g] = -measure(j, g) * dot(resultant(j, g), normal(j, g));
      backbone_.add_nodes(sums_, j, load_.data());
    }
    backbone_.spread(sums_, r.data());
    for (int j = 0; j < chain_.piece_count(); ++j) {
      const Chain::Piece& p = chain_.piece(j);
      auto own = r.segment(static_cast<Eigen::Index>(j) * functions(), functions());
      own += p.stiffness / backbone_.length(j) * (chain_.table().stiffness * block(j));
      double moment = p.stiffness * p.rest_curvature;
      for (int a = 0; a < chain_.actuator_count(); ++a) {
        if (chain_.actuated(a, j)) moment += moments_[at(a)];
      }
      own -= moment * chain_.table().end;
    }
    return r;
  }

  /// Derivative of residual() in the coordinates.
  Eigen::MatrixXd jacobian() {
    const Eigen::Index size = chain_.coordinate_count();
    Eigen::MatrixXd a = bending();
    gram_.set_zero();
    for (int j = 0; j < chain_.piece_count(); ++j) {
      for (int g = 0; g < chain_.nodes(); ++g) weights_[g] = measure(j, g) * dot(resultant(j, g), tangent(j, g));
      backbone_.add_gram_nodes(gram_, j, weights_.data());
    }
    backbone_.spread_gram(gram_, a);
    for (int k = 0; k < force_count(); ++k) {
      const Eigen::VectorXd turning = before(k, knot_tangent(k));
      Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(size);
      for (int j = 0; j <= chain_.piece_before_knot(k); ++j) {
        row.segment(static_cast<Eigen::Index>(j) * functions(), functions()) = chain_.table().end.transpose();
      }
      a += forces_[at(k)].force * turning * row;
    }
    return a;
  }

  Eigen::MatrixXd bending() const {
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(chain_.coordinate_count(), chain_.coordinate_count());
    for (int j = 0; j < chain_.piece_count(); ++j) {
      const Eigen::Index first = static_cast<Eigen::Index>(j) * functions();
      a.block(first, first, functions(), functions()) =
          chain_.piece(j).stiffness / backbone_.length(j) * chain_.table().stiffness;
    }
    return a;
  }

  /// Derivative of residual() in force k at frozen coordinates.
  Eigen::VectorXd force_rate(int k) { return -before(k, turned(knot_tangent(k))); }

  /// Derivative of residual() in the arc length of force k at frozen coordinates: only lengths of pieces change.
  Eigen::VectorXd place_rate(int k) {
    Eigen::VectorXd r = Eigen::VectorXd::Zero(chain_.coordinate_count());
    sums_.set_zero();
    double beyond_rate = 0.0;
    for (int j = chain_.piece_count() - 1; j >= 0; --j) {
      const double rate = chain_.length_rate()(j, k);
      const double w = chain_.piece(j).weight;
      for (int g = 0; g < chain_.nodes(); ++g) {
        const double mass_rate = beyond_rate + w * rate * (1.0 - chain_.table().sigma[g]);
        const Vec2 force = rate * resultant(j, g) + (backbone_.length(j) * mass_rate) * rod_.gravity;
        load_[g] = -chain_.table().weight[g] * dot(force, normal(j, g));
      }
      backbone_.add_nodes(sums_, j, load_.data());
      beyond_rate += w * rate;
    }
    backbone_.spread(sums_, r.data());
    for (int j = 0; j < chain_.piece_count(); ++j) {
      const double h = backbone_.length(j);
      r.segment(static_cast<Eigen::Index>(j) * functions(), functions()) -=
          chain_.piece(j).stiffness * chain_.length_rate()(j, k) / (h * h) * (chain_.table().stiffness * block(j));
    }
    return r;
  }

  void sum_normals() { backbone_.sum_normals(); }
  /// n . dP/dq of a point that was moved to; needs sum_normals().
  void point_row(const MovingPoint& point, Vec2 n, Eigen::RowVectorXd& row) {
    row.setZero(chain_.coordinate_count());
    backbone_.row_before(point.piece(), point.position(), n, row.data());
    point.own_row(n, false, row.data() + point.piece() * functions());
  }
  /// dP/ds_k of a point of fixed arc length at frozen coordinates.
  Vec2 slide(const MovingPoint& point, int k) const {
    const int j = point.piece();
    Vec2 rate{};
    for (int i = 0; i < j; ++i) rate += chain_.length_rate()(i, k) * backbone_.chord(i);
    rate += chain_.length_rate()(j, k) * point.chord();
    return rate - (chain_.start_rate()(j, k) + point.sigma() * chain_.length_rate()(j, k)) * point.tangent();
  }
  int piece_at(double s) const { return chain_.piece_at(s, arc_lengths_); }
  int force_count() const { return static_cast<int>(forces_.size()); }
  const Rod& rod() const { return rod_; }

 private:
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  int functions() const { return chain_.functions(); }
  Eigen::Map<const Eigen::VectorXd> block(int j) const { return {backbone_.coordinates(j), functions()}; }
  double weight(int j) const { return chain_.piece(j).weight * backbone_.length(j); }
  double measure(int j, int g) const { return backbone_.length(j) * chain_.table().weight[g]; }
  Vec2 tangent(int j, int g) const { return backbone_.tangent(j, g); }
  Vec2 normal(int j, int g) const { return turned(tangent(j, g)); }
  Vec2 knot_tangent(int k) const { return backbone_.knot_tangent(chain_.piece_before_knot(k) + 1); }
  /// Force of everything beyond a node.
  Vec2 resultant(int j, int g) const {
    const double mass = beyond_[at(j)] + weight(j) * (1.0 - chain_.table().sigma[g]);
    Vec2 force = rod_.tip_force + mass * rod_.gravity;
    for (int k = 0; k < force_count(); ++k) {
      if (j <= chain_.piece_before_knot(k)) force += forces_[at(k)].force * turned(knot_tangent(k));
    }
    return force;
  }
  /// Generalized force of the dead force d at the knot of force k: d . dP(s_k)/dq.
  Eigen::VectorXd before(int k, Vec2 d) {
    Eigen::VectorXd r = Eigen::VectorXd::Zero(chain_.coordinate_count());
    sums_.set_zero();
    for (int j = 0; j <= chain_.piece_before_knot(k); ++j) {
      for (int g = 0; g < chain_.nodes(); ++g) load_[g] = measure(j, g) * dot(d, normal(j, g));
      backbone_.add_nodes(sums_, j, load_.data());
    }
    backbone_.spread(sums_, r.data());
    return r;
  }

  const Rod& rod_;
  const std::vector<double>& moments_;
  Chain chain_;
  Backbone backbone_;
  PieceSums sums_, gram_;
  Eigen::VectorXd load_, weights_;
  std::vector<NormalForce> forces_;
  std::vector<double> arc_lengths_;
  std::vector<double> beyond_;  // mass beyond the end of each piece
};

LoadedRod::LoadedRod(const Rod& rod, std::vector<double> moments, int order, double turn)
    : rod_(rod), moments_(std::move(moments)), basis_(order), turn_(turn), knots_(rod.fixed_knots()) {
  if (moments_.size() != rod_.actuators.size()) throw Error("one moment per actuator is needed");
}

LoadedRod::~LoadedRod() = default;

void LoadedRod::move_apart(std::vector<NormalForce>& forces) const {
  double least = knot_clearance;
  for (std::size_t k = 0; k < forces.size(); ++k) {
    // Room is kept for the forces that follow.
    const double most = 1.0 - knot_clearance * static_cast<double>(forces.size() - k);
    double s = std::clamp(forces[k].arc_length, least, most);
    for (const double knot : knots_) {
      if (std::abs(s - knot) < knot_clearance) s = s < knot ? knot - knot_clearance : knot + knot_clearance;
    }
    forces[k].arc_length = s;
    least = s + knot_clearance;
  }
}

std::vector<int> LoadedRod::stretches(std::span<const NormalForce> forces) const {
  std::vector<int> out;
  for (const NormalForce& f : forces) {
    const auto next = std::upper_bound(knots_.begin() + 1, knots_.end() - 1, f.arc_length);
    out.push_back(static_cast<int>(next - knots_.begin()) - 1);
  }
  return out;
}

LoadedRod::Pieces& LoadedRod::pieces(std::span<const NormalForce> forces) const {
  const std::vector<int> key = stretches(forces);
  std::unique_ptr<Pieces>& entry = pieces_[key];
  if (!entry) entry = std::make_unique<Pieces>(rod_, moments_, basis_, key, turn_);
  return *entry;
}

LoadedRod::Shape LoadedRod::solve(std::vector<NormalForce> forces, const Curvature& start) const {
  move_apart(forces);
  const Chain& chain = pieces(forces).chain();
  std::vector<double> arc_lengths;
  arc_lengths.reserve(forces.size());
  for (const NormalForce& f : forces) arc_lengths.push_back(f.arc_length);
  Eigen::VectorXd q(chain.coordinate_count());
  std::vector<double> scaled(static_cast<std::size_t>(chain.nodes()));
  for (int j = 0; j < chain.piece_count(); ++j) {
    const double from = chain.start(j, arc_lengths);
    const double length = chain.length(j, arc_lengths);
    for (int g = 0; g < chain.nodes(); ++g) {
      scaled[static_cast<std::size_t>(g)] = length * start(from + length * chain.table().sigma[g]);
    }
    q.segment(static_cast<Eigen::Index>(j) * chain.functions(), chain.functions()) = chain.project(scaled);
  }
  return newton(std::move(forces), std::move(q));
}

LoadedRod::Shape LoadedRod::solve(std::vector<NormalForce> forces, const Shape& start) const {
  move_apart(forces);
  const std::vector<int> here = stretches(forces);
  if (here == stretches(start.forces)) return newton(std::move(forces), start.coordinates);
  // Another chain: the curvature is carried over.
  return solve(std::move(forces), curvature(start));
}

LoadedRod::Curvature LoadedRod::curvature(const Shape& shape) const {
  Pieces& p = pieces(shape.forces);
  p.move(shape.forces, shape.coordinates);
  return [backbone = p.backbone()](double s) { return backbone.at(s).curvature; };
}

LoadedRod::Shape LoadedRod::newton(std::vector<NormalForce> forces, Eigen::VectorXd coordinates) const {
  ++solves_;
  Pieces& p = pieces(forces);
  Shape shape{std::move(forces), std::move(coordinates)};
  p.move(shape.forces, shape.coordinates);
  Eigen::VectorXd r = p.residual();
  bool last = false;
  while (shape.iterations < most_newton_steps && r.allFinite()) {
    ++shape.iterations;
    const Eigen::PartialPivLU<Eigen::MatrixXd> lu(p.jacobian());
    Eigen::VectorXd step = -lu.solve(r);
    const double size = step.lpNorm<Eigen::Infinity>();
    if (!std::isfinite(size)) return shape;
    double fraction = std::min(1.0, longest_newton_step / size);
    // The simplified next step tells whether this one helps (natural level function).
    for (bool accepted = false; !accepted; fraction *= 0.5) {
      if (fraction < 1e-4) return shape;
      const Eigen::VectorXd trial = shape.coordinates + fraction * step;
      p.move(shape.forces, trial);
      r = p.residual();
      const double next = lu.solve(r).lpNorm<Eigen::Infinity>();
      accepted = size <= 1e-8 || (std::isfinite(next) && next <= (1.0 - 0.25 * fraction) * size);
      if (accepted) shape.coordinates = trial;
    }
    if (last) {
      shape.converged = true;
      return shape;
    }
    last = size <= newton_tolerance;
  }
  return shape;
}

LoadedRod::Response LoadedRod::response(const Shape& shape, std::span<const double> arc_lengths) const {
  Pieces& p = pieces(shape.forces);
  p.move(shape.forces, shape.coordinates);
  p.sum_normals();
  const int forces = p.force_count();
  Response out;
  Eigen::MatrixXd rhs(p.chain().coordinate_count(), 2 * forces);
  for (int k = 0; k < forces; ++k) {
    rhs.col(2 * k) = -p.force_rate(k);
    rhs.col(2 * k + 1) = -p.place_rate(k);
  }
  if (forces > 0) {
    out.coordinate_rates = p.jacobian().partialPivLu().solve(rhs);
  } else {
    out.coordinate_rates = rhs;
  }
  const auto count = static_cast<Eigen::Index>(arc_lengths.size());
  out.points.resize(2 * count);
  out.rates.resize(2 * count, 2 * forces);
  MovingPoint point(p.chain());
  Eigen::RowVectorXd row;
  for (Eigen::Index m = 0; m < count; ++m) {
    const double s = arc_lengths[static_cast<std::size_t>(m)];
    point.move(p.backbone(), p.piece_at(s), s);
    out.points[2 * m] = point.position().x;
    out.points[2 * m + 1] = point.position().y;
    if (forces == 0) continue;
    p.point_row(point, {1.0, 0.0}, row);
    out.rates.row(2 * m) = row * out.coordinate_rates;
    p.point_row(point, {0.0, 1.0}, row);
    out.rates.row(2 * m + 1) = row * out.coordinate_rates;
    for (int k = 0; k < forces; ++k) {
      const Vec2 slide = p.slide(point, k);
      out.rates(2 * m, 2 * k + 1) += slide.x;
      out.rates(2 * m + 1, 2 * k + 1) += slide.y;
    }
  }
  return out;
}

Eigen::MatrixXd LoadedRod::influence(const Shape& shape, std::span<const double> arc_lengths,
                                     std::span<const double> places) const {
  Pieces& p = pieces(shape.forces);
  p.move(shape.forces, shape.coordinates);
  p.sum_normals();
  MovingPoint point(p.chain());
  Eigen::RowVectorXd row;
  Eigen::MatrixXd rhs(p.chain().coordinate_count(), static_cast<Eigen::Index>(places.size()));
  for (std::size_t i = 0; i < places.size(); ++i) {
    point.move(p.backbone(), p.piece_at(places[i]), places[i]);
    p.point_row(point, point.normal(), row);
    rhs.col(static_cast<Eigen::Index>(i)) = row.transpose();
  }
  const Eigen::MatrixXd rates = p.jacobian().partialPivLu().solve(rhs);
  Eigen::MatrixXd out(2 * static_cast<Eigen::Index>(arc_lengths.size()), rates.cols());
  for (std::size_t m = 0; m < arc_lengths.size(); ++m) {
    const auto first = 2 * static_cast<Eigen::Index>(m);
    point.move(p.backbone(), p.piece_at(arc_lengths[m]), arc_lengths[m]);
    p.point_row(point, {1.0, 0.0}, row);
    out.row(first) = row * rates;
    p.point_row(point, {0.0, 1.0}, row);
    out.row(first + 1) = row * rates;
  }
  return out;
}

LoadedRod::Imbalance LoadedRod::imbalance(const Curvature& curvature, std::span<const double> places) const {
  Pieces& p = pieces({});
  const Chain& chain = p.chain();
  Eigen::VectorXd q(chain.coordinate_count());
  std::vector<double> scaled(static_cast<std::size_t>(chain.nodes()));
  for (int j = 0; j < chain.piece_count(); ++j) {
    for (int g = 0; g < chain.nodes(); ++g) {
      scaled[static_cast<std::size_t>(g)] =
          chain.length(j, {}) * curvature(chain.start(j, {}) + chain.length(j, {}) * chain.table().sigma[g]);
    }
    q.segment(static_cast<Eigen::Index>(j) * chain.functions(), chain.functions()) = chain.project(scaled);
  }
  p.move({}, q);
  p.sum_normals();
  const Eigen::LLT<Eigen::MatrixXd> bending(p.bending());
  Imbalance out;
  out.missing = bending.matrixL().solve(p.residual());
  out.per_force.resize(chain.coordinate_count(), static_cast<Eigen::Index>(places.size()));
  MovingPoint point(chain);
  Eigen::RowVectorXd row;
  for (std::size_t i = 0; i < places.size(); ++i) {
    point.move(p.backbone(), p.piece_at(places[i]), places[i]);
    p.point_row(point, point.normal(), row);
    out.per_force.col(static_cast<Eigen::Index>(i)) = bending.matrixL().solve(row.transpose());
  }
  return out;
}

std::vector<LoadedRod::Point> LoadedRod::points(const Shape& shape, std::span<const double> arc_lengths) const {
  Pieces& p = pieces(shape.forces);
  p.move(shape.forces, shape.coordinates);
  MovingPoint point(p.chain());
  std::vector<Point> out;
  for (const double s : arc_lengths) {
    point.move(p.backbone(), p.piece_at(s), s);
    out.push_back({point.position(), point.angle(), point.curvature()});
  }
  return out;
}

}  // namespace tendril
