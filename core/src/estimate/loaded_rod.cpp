#include "estimate/loaded_rod.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <list>
#include <utility>

#include "nlp/newton.hpp"
#include "tendril/error.hpp"

namespace tendril {
namespace {

/// Newton ends when no coordinate moves by more than this (radians), after one step more.
constexpr double newton_tolerance = 1e-9;
constexpr int most_newton_steps = 40;
/// A coordinate never moves by more than this in one step (radians): beyond it the linearization means nothing.
constexpr double longest_newton_step = 0.5;
/// Loads grow by this share at a time, and by no less than the other one.
constexpr double first_share = 0.25;
constexpr double least_share = 1.0 / 128.0;
constexpr std::span<const NormalForce> nothing;
constexpr Vec2 axes[] = {{1.0, 0.0}, {0.0, 1.0}};

/// Whatever bends or stretches it by a generalized force that is constant where no knot moves is an actuator: those of
/// the rod, the axial force alone of each of them, and each segment's rest curvature, whose moment is EI. Its point
/// loads only say where forces act, not which.
Rod acted_on(Rod rod) {
  const std::vector<Rod::Actuator> own = rod.actuators;
  for (const Rod::Actuator& a : own) {
    rod.actuators.push_back({.from = a.from, .to = a.to, .thrust = 1.0, .profile = {{a.from, a.to, {0.0}}}});
  }
  for (const Rod::Segment& s : rod.segments) {
    ProfilePart part{s.from, s.to, {s.stiffness}};
    double power = 1.0;
    for (const double c : s.more_stiffness) part.coefficients.push_back(c / (power *= s.to - s.from));
    rod.actuators.push_back({.from = s.from, .to = s.to, .profile = {std::move(part)}});
  }
  for (Rod::Load& load : rod.loads) {
    if (!load.at_point()) continue;
    load.force = {};
    load.weight = 0.0;
  }
  return rod;
}

}  // namespace

/// The rod cut at normal forces in given stretches, at one state of it.
class LoadedRod::Pieces {
 public:
  Pieces(const LoadedRod& owner, const std::vector<int>& stretches)
      : rod_(acted_on(owner.rod_)),
        actuators_(static_cast<int>(owner.rod_.actuators.size())),
        chain_(rod_, owner.basis_, stretches, suggested_nodes(owner.order(), owner.turn_)),
        places_(rod_, chain_, static_cast<int>(stretches.size())) {
    const int n = chain_.coordinate_count();
    for (int k = 0; k < chain_.knot_count(); ++k) knots_.push_back(places_.add_knot(chain_.piece_before_knot(k)));
    for (const Rod::Load& load : rod_.loads) {
      if (!load.at_point()) continue;
      int piece = -1;
      while (piece + 1 < chain_.piece_count() && begin_of(piece + 1) < load.to - knot_merge_distance) ++piece;
      loads_.push_back(piece < 0 ? -1 : places_.add_knot(piece));
    }
    tip_ = places_.add_tip();
    forces_.on.resize(static_cast<std::size_t>(places_.count()));
    actions_.setZero(n, static_cast<Eigen::Index>(rod_.actuators.size()));
    strengths_.setZero(actions_.cols());
    factors_.setOnes(n);
    energy_.setZero(n);
    residual_.setZero(n);
    hessian_.setZero(n, n);
    arc_lengths_.resize(stretches.size());
    by_place_.setZero(n, force_count());
    if (arc_lengths_.empty()) places_.move(residual_, arc_lengths_);
    if (arc_lengths_.empty()) find_actions();
  }

  const Chain& chain() const { return chain_; }
  const Backbone& backbone() const { return places_.backbone(); }
  int force_count() const { return static_cast<int>(arc_lengths_.size()); }

  void move(const Properties& properties, const Loads& loads, std::span<const NormalForce> forces,
            const Eigen::VectorXd& q) {
    normal_.assign(forces.begin(), forces.end());
    for (std::size_t k = 0; k < normal_.size(); ++k) arc_lengths_[k] = normal_[k].arc_length;
    places_.move(q, arc_lengths_);
    q_ = q;
    if (!arc_lengths_.empty()) find_actions();
    for (std::size_t i = 0; i < loads_.size(); ++i) {
      if (loads_[i] >= 0) forces_.on[static_cast<std::size_t>(loads_[i])] = loads.at[i];
    }
    forces_.on[static_cast<std::size_t>(tip_)] = loads.tip;
    forces_.gravity = properties.density * loads.gravity;
    forces_.dead = {loads.line, 0.0};
    for (int k = 0; k < force_count(); ++k) {
      const NormalForce& f = normal_[static_cast<std::size_t>(k)];
      const Push one = unit_push(k);
      forces_.on[static_cast<std::size_t>(knots_[static_cast<std::size_t>(k)])] = {f.force * one.force,
                                                                                   f.force * one.moment};
    }
    strengths_ << loads.moments, loads.thrusts, properties.stiffness.cwiseProduct(properties.rest_curvature);
    for (int j = 0; j < chain_.piece_count(); ++j) {
      const int s = chain_.piece(j).segment;
      factors_.segment(first(j), chain_.bends()).setConstant(properties.stiffness[s]);
      factors_.segment(first(j) + chain_.bends(), chain_.stretches()).setConstant(properties.axial[s]);
    }
  }

  const Eigen::VectorXd& residual() {
    energy_.setZero();
    places_.add_energy_row(-1.0, {energy_.data(), nullptr});
    residual_.noalias() = actions_ * strengths_;
    residual_ += factors_.cwiseProduct(energy_);
    places_.pull_back(forces_, residual_.data());
    return residual_;
  }

  /// Factors the rate at which a displacement is resisted; false: something is no number, or, where it is asked to be
  /// `stable`, that is not positive definite (model.md section 7).
  bool factor(bool stable) {
    if (!residual_.allFinite()) return false;
    places_.differentiate();
    hessian_.setZero();
    by_place_.setZero();
    const SecondPart out{hessian_, by_place_, hessian_.topLeftCorner(0, 0)};
    places_.add_energy_second(-1.0, nullptr, out);
    hessian_ = factors_.asDiagonal() * hessian_;
    by_place_ = factors_.asDiagonal() * by_place_;
    places_.second_pull_back(forces_, nullptr, out);
    for (Eigen::Index a = 0; a < actions_.cols() && force_count() > 0; ++a) {
      if (strengths_[a] != 0.0) places_.add_moment_rates(static_cast<int>(a), strengths_[a], strengths_[a], by_place_);
    }
    for (int k = 0; k < force_count(); ++k) {
      const int place = knots_[static_cast<std::size_t>(k)];
      const NormalForce& f = normal_[static_cast<std::size_t>(k)];
      const Eigen::VectorXd turning = angle_row(places_, place);
      hessian_ += row(places_, place, turned(forces_.on[static_cast<std::size_t>(place)].force)) * turning.transpose();
      if (f.lean != 0.0) by_place_.col(k) += f.force * f.lean * side(f) * places_.radius(place).slope * turning;
    }
    hessian_ = -hessian_;
    stable_ = stable;
    if (stable) {
      cholesky_.compute(hessian_);
      return cholesky_.info() == Eigen::Success;
    }
    lu_.compute(hessian_);
    return true;
  }
  Eigen::MatrixXd follow(const Eigen::MatrixXd& forces) const {
    if (forces.cols() == 0) return forces;  // Eigen would refer to the first of its numbers
    return stable_ ? Eigen::MatrixXd(cholesky_.solve(forces)) : Eigen::MatrixXd(lu_.solve(forces));
  }

  /// Generalized forces by each normal force and its place in turn, after factor().
  Eigen::MatrixXd by_forces() const {
    Eigen::MatrixXd out(q_.size(), 2 * force_count());
    for (int k = 0; k < force_count(); ++k) {
      const Push one = unit_push(k);
      const int place = knots_[static_cast<std::size_t>(k)];
      out.col(2 * k) = row(places_, place, one.force) + one.moment * angle_row(places_, place);
      out.col(2 * k + 1) = by_place_.col(k);
    }
    return out;
  }

  /// Places at arc lengths of the state, ready for their rows. The two that were asked for last stay: those of points
  /// and of contacts are asked for in turn.
  const Places& at(std::span<const double> arc_lengths) {
    const auto found = std::find_if(seen_.begin(), seen_.end(), [&](const Seen& s) {
      return std::equal(arc_lengths.begin(), arc_lengths.end(), s.asked.begin(), s.asked.end());
    });
    if (found != seen_.end()) {
      seen_.splice(seen_.begin(), seen_, found);
    } else {
      if (seen_.size() == 2) seen_.pop_back();
      seen_.push_front({{arc_lengths.begin(), arc_lengths.end()}, {rod_, chain_, force_count()}});
      for (const double s : arc_lengths) seen_.front().places.add_fixed(s);
    }
    Places& places = seen_.front().places;
    places.move(q_, arc_lengths_);
    places.differentiate();
    return places;
  }
  /// How places move along x and y in turn, by columns of rates of the coordinates; `by_place`: and at frozen ones with
  /// the arc length of each force, which is every second column.
  Eigen::MatrixXd seen(const Places& at, const Eigen::MatrixXd& rates, bool by_place) const {
    Eigen::MatrixXd out(2 * at.count(), rates.cols());
    Eigen::VectorXd along(force_count());
    for (int m = 0; m < at.count(); ++m) {
      for (const int axis : {0, 1}) {
        Eigen::VectorXd r = Eigen::VectorXd::Zero(q_.size());
        at.row(m, axes[axis], {r.data(), along.data()});
        out.row(2 * m + axis) = r.transpose() * rates;
        for (int k = 0; by_place && k < force_count(); ++k) out(2 * m + axis, 2 * k + 1) += along[k];
      }
    }
    return out;
  }
  /// What forces at places do to the coordinates, one column each: of `normal` along N and, on the side that the
  /// place's force pushes from, its lean along T.
  Eigen::MatrixXd unit_forces(std::span<const NormalForce> forces, double normal) {
    std::vector<double> arc_lengths;
    arc_lengths.reserve(forces.size());
    for (const NormalForce& f : forces) arc_lengths.push_back(f.arc_length);
    const Places& places = at(arc_lengths);
    Eigen::MatrixXd columns(q_.size(), places.count());
    for (int i = 0; i < places.count(); ++i) {
      const NormalForce& f = forces[static_cast<std::size_t>(i)];
      const Vec2 t = places.tangent(i);
      columns.col(i) = row(places, i, normal * turned(t) + f.lean * t);
      if (f.lean != 0.0) columns.col(i) += f.lean * side(f) * places.radius(i).value * angle_row(places, i);
    }
    return columns;
  }

  /// K of the elastic energy q . K q / 2.
  Eigen::MatrixXd elastic() const {
    const auto n = q_.size();
    Eigen::MatrixXd k = Eigen::MatrixXd::Zero(n, n);
    Eigen::MatrixXd mixed = Eigen::MatrixXd::Zero(n, force_count());
    places_.add_energy_second(1.0, nullptr, {k, mixed, mixed.topRows(0)});
    return k;
  }
  /// Generalized forces at factors and additions of `properties`, per unit of a number; after residual().
  Eigen::VectorXd by(Number number, int index, const Properties& properties) {
    Eigen::VectorXd out = Eigen::VectorXd::Zero(q_.size());
    Forces forces;
    switch (number) {
      case Number::moment:
        return actions_.col(index);
      case Number::thrust:
        return actions_.col(actuators_ + index);
      case Number::rest_curvature:
        return properties.stiffness[index] * actions_.col(2 * actuators_ + index);
      case Number::stiffness:
        out = properties.rest_curvature[index] * actions_.col(2 * actuators_ + index);
        add_elastic(index, 0, chain_.bends(), out);
        return out;
      case Number::axial_stiffness:
        add_elastic(index, chain_.bends(), chain_.stretches(), out);
        return out;
      case Number::density:
        forces.gravity = (1.0 / properties.density) * forces_.gravity;
        break;
      case Number::base_angle:
        // Seen from the base, all fixed forces turn back.
        for (const Push& push : forces_.on) forces.on.push_back({-turned(push.force)});
        forces.gravity = -turned(forces_.gravity);
        break;
    }
    places_.pull_back(forces, out.data());
    return out;
  }

 private:
  int first(int piece) const { return piece * chain_.functions(); }
  /// The fixed knot before a piece.
  double begin_of(int piece) const {
    return chain_.fixed_knots()[static_cast<std::size_t>(chain_.piece(piece).stretch)];
  }
  /// The elastic forces of a segment at factors of 1, on `count` coordinates of each piece.
  void add_elastic(int segment, int from, int count, Eigen::VectorXd& out) const {
    for (int j = 0; j < chain_.piece_count(); ++j) {
      if (chain_.piece(j).segment == segment) {
        out.segment(first(j) + from, count) += energy_.segment(first(j) + from, count);
      }
    }
  }
  void find_actions() {
    if (actions_known_ && !chain_.has_moving_work()) return;
    actions_.setZero();
    for (Eigen::Index a = 0; a < actions_.cols(); ++a) {
      places_.pull_back_moment(static_cast<int>(a), 1.0, 1.0, actions_.col(a).data());
    }
    actions_known_ = true;
  }
  Eigen::VectorXd row(const Places& places, int place, Vec2 n) const {
    Eigen::VectorXd q = Eigen::VectorXd::Zero(q_.size()), s(force_count());
    places.row(place, n, {q.data(), s.data()});
    return q;
  }
  Eigen::VectorXd angle_row(const Places& places, int place) const {
    Eigen::VectorXd q = Eigen::VectorXd::Zero(q_.size()), s(force_count());
    places.angle_row(place, {q.data(), s.data()});
    return q;
  }
  /// The side of the body that it pushes from.
  static double side(const NormalForce& f) { return f.force < 0.0 ? -1.0 : 1.0; }
  /// Of a normal force of 1, on the surface of the body.
  Push unit_push(int k) const {
    const int place = knots_[static_cast<std::size_t>(k)];
    const NormalForce& f = normal_[static_cast<std::size_t>(k)];
    const Vec2 t = places_.tangent(place);
    return {turned(t) + f.lean * t, f.lean * side(f) * places_.radius(place).value};
  }

  Rod rod_;
  int actuators_;
  Chain chain_;
  Places places_;
  std::vector<int> knots_;
  std::vector<int> loads_;  ///< place of each point load; -1: it acts on the base
  int tip_ = 0;
  bool actions_known_ = false;
  Eigen::MatrixXd actions_;  ///< generalized forces per unit of each action
  Eigen::VectorXd strengths_, factors_, energy_, residual_, q_;
  std::vector<NormalForce> normal_;
  std::vector<double> arc_lengths_;
  Forces forces_;
  Eigen::MatrixXd hessian_, by_place_;
  bool stable_ = false;
  Eigen::LLT<Eigen::MatrixXd> cholesky_;
  Eigen::PartialPivLU<Eigen::MatrixXd> lu_;
  struct Seen {
    std::vector<double> asked;
    Places places;
  };
  std::list<Seen> seen_;
};

LoadedRod::LoadedRod(const Rod& rod, const std::vector<double>& moments, int order, double turn)
    : rod_(rod), basis_(order), turn_(turn), knots_(rod.fixed_knots()) {
  const auto segments = static_cast<Eigen::Index>(rod.segments.size());
  properties_ = {Eigen::VectorXd::Ones(segments), Eigen::VectorXd::Ones(segments), Eigen::VectorXd::Zero(segments)};
  set_moments(moments);
  loads_.thrusts.setZero(loads_.moments.size());
  loads_.gravity = rod.gravity;
  for (const Rod::Load& l : rod.loads) {
    if (l.at_point()) loads_.at.push_back({l.force + l.weight * rod.gravity});
  }
  loads_.tip = {rod.tip_force + rod.payload * rod.gravity};
}

LoadedRod::~LoadedRod() = default;

void LoadedRod::set(const Properties& properties, const Loads& loads) {
  properties_ = properties;
  loads_ = loads;
}

void LoadedRod::set_moments(std::span<const double> moments) {
  if (moments.size() != rod_.actuators.size()) throw Error("one moment per actuator is needed");
  loads_.moments = Eigen::Map<const Eigen::VectorXd>(moments.data(), static_cast<Eigen::Index>(moments.size()));
}

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
  if (!entry) entry = std::make_unique<Pieces>(*this, key);
  return *entry;
}

LoadedRod::Pieces& LoadedRod::pieces(const Shape& shape) const {
  Pieces& p = pieces(shape.forces);
  p.move(properties_, loads_, shape.forces, shape.coordinates);
  return p;
}

const Chain& LoadedRod::chain() const { return pieces(nothing).chain(); }

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
  return [backbone = pieces(shape).backbone()](double s) { return backbone.at(s).curvature; };
}

LoadedRod::Shape LoadedRod::newton(std::vector<NormalForce> forces, Eigen::VectorXd coordinates, bool stable) const {
  ++solves_;
  Pieces& p = pieces(forces);
  Shape shape{std::move(forces), std::move(coordinates)};
  const auto residual = [&](const Eigen::VectorXd& q) -> const Eigen::VectorXd& {
    p.move(properties_, loads_, shape.forces, q);
    return p.residual();
  };
  const auto correct = [&](const Eigen::VectorXd& q, Eigen::VectorXd& step) {
    residual(q);
    if (!p.factor(stable)) return infinity;
    step = p.follow(p.residual());
    return step.lpNorm<Eigen::Infinity>();
  };
  // The simplified next step tells whether this one helps (natural level function).
  const auto share = [&](const Eigen::VectorXd& q, const Eigen::VectorXd& step, double size) {
    for (double part = std::min(1.0, longest_newton_step / size); part >= 1e-4; part *= 0.5) {
      if (size <= 1e-8) return part;
      const double next = p.follow(residual(q + part * step)).lpNorm<Eigen::Infinity>();
      if (std::isfinite(next) && next <= (1.0 - 0.25 * part) * size) return part;
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

bool LoadedRod::settle(Eigen::VectorXd& q) const {
  Shape shape = newton({}, q, true);
  if (shape.converged) q = std::move(shape.coordinates);
  return shape.converged;
}

bool LoadedRod::load_up(Eigen::VectorXd& q) {
  const Loads whole = loads_;
  const auto carry = [&](double share) {
    loads_.moments = share * whole.moments;
    loads_.thrusts = share * whole.thrusts;
    loads_.gravity = share * whole.gravity;
    loads_.line = share * whole.line;
    const auto part = [share](const Push& push) { return Push{share * push.force, share * push.moment}; };
    std::transform(whole.at.begin(), whole.at.end(), loads_.at.begin(), part);
    loads_.tip = part(whole.tip);
  };
  // Without loads the equations are linear.
  carry(0.0);
  q.setZero(size());
  if (stand(q)) q = follow(pieces(Shape{{}, q}).residual());
  double reached = 0.0;
  double share = first_share;
  while (reached < 1.0 && share >= least_share) {
    const double next = std::min(1.0, reached + share);
    carry(next);
    if (settle(q)) {
      reached = next;
    } else {
      share *= 0.5;
    }
  }
  loads_ = whole;
  return reached == 1.0;
}

bool LoadedRod::stand(const Eigen::VectorXd& q) const {
  Pieces& p = pieces(Shape{{}, q});
  p.residual();
  return p.factor(true);
}

LoadedRod::Pieces& LoadedRod::factored(const Shape& shape) const {
  Pieces& p = pieces(shape);
  p.residual();
  p.factor(false);
  return p;
}

Eigen::VectorXd LoadedRod::force_by(Number number, int index) const {
  return pieces(nothing).by(number, index, properties_);
}

Eigen::VectorXd LoadedRod::follow(const Eigen::VectorXd& force) const { return pieces(nothing).follow(force); }

LoadedRod::Response LoadedRod::response(const Shape& shape, std::span<const double> arc_lengths) const {
  Pieces& p = factored(shape);
  Response out;
  out.coordinate_rates = p.follow(p.by_forces());
  const Places& at = p.at(arc_lengths);
  out.points.resize(2 * at.count());
  for (int m = 0; m < at.count(); ++m) out.points.segment<2>(2 * m) << at.point(m).x, at.point(m).y;
  out.rates = p.seen(at, out.coordinate_rates, true);
  return out;
}

Eigen::MatrixXd LoadedRod::influence(const Shape& shape, std::span<const double> arc_lengths,
                                     std::span<const NormalForce> places) const {
  Pieces& p = factored(shape);
  const Eigen::MatrixXd rates = p.follow(p.unit_forces(places, 1.0));
  return p.seen(p.at(arc_lengths), rates, false);
}

Eigen::MatrixXd LoadedRod::lean_rates(const Shape& shape, std::span<const double> arc_lengths) const {
  Pieces& p = factored(shape);
  std::vector<NormalForce> along = shape.forces;
  for (NormalForce& f : along) f.lean = f.force;
  const Eigen::MatrixXd rates = p.follow(p.unit_forces(along, 0.0));
  return p.seen(p.at(arc_lengths), rates, false);
}

LoadedRod::Imbalance LoadedRod::imbalance(const Curvature& curvature, std::span<const NormalForce> places) const {
  Pieces& p = pieces(Shape{{}, coordinates({}, curvature)});
  const Eigen::LLT<Eigen::MatrixXd> elastic(p.elastic());
  const Eigen::VectorXd missing = -p.residual();
  Eigen::MatrixXd by_places = p.unit_forces(places, 1.0);
  if (by_places.cols() > 0) elastic.matrixL().solveInPlace(by_places);
  return {elastic.matrixL().solve(missing), by_places};
}

std::vector<LoadedRod::Point> LoadedRod::points(const Shape& shape, std::span<const double> arc_lengths) const {
  const Places& at = pieces(shape).at(arc_lengths);
  std::vector<Point> out;
  out.reserve(arc_lengths.size());
  for (int i = 0; i < at.count(); ++i) out.push_back({at.point(i), at.angle(i), at.side(i, 0).curvature});
  return out;
}

}  // namespace tendril
