#include "estimate/loaded_rod.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "program/pose_program.hpp"
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

/// A program whose contacts push along the rod's normal at places and with forces that are given, at one state.
class LoadedRod::Pieces {
 public:
  Pieces(const Rod& rod, const std::vector<double>& moments, const LegendreBasis& basis,
         const std::vector<int>& stretches, double turn)
      : program_(spec(rod, basis, stretches, turn)), x_(Eigen::VectorXd::Zero(program_.variable_count())) {
    for (std::size_t a = 0; a < moments.size(); ++a) x_[program_.moment_variable(static_cast<int>(a))] = moments[a];
  }

  const Chain& chain() const { return program_.chain(); }
  /// Of the state moved to.
  const Backbone& backbone() {
    program_.jacobian(x_);
    return program_.backbone();
  }

  void move(std::span<const NormalForce> forces, ConstVectorRef coordinates) {
    x_.head(coordinates.size()) = coordinates;
    for (int k = 0; k < force_count(); ++k) {
      const NormalForce& f = forces[static_cast<std::size_t>(k)];
      x_[program_.arc_length_variable(k)] = f.arc_length;
      x_[program_.force_variable(k)] = f.force;
    }
  }

  int force_count() const { return program_.layout().forces; }
  /// What is out of balance, and its derivatives by the coordinates, and by each force and its place in turn.
  Eigen::VectorXd residual() { return program_.constraints(x_).head(size()); }
  Eigen::MatrixXd jacobian() { return program_.jacobian(x_).topLeftCorner(size(), size()); }
  Eigen::MatrixXd load_rates() {
    Eigen::MatrixXd rates(size(), 2 * force_count());
    for (int k = 0; k < force_count(); ++k) {
      rates.col(2 * k) = program_.jacobian(x_).col(program_.force_variable(k)).head(size());
      rates.col(2 * k + 1) = program_.jacobian(x_).col(program_.arc_length_variable(k)).head(size());
    }
    return rates;
  }

  /// K of the bending energy q . K q / 2.
  Eigen::MatrixXd bending() const {
    const int n = chain().functions();
    Eigen::MatrixXd k = Eigen::MatrixXd::Zero(size(), size());
    for (int j = 0; j < chain().piece_count(); ++j) {
      k.block(j * n, j * n, n, n) =
          chain().piece(j).stiffness / program_.backbone().length(j) * chain().table().stiffness;
    }
    return k;
  }

  void place(MovingPoint& point, double s) {
    const std::span<const double> knots(x_.data() + program_.layout().first_arc_length,
                                        static_cast<std::size_t>(force_count()));
    point.move(backbone(), chain().piece_at(s, knots), s);
  }
  /// n . dP/dq of a point that was placed.
  Eigen::RowVectorXd row(const MovingPoint& point, Vec2 n) const {
    Eigen::RowVectorXd out = Eigen::RowVectorXd::Zero(size());
    program_.backbone().row_before(point.piece(), point.position(), n, out.data());
    point.own_row(n, false, out.data() + point.piece() * chain().functions());
    return out;
  }
  /// dP/ds_k of a point of fixed arc length at frozen coordinates.
  Vec2 rate(const MovingPoint& point, int k) const {
    const int j = point.piece();
    Vec2 sum{};
    for (int i = 0; i < j; ++i) sum += chain().length_rate()(i, k) * program_.backbone().chord(i);
    sum += chain().length_rate()(j, k) * point.chord();
    return sum - (chain().start_rate()(j, k) + point.sigma() * chain().length_rate()(j, k)) * point.tangent();
  }

 private:
  static PoseProgramSpec spec(const Rod& rod, const LegendreBasis& basis, const std::vector<int>& stretches,
                              double turn) {
    PoseProgramSpec out;
    out.rod = &rod;
    out.model = &basis;
    out.nodes = suggested_nodes(basis.function_count(), turn);
    for (const int stretch : stretches) out.contacts.push_back({ContactSetup::along_normal, false, stretch});
    return out;
  }
  int size() const { return chain().coordinate_count(); }

  PoseProgram program_;
  Eigen::VectorXd x_;
};

LoadedRod::LoadedRod(const Rod& rod, std::vector<double> moments, int order, double turn)
    : rod_(rod), moments_(std::move(moments)), basis_(order), turn_(turn), knots_(rod.fixed_knots()) {
  if (moments_.size() != rod_.actuators.size()) throw Error("one moment per actuator is needed");
  // Moments are given: no limit applies, and a limit of zero must not remove an actuator.
  for (Rod::Actuator& a : rod_.actuators) {
    a.minimum = -infinity;
    a.maximum = infinity;
  }
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

Eigen::VectorXd LoadedRod::coordinates(std::span<const NormalForce> forces, const Curvature& curvature) const {
  std::vector<double> places;
  places.reserve(forces.size());
  for (const NormalForce& f : forces) places.push_back(f.arc_length);
  return pieces(forces).chain().coordinates_of(curvature, places);
}

LoadedRod::Shape LoadedRod::solve(std::vector<NormalForce> forces, const Curvature& start) const {
  move_apart(forces);
  Eigen::VectorXd q = coordinates(forces, start);
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
  Response out;
  out.coordinate_rates = p.load_rates();
  if (p.force_count() > 0) out.coordinate_rates = -p.jacobian().partialPivLu().solve(out.coordinate_rates).eval();
  const auto count = static_cast<Eigen::Index>(arc_lengths.size());
  out.points.resize(2 * count);
  out.rates.resize(2 * count, out.coordinate_rates.cols());
  MovingPoint point(p.chain());
  for (Eigen::Index m = 0; m < count; ++m) {
    p.place(point, arc_lengths[static_cast<std::size_t>(m)]);
    out.points[2 * m] = point.position().x;
    out.points[2 * m + 1] = point.position().y;
    if (p.force_count() == 0) continue;
    out.rates.row(2 * m) = p.row(point, {1.0, 0.0}) * out.coordinate_rates;
    out.rates.row(2 * m + 1) = p.row(point, {0.0, 1.0}) * out.coordinate_rates;
    for (int k = 0; k < p.force_count(); ++k) {
      const Vec2 rate = p.rate(point, k);
      out.rates(2 * m, 2 * k + 1) += rate.x;
      out.rates(2 * m + 1, 2 * k + 1) += rate.y;
    }
  }
  return out;
}

Eigen::MatrixXd LoadedRod::unit_forces(Pieces& p, std::span<const double> places) {
  MovingPoint point(p.chain());
  Eigen::MatrixXd columns(p.chain().coordinate_count(), static_cast<Eigen::Index>(places.size()));
  for (std::size_t i = 0; i < places.size(); ++i) {
    p.place(point, places[i]);
    columns.col(static_cast<Eigen::Index>(i)) = p.row(point, point.normal()).transpose();
  }
  return columns;
}

Eigen::MatrixXd LoadedRod::influence(const Shape& shape, std::span<const double> arc_lengths,
                                     std::span<const double> places) const {
  Pieces& p = pieces(shape.forces);
  p.move(shape.forces, shape.coordinates);
  const Eigen::MatrixXd rates = -p.jacobian().partialPivLu().solve(unit_forces(p, places));
  MovingPoint point(p.chain());
  Eigen::MatrixXd out(2 * static_cast<Eigen::Index>(arc_lengths.size()), rates.cols());
  for (std::size_t m = 0; m < arc_lengths.size(); ++m) {
    const auto first = 2 * static_cast<Eigen::Index>(m);
    p.place(point, arc_lengths[m]);
    out.row(first) = p.row(point, {1.0, 0.0}) * rates;
    out.row(first + 1) = p.row(point, {0.0, 1.0}) * rates;
  }
  return out;
}

LoadedRod::Imbalance LoadedRod::imbalance(const Curvature& curvature, std::span<const double> places) const {
  Pieces& p = pieces({});
  p.move({}, coordinates({}, curvature));
  const Eigen::VectorXd missing = -p.residual();
  const Eigen::LLT<Eigen::MatrixXd> bending(p.bending());
  return {bending.matrixL().solve(missing), bending.matrixL().solve(unit_forces(p, places))};
}

std::vector<LoadedRod::Point> LoadedRod::points(const Shape& shape, std::span<const double> arc_lengths) const {
  Pieces& p = pieces(shape.forces);
  p.move(shape.forces, shape.coordinates);
  MovingPoint point(p.chain());
  std::vector<Point> out;
  for (const double s : arc_lengths) {
    p.place(point, s);
    out.push_back({point.position(), point.angle(), point.curvature()});
  }
  return out;
}

}  // namespace tendril
