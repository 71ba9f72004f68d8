#include "estimate/loaded_rod.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "nlp/newton.hpp"
#include "program/equations.hpp"
#include "rod/places.hpp"
#include "tendril/error.hpp"

namespace tendril {
namespace {

/// Newton ends when no coordinate moves by more than this (radians), after one step more.
constexpr double newton_tolerance = 1e-11;
constexpr int most_newton_steps = 40;
/// A coordinate never moves by more than this in one step (radians): beyond it the linearization means nothing.
constexpr double longest_newton_step = 1.0;
constexpr Vec2 axes[] = {{1.0, 0.0}, {0.0, 1.0}};

}  // namespace

/// A program whose contacts push along the rod's normal at places and with forces that are given, at one state.
class LoadedRod::Pieces {
 public:
  Pieces(const Rod& rod, const std::vector<double>& moments, const LegendreBasis& basis,
         const std::vector<int>& stretches, double turn)
      : program_(spec(rod, basis, stretches, turn)),
        equations_(Equations::of_equilibrium(program_)),
        x_(Eigen::VectorXd::Zero(program_.variable_count())) {
    for (int k = 0; k < force_count(); ++k) {
      loads_.push_back(program_.force_variable(k));
      loads_.push_back(program_.arc_length_variable(k));
    }
    for (std::size_t a = 0; a < moments.size(); ++a) x_[program_.moment_variable(static_cast<int>(a))] = moments[a];
  }

  const Chain& chain() const { return program_.chain(); }
  /// Of the state moved to.
  const Backbone& backbone() {
    program_.constraints(x_);
    return program_.backbone();
  }
  /// Of the equilibrium, for the coordinates.
  Equations& equations() { return equations_; }
  const Eigen::VectorXd& variables() const { return x_; }
  /// Each force and its place in turn.
  const std::vector<int>& loads() const { return loads_; }

  void move(std::span<const NormalForce> forces, ConstVectorRef coordinates) {
    x_.head(coordinates.size()) = coordinates;
    bool leans = false;
    for (int k = 0; k < force_count(); ++k) {
      const NormalForce& f = forces[static_cast<std::size_t>(k)];
      x_[program_.arc_length_variable(k)] = f.arc_length;
      x_[program_.force_variable(k)] = f.force;
      leans = leans || f.lean != 0.0;
    }
    if (!leans && program_.loads().lean.empty()) return;
    Loads loads = program_.loads();
    loads.lean.clear();
    for (const NormalForce& f : forces) loads.lean.push_back(f.lean);
    program_.set_loads(loads);
  }
  int force_count() const { return program_.layout().forces; }

  /// K of the bending energy q . K q / 2.
  Eigen::MatrixXd bending() {
    Eigen::MatrixXd k = Eigen::MatrixXd::Zero(equations_.size(), equations_.size());
    Eigen::MatrixXd mixed = Eigen::MatrixXd::Zero(equations_.size(), force_count());
    at({}).add_energy_second(1.0, nullptr, {k, mixed, mixed.topRows(0)});
    return k;
  }

  /// Places at arc lengths of the state, ready for their rows. They stay as long as the same ones are asked for.
  const Places& at(std::span<const double> arc_lengths) {
    if (!places_ || !std::equal(arc_lengths.begin(), arc_lengths.end(), asked_.begin(), asked_.end())) {
      asked_.assign(arc_lengths.begin(), arc_lengths.end());
      places_.emplace(*program_.spec().rod, chain(), force_count());
      for (const double s : asked_) places_->add_fixed(s);
    }
    places_->move(x_.head(equations_.size()),
                  {x_.data() + program_.layout().first_arc_length, static_cast<std::size_t>(force_count())});
    places_->differentiate();
    return *places_;
  }
  /// n . dP of a place: by the coordinates, and at frozen ones by the arc length of each force.
  std::pair<Eigen::RowVectorXd, Eigen::RowVectorXd> row(int place, Vec2 n) const {
    std::pair<Eigen::RowVectorXd, Eigen::RowVectorXd> out;
    out.first.setZero(equations_.size());
    out.second.setZero(force_count());
    places_->row(place, n, {out.first.data(), out.second.data()});
    return out;
  }
  /// Of its angle, by the coordinates.
  Eigen::RowVectorXd angle_row(int place) const {
    Eigen::RowVectorXd out = Eigen::RowVectorXd::Zero(equations_.size());
    Eigen::RowVectorXd along = Eigen::RowVectorXd::Zero(force_count());
    places_->angle_row(place, {out.data(), along.data()});
    return out;
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
  PoseProgram program_;
  Equations equations_;
  Eigen::VectorXd x_;
  std::vector<int> loads_;
  std::vector<double> asked_;
  std::optional<Places> places_;
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
  const auto correct = [&](const Eigen::VectorXd& q, Eigen::VectorXd& step) {
    p.move(shape.forces, q);
    if (!p.equations().evaluate(p.variables())) return infinity;
    step = -p.equations().factor().solve(p.equations().residual());
    return step.lpNorm<Eigen::Infinity>();
  };
  // The simplified next step tells whether this one helps (natural level function).
  const auto share = [&](const Eigen::VectorXd& q, const Eigen::VectorXd& step, double size) {
    for (double part = std::min(1.0, longest_newton_step / size); part >= 1e-4; part *= 0.5) {
      p.move(shape.forces, q + part * step);
      const Eigen::VectorXd& residual = p.equations().residual_at(p.variables());
      const double next = p.equations().factors().solve(residual).lpNorm<Eigen::Infinity>();
      if (size <= 1e-8 || (std::isfinite(next) && next <= (1.0 - 0.25 * part) * size)) return part;
    }
    return 0.0;
  };
  Eigen::VectorXd step;
  const NewtonOutcome outcome =
      tendril::newton(shape.coordinates, step, most_newton_steps, newton_tolerance, correct, share);
  shape.converged = outcome.converged;
  shape.iterations = outcome.steps;
  return shape;
}

LoadedRod::Response LoadedRod::response(const Shape& shape, std::span<const double> arc_lengths) const {
  Pieces& p = pieces(shape.forces);
  p.move(shape.forces, shape.coordinates);
  Response out;
  p.equations().evaluate(p.variables());
  p.equations().factor();
  p.equations().find_rates(p.variables(), p.loads(), out.coordinate_rates);
  const Places& at = p.at(arc_lengths);
  out.points.resize(2 * at.count());
  out.rates.resize(2 * at.count(), out.coordinate_rates.cols());
  for (int m = 0; m < at.count(); ++m) {
    out.points.segment<2>(2 * m) << at.point(m).x, at.point(m).y;
    for (const int axis : {0, 1}) {
      const auto [row, slide] = p.row(m, axes[axis]);
      out.rates.row(2 * m + axis) = row * out.coordinate_rates;
      for (int k = 0; k < p.force_count(); ++k) out.rates(2 * m + axis, 2 * k + 1) += slide[k];
    }
  }
  return out;
}

Eigen::MatrixXd LoadedRod::unit_forces(Pieces& p, std::span<const NormalForce> places, double normal) {
  std::vector<double> arc_lengths;
  arc_lengths.reserve(places.size());
  for (const NormalForce& f : places) arc_lengths.push_back(f.arc_length);
  const Places& at = p.at(arc_lengths);
  Eigen::MatrixXd columns(p.chain().coordinate_count(), at.count());
  for (int i = 0; i < at.count(); ++i) {
    const NormalForce& f = places[static_cast<std::size_t>(i)];
    const Vec2 t = at.tangent(i);
    columns.col(i) = p.row(i, normal * turned(t) + f.lean * t).first.transpose();
    if (f.lean == 0.0 || !p.chain().is_thick()) continue;
    // It acts on the surface of the body.
    const double arm = f.force < 0.0 ? -at.radius(i).value : at.radius(i).value;
    columns.col(i) += arm * f.lean * p.angle_row(i).transpose();
  }
  return columns;
}

Eigen::MatrixXd LoadedRod::answer(Pieces& p, const Eigen::MatrixXd& forces, std::span<const double> arc_lengths) {
  const Eigen::MatrixXd rates = -p.equations().factor().solve(forces);
  const Places& at = p.at(arc_lengths);
  Eigen::MatrixXd out(2 * at.count(), rates.cols());
  for (int m = 0; m < at.count(); ++m) {
    for (const int axis : {0, 1}) out.row(2 * m + axis) = p.row(m, axes[axis]).first * rates;
  }
  return out;
}

Eigen::MatrixXd LoadedRod::influence(const Shape& shape, std::span<const double> arc_lengths,
                                     std::span<const NormalForce> places) const {
  Pieces& p = pieces(shape.forces);
  p.move(shape.forces, shape.coordinates);
  p.equations().evaluate(p.variables());
  return answer(p, unit_forces(p, places), arc_lengths);
}

Eigen::MatrixXd LoadedRod::lean_rates(const Shape& shape, std::span<const double> arc_lengths) const {
  Pieces& p = pieces(shape.forces);
  p.move(shape.forces, shape.coordinates);
  p.equations().evaluate(p.variables());
  std::vector<NormalForce> along = shape.forces;
  for (NormalForce& f : along) f.lean = f.force;
  return answer(p, unit_forces(p, along, 0.0), arc_lengths);
}

LoadedRod::Imbalance LoadedRod::imbalance(const Curvature& curvature, std::span<const NormalForce> places) const {
  Pieces& p = pieces({});
  p.move({}, coordinates({}, curvature));
  const Eigen::VectorXd missing = -p.equations().residual_at(p.variables());
  const Eigen::LLT<Eigen::MatrixXd> bending(p.bending());
  return {bending.matrixL().solve(missing), bending.matrixL().solve(unit_forces(p, places))};
}

std::vector<LoadedRod::Point> LoadedRod::points(const Shape& shape, std::span<const double> arc_lengths) const {
  Pieces& p = pieces(shape.forces);
  p.move(shape.forces, shape.coordinates);
  const Places& at = p.at(arc_lengths);
  std::vector<Point> out;
  out.reserve(arc_lengths.size());
  for (int i = 0; i < at.count(); ++i) out.push_back({at.point(i), at.angle(i), at.side(i, 0).curvature});
  return out;
}

}  // namespace tendril
