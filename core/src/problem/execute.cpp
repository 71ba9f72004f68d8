#include "tendril/execute.hpp"

#include <algorithm>
#include <cmath>

#include "base/deadline.hpp"
#include "certificate/certifier.hpp"
#include "certificate/clearance.hpp"
#include "problem/calibrated_range.hpp"
#include "problem/friction.hpp"
#include "problem/way.hpp"
#include "rod/self_overlap.hpp"
#include "scene/make_rod.hpp"
#include "scene/plan_report.hpp"
#include "scene/start_shape.hpp"
#include "statics/loading.hpp"
#include "tendril/coordinate_model.hpp"
#include "tendril/numbers.hpp"
#include "tendril/scale.hpp"
#include "tendril/tolerances.hpp"

namespace tendril {
namespace {

class Executor {
 public:
  Executor(const Scene& scene, const std::vector<std::unique_ptr<Obstacle>>& obstacles, const std::vector<double>& held,
           const ExecuteControl& control)
      : scene_(scene), held_(held), control_(control), deadline_(control.stop, control.time_limit) {
    validate(scene);
    scale_ = scale_of(scene);
    names_ = obstacle_names(scene);
    rod_ = make_rod(scene, scale_);
    move_rod();
    if (rod_.stretches()) rod_.stretch_order = Rod::stretch_as_fine;
    start_ = start_curvature(scene, scale_, rod_);
    if (held.size() != scene.rod.actuators.size()) {
      throw Error("expected " + std::to_string(scene.rod.actuators.size()) + " moments, one per actuator, found " +
                  std::to_string(held.size()));
    }
    for (std::size_t a = 0; a < held.size(); ++a) {
      if (!std::isfinite(held[a])) throw Error("expected finite moments, found " + shown(held[a]));
      last_.moments.push_back(dimensionless(a, held[a]));
    }
    if (!control.with_obstacles) return;
    if (obstacles.size() != scene.obstacles.size()) throw Error("one shape per obstacle is needed");
    if (!control.friction.empty() && control.friction.size() != obstacles.size()) {
      throw Error("expected " + std::to_string(obstacles.size()) + " ratios of friction, one per obstacle, found " +
                  std::to_string(control.friction.size()));
    }
    for (const std::unique_ptr<Obstacle>& obstacle : obstacles) obstacles_.push_back(obstacle.get());
    require_free_base(scene, rod_, obstacles_, scale_);
  }

  Execution run();

 private:
  /// Makes what is asked to move something that moves, and says where to.
  void move_rod();
  /// What actuator a is held at.
  double dimensionless(std::size_t a, double held) const {
    const ActuatorSpec& actuator = scene_.rod.actuators[a];
    return actuator.by_length ? round_to_12_digits(held / std::abs(actuator.largest_offset()))
                              : scale_.to_dimensionless(held, dimension::moment);
  }
  State earlier_state() const;
  /// Where the start lies inside of obstacles; empty if it does not.
  std::string overlaps(const Loading& loading) const;
  void report(Tracker& tracker, bool arrived, Execution& out);
  /// The part of a report that concerns the shape alone.
  void report_shape(const PoseProgram& program, const Eigen::VectorXd& x, Execution& out);
  void report(const Loading::Lying& lying, const LoadPath& path, Execution& out);
  Snap to_si(TrackedSnap& snap) const;
  /// Of the actuators of the scene, N m.
  std::vector<double> moments_at(Settled& at) const;
  /// Those of tendons that are held by their length.
  void keep_tensions(Settled& at, Plan& plan) const;
  /// Contacts stick and slip at the coefficients of the scene.
  bool is_rough() const { return control_.with_obstacles && control_.with_friction && control_.friction.empty(); }
  std::vector<double> coefficients() const;
  /// Whether contacts that slip in the state reached do so against their friction, along the path that led there.
  void judge_slips(Settled& end, Plan& plan) const;
  /// How a contact of the earlier result sticks or slips.
  void set_friction(const PlannedContact& c, PointContact& p) const;
  /// What of the scene's friction this path has not, and what there is not under it.
  void tell_friction(const Loading& loading, Plan& plan) const;
  /// Moments or lengths that are held beyond their limits, and tensions that follow: told, not refused.
  void tell_limits(Plan& plan) const;

  const Scene& scene_;
  const std::vector<double>& held_;
  const ExecuteControl& control_;
  Deadline deadline_;
  Scale scale_;
  Rod rod_;
  std::vector<std::string> names_;
  std::vector<const Obstacle*> obstacles_;
  Loading::Held first_, last_;
  Curvature start_;  ///< of a start by points; empty: it has none
};

void Executor::move_rod() {
  const RodPlace& to = control_.place;
  const RodPlace from = control_.start != nullptr ? control_.start->place : RodPlace{};
  if (to.base || from.base) let_base_move(rod_);
  if ((to.insertion || from.insertion) && !rod_.draws()) {
    rod_.moves.push_back({Rod::Move::Kind::draw, {}, -infinity, infinity});
  }
  first_.moves = moves_of(rod_, scale_, from, rod_.starts());
  last_.moves = moves_of(rod_, scale_, to, first_.moves);
  if (control_.start == nullptr) first_.moves = last_.moves;
  for (const Loading::Held* held : {&first_, &last_}) {
    for (const double m : held->moves) {
      if (!std::isfinite(m)) throw Error("expected a finite place of the rod, found " + shown(m));
    }
  }
  if (!rod_.draws()) return;
  hide_inside_port(rod_, last_.moves.back(), scale_);
  // An earlier result may end just before the knot behind which the rod now goes on, or at it.
  const std::vector<double> knots = rod_.fixed_knots();
  double& last = last_.moves.back();
  double& first = first_.moves.back();
  last = std::max(last, knots[0]);
  first = std::clamp(first, knots[0], std::max(last, knots[1] - before_knot));
}

State Executor::earlier_state() const {
  State state;
  state.curvature = curvature_of(*control_.start, scale_.length);
  for (std::size_t a = 0; a < last_.moments.size(); ++a) {
    const double moment = control_.start->moments[a] / scale_.moment();
    if (rod_.actuators[a].by_length && rod_.actuators[a].side() * moment > tolerance::force) {
      state.tendons.push_back({static_cast<int>(a), moment});
    }
  }
  if (!control_.with_obstacles) return state;
  for (const PlannedContact& c : control_.start->contacts) {
    if (!(c.force > tolerance::force * scale_.force())) continue;
    const auto named = std::find(names_.begin(), names_.end(), c.obstacle_name);
    if (named == names_.end()) continue;
    PointContact p;
    p.setup.obstacle = static_cast<int>(named - names_.begin());
    p.setup.at_tip = c.at_tip;
    p.s = c.at_tip ? 1.0 : std::min(1.0, c.arc_length / scale_.length);
    p.force = c.force / scale_.force();
    if (is_rough()) set_friction(c, p);
    state.contacts.push_back(p);
  }
  return state;
}

std::vector<double> Executor::coefficients() const {
  std::vector<double> all;
  for (std::size_t o = 0; o < obstacles_.size(); ++o) all.push_back(friction_of(scene_, o));
  return all;
}

void Executor::set_friction(const PlannedContact& c, PointContact& p) const {
  const double coefficient = friction_of(scene_, static_cast<std::size_t>(p.setup.obstacle));
  if (!(coefficient > 0.0)) return;
  const std::vector<BackbonePoint>& shape = control_.start->backbone;
  const auto beyond = std::find_if(shape.begin(), shape.end() - 1,
                                   [&](const BackbonePoint& point) { return point.s >= p.s * scale_.length; });
  const Vec2 tangent{std::cos(beyond->angle), std::sin(beyond->angle)};
  const double along = dot(turned(c.normal), tangent) < 0.0 ? -1.0 : 1.0;
  p.setup.sticks = c.sticks || c.tangential == 0.0;
  if (!p.setup.sticks) {
    p.setup.lean = along * std::copysign(coefficient, c.tangential);
    return;
  }
  p.shear = along * c.tangential / scale_.force();
  // The point of the obstacle is the backbone's less the body.
  const double height = rod_.radius_at(p.s).value + c.gap / scale_.length;
  p.anchor = {(1.0 / scale_.length) * c.point - height * c.normal, c.normal, p.s, control_.start->tip_angle, -along};
}

Execution Executor::run() {
  Execution out;
  const double begin = now();
  const auto stop = [this] { return deadline_.over(); };
  std::optional<Loading> loading;
  if (control_.start == nullptr) {
    if (start_) {
      // No loads are known that hold such a shape: the rod is let go from it.
      loading.emplace(rod_, obstacles_, start_, last_, stop, true);
    } else {
      loading.emplace(rod_, obstacles_, scene_.start_tip_angle, last_, stop, true);
    }
  } else {
    if (control_.start->backbone.empty()) throw Error("the result to start from has no shape");
    if (control_.start->moments.size() != last_.moments.size())
      throw Error("the result to start from has other actuators");
    const std::vector<double> before = held_of(scene_, *control_.start);
    for (std::size_t a = 0; a < before.size(); ++a) first_.moments.push_back(dimensionless(a, before[a]));
    loading.emplace(rod_, obstacles_, earlier_state(), first_, last_, stop, true);
  }
  if (const auto o = loading->without_side()) {
    throw SceneError(control_.start != nullptr ? "obstacle[" + std::to_string(*o) + "]"
                     : start_                  ? "start.points"
                                               : "start.tip_angle",
                     "the start shape runs through the core of " + names_[*o] +
                         ", so it is on neither side of it: expected a start that passes on one side");
  }
  if (control_.with_obstacles && !control_.friction.empty()) {
    loading->rub(control_.friction,
                 control_.start != nullptr ? ratios_of(*control_.start, obstacles_.size()) : std::vector<double>{});
  }
  if (is_rough()) loading->roughen(coefficients());
  const bool arrived = loading->run();
  for (TrackedSnap& snap : loading->tracker().snaps()) out.snaps.push_back(to_si(snap));
  report(loading->tracker(), arrived, out);
  if (!arrived && loading->tracker().spread() && loading->path().is_rough()) {
    out.result.message += "; along a stretch friction is not followed";
  } else if (!arrived) {
    if (const auto lying = loading->lie()) report(*lying, loading->path(), out);
  }
  if (const std::string inside = overlaps(*loading); !inside.empty()) {
    std::string& message = out.result.message;
    message = inside + (message.empty() ? ", which takes its place as the loads grow" : ": " + message);
  }
  tell_limits(out.result);
  tell_beyond_calibration(scene_, out.result.moments, out.result.turns,
                          control_.place.base ? control_.place.base->angle : scene_.rod.base_angle, "",
                          out.result.notes);
  if (is_rough()) {
    judge_cones(scene_, scale_.force(), out.result);
    judge_slips(loading->tracker().current(), out.result);
  }
  tell_friction(*loading, out.result);
  out.result.start_backbone =
      control_.start != nullptr
          ? control_.start->backbone
          : outline(start_ ? StartShape{start_} : constant_curvature(scene_.start_tip_angle), rod_, scale_.length);
  out.result.seconds_solve = now() - begin - out.result.seconds_certify;
  return out;
}

void Executor::judge_slips(Settled& end, Plan& plan) const {
  if (plan.status != PlanStatus::solved) return;
  const auto [contact, rate] = end.statics->slides_with_friction(end.z);
  if (!(rate > tolerance::friction)) return;
  const auto o = static_cast<std::size_t>(end.statics->contact(contact).obstacle);
  plan.certificate.failures.push_back("the contact with '" + names_[o] + "' slides with its friction, by " +
                                      shown_with_exponent(rate) + " along the path");
  plan.status = PlanStatus::not_converged;
  plan.message = plan.certificate.failures.back();
}

void Executor::tell_friction(const Loading& loading, Plan& plan) const {
  for (const Loading::Overlap& o : loading.overlaps()) {
    if (!is_rough() || !(friction_of(scene_, o.obstacle) > 0.0)) continue;
    plan.left_out.push_back({"friction of '" + names_[o.obstacle] + "'",
                             "while it takes its place contacts push along its normals; they stick from then on"});
  }
  const bool slips = std::any_of(plan.contacts.begin(), plan.contacts.end(),
                                 [](const PlannedContact& c) { return !c.sticks && c.tangential != 0.0; });
  if (is_rough() && slips) {
    plan.left_out.push_back({"energy of contacts that slip",
                             "there is none: the margin of stability is the smallest real part of the eigenvalues"});
  }
}

void Executor::tell_limits(Plan& plan) const {
  double most = 0.0;
  const auto tell = [&](std::size_t a, double over, const std::string& at, const std::string& limit) {
    most = std::max(most, over);
    if (!(over > tolerance::bounds)) return;
    plan.message += (plan.message.empty() ? "" : "; ") + std::string("actuator ") + std::to_string(a + 1) +
                    " is held at " + at + ", beyond its limit of " + limit;
  };
  for (std::size_t a = 0; a < held_.size(); ++a) {
    const ActuatorSpec& actuator = scene_.rod.actuators[a];
    const double moment = actuator.by_length && !plan.moments.empty() ? plan.moments[a] : held_[a];
    if (actuator.by_length) {
      const double limit = held_[a] > actuator.most_shortening ? actuator.most_shortening : actuator.least_shortening;
      const double over = std::max(held_[a] - actuator.most_shortening, actuator.least_shortening - held_[a]);
      tell(a, over / std::abs(actuator.largest_offset()), shown(held_[a]) + " m", shown(limit + 0.0) + " m");
      if (plan.moments.empty()) continue;
    }
    const double limit = moment > actuator.maximum ? actuator.maximum : actuator.minimum;
    const bool pressure = actuator.input() == ActuatorKind::pressure;
    const double unit = pressure ? 1e3 : 1.0;
    const std::string name = pressure ? " kPa" : ' ' + std::string(actuator.effort_dimension().unit);
    tell(a, excess(actuator, moment) / scale_.moment(), shown(actuator.input_of(moment) / unit) + name,
         shown(actuator.input_of(limit) / unit + 0.0) + name);
  }
  for (std::size_t i = 0; i < rod_.moves.size(); ++i) {
    const Rod::Move& m = rod_.moves[i];
    const double over = std::max(m.minimum - last_.moves[i], last_.moves[i] - m.maximum);
    most = std::max(most, over);
    if (!(over > tolerance::bounds)) continue;
    plan.message += (plan.message.empty() ? "" : "; ") +
                    std::string(m.kind == Rod::Move::Kind::draw ? "the insertion" : "the base") +
                    " is held beyond its limits";
  }
  if (!plan.backbone.empty()) plan.certificate.bounds = most;
}

std::string Executor::overlaps(const Loading& loading) const {
  std::string all;
  for (const Loading::Overlap& o : loading.overlaps()) {
    const double depth = 1e3 * scale_.to_si(o.depth, dimension::length);
    all +=
        (all.empty() ? "the start shape lies " : " and ") + shown(depth, 4) + " mm inside '" + names_[o.obstacle] + "'";
  }
  return all;
}

void Executor::report_shape(const PoseProgram& program, const Eigen::VectorXd& x, Execution& out) {
  Plan& plan = out.result;
  plan.order = program.chain().bends();
  out.pieces = program.chain().piece_count();
  plan.coordinates.assign(x.data(), x.data() + program.layout().coordinates);
  plan.place = place_of(program, x, scale_);
  const Vec2 tip = program.backbone().tip();
  plan.tip_x = tip.x * scale_.length;
  plan.tip_y = tip.y * scale_.length;
  plan.tip_angle = program.backbone().tip_angle();
  if (scene_.target.position) plan.target_error = norm(Vec2{plan.tip_x, plan.tip_y} - *scene_.target.position);
  plan.backbone = sampled_backbone(program, scale_.length);
  plan.self_overlap = self_overlap(plan.backbone, scene_.rod.body());
  plan.turns.clear();
  for (std::size_t a = 0; a < held_.size(); ++a) plan.turns.push_back(program.turn_along(static_cast<int>(a)));
}

void Executor::keep_tensions(Settled& at, Plan& plan) const {
  const std::vector<double> moments = moments_at(at);
  for (std::size_t a = 0; a < held_.size(); ++a) {
    if (scene_.rod.actuators[a].by_length) plan.moments[a] = moments[a];
  }
}

std::vector<double> Executor::moments_at(Settled& at) const {
  at.statics->at(at.z);
  std::vector<double> moments = held_;
  for (std::size_t a = 0; a < held_.size(); ++a) moments[a] = at.statics->moment(static_cast<int>(a)) * scale_.moment();
  return moments;
}

void Executor::report(const Loading::Lying& lying, const LoadPath& path, Execution& out) {
  const Descent& down = lying.down;
  Settled at{std::make_unique<Statics>(path, down.basis, std::vector<PointContact>{},
                                       suggested_nodes(down.basis->function_count(), 4.0), down.state.tendons),
             {}};
  at.z = at.statics->point({down.state.curvature, {}, 1.0, down.state.tendons});
  keep_tensions(at, out.result);
  const PoseProgram& program = at.statics->at(at.z);
  Curve curve(program.chain().curve_tables());
  curve.follow(program.backbone());
  std::vector<PlannedContact> contacts;
  const std::span<const double> knots = program.knots(at.statics->variables());
  for (const PointContact& p : down.state.contacts) {
    const auto o = static_cast<std::size_t>(p.setup.obstacle);
    const int j = p.setup.at_tip ? program.chain().piece_count() - 1 : program.chain().piece_at(p.s, knots);
    const double from_start = p.s - program.chain().start(j, knots);
    const Vec2 point = curve.position(j, std::clamp(from_start / program.chain().length(j, knots), 0.0, 1.0));
    const SurfacePoint surface = path.obstacles()[o]->at(point);
    PlannedContact c;
    c.obstacle = p.setup.obstacle;
    c.obstacle_name = names_[o];
    c.at_tip = p.setup.at_tip;
    c.arc_length = p.s * scale_.length;
    c.point = scale_.length * point;
    c.normal = surface.normal;
    c.force = p.force * scale_.force();
    c.gap = (surface.distance - path.rod().radius_at(p.s).value) * scale_.length;
    c.extended = p.extended;
    contacts.push_back(c);
  }
  Plan& plan = out.result;
  plan.contacts = std::move(contacts);
  plan.message += "; carried on to the final loads: between " + shown(lying.first, 4) + " L and " +
                  shown(lying.last, 4) +
                  " L the rod lies on check points, a run of contacts that stands for a distributed force";
  plan.certificate = {};
  plan.certificate.equilibrium = down.gradient;
  plan.certificate.penetration = 0.0;
  for (const Obstacle* o : path.obstacles()) {
    plan.certificate.penetration = std::max(plan.certificate.penetration, certified_depth(curve, *o));
  }
  plan.certificate.failures = {plan.message};
  out.load = 1.0;
  report_shape(program, at.statics->variables(), out);
}

Snap Executor::to_si(TrackedSnap& snap) const {
  Snap s;
  s.kind = snap.kind;
  s.load = snap.load;
  s.stability_after = snap.margin;
  s.moments = moments_at(snap.before);
  const auto record = [&](Settled& at, std::vector<BackbonePoint>& shape, std::vector<PlannedContact>& contacts) {
    const PoseProgram& program = at.statics->at(at.z);
    shape = sampled_backbone(program, scale_.length);
    contacts = planned_contacts(program, names_, scale_);
  };
  record(snap.before, s.before, s.contacts_before);
  record(snap.after, s.after, s.contacts_after);
  return s;
}

void Executor::report(Tracker& tracker, bool arrived, Execution& out) {
  Plan& plan = out.result;
  out.steps = tracker.steps();
  out.contact_changes = tracker.contact_changes();
  out.tendon_changes = tracker.tendon_changes();
  plan.coordinates_name = LegendreBasis::name;
  plan.split_at_contact = true;
  plan.solver_name = "continuation";
  plan.solver.status = arrived ? SolveStatus::converged : SolveStatus::stalled;
  plan.solver.iterations = tracker.steps();
  // Where lengths are held the tensions are those of the state reached.
  plan.moments = held_;
  for (std::size_t a = 0; a < held_.size(); ++a) {
    if (scene_.rod.actuators[a].by_length) plan.moments[a] = 0.0;
  }
  plan.message = tracker.trouble();
  const bool stopped = deadline_.interrupted();
  Settled& end = tracker.current();
  if (end.statics == nullptr) {
    plan.status = stopped            ? PlanStatus::interrupted
                  : deadline_.over() ? PlanStatus::time_limit
                                     : PlanStatus::not_converged;
    return;
  }
  if (arrived) tracker.refine_fully();
  const double begin = now();
  Statics& statics = *end.statics;
  plan.certificate = statics.certify(end.z);
  if (!(plan.certificate.moment_balance <= tolerance::moment_balance)) {
    plan.certificate.failures.push_back("local moment balance " + shown_with_exponent(plan.certificate.moment_balance) +
                                        " is above " + shown_with_exponent(tolerance::moment_balance, 1));
  }
  plan.seconds_certify = now() - begin;
  out.load = end.z[statics.size()];
  if (arrived) {
    const bool valid = plan.certificate.valid();
    plan.status = valid                             ? PlanStatus::solved
                  : only_unstable(plan.certificate) ? PlanStatus::unstable
                                                    : PlanStatus::not_converged;
    if (!valid) plan.message = plan.certificate.failures.front();
  } else if (stopped) {
    plan.status = PlanStatus::interrupted;
    plan.message = "interrupted before the final loads were reached";
  } else if (deadline_.over()) {
    plan.status = PlanStatus::time_limit;
    plan.message = "the time limit of " + shown(control_.time_limit) + " s was reached before the final loads were";
  } else {
    plan.status = PlanStatus::not_converged;
  }
  keep_tensions(end, plan);
  const PoseProgram& program = statics.at(end.z);
  report_shape(program, statics.variables(), out);
  plan.contacts = planned_contacts(program, names_, scale_);
  std::erase_if(plan.contacts, [&](const PlannedContact& c) { return !(c.force > tolerance::force * scale_.force()); });
}

/// Shares of the way from an earlier result at which the port comes to an end of a segment, an actuator or a load, or
/// next to it: there the rod goes on with fewer stretches, or with more. `insertion`: m, where the way begins.
std::vector<double> shares_at_knots(const Scene& scene, const ExecuteControl& control, double insertion) {
  if (control.start == nullptr || !control.place.insertion) return {};
  validate(scene);
  const Scale scale = scale_of(scene);
  const double from = 1.0 - insertion / scale.length;
  const double to = 1.0 - *control.place.insertion / scale.length;
  std::vector<double> shares;
  for (const double knot : make_rod(scene, scale).fixed_knots()) {
    const double stop = to > from ? knot - before_knot : knot;
    if (std::min(from, to) < stop && stop < std::max(from, to) && std::abs(to - knot) > knot_merge_distance)
      shares.push_back((stop - from) / (to - from));
  }
  std::sort(shares.begin(), shares.end());
  return shares;
}

/// A way's next part, between two shares of it.
void add_part(Execution& part, double from, double to, Execution& way) {
  add_snaps(part.snaps, from, to, way.snaps);
  way.load = from + part.load * (to - from);
  way.steps += part.steps;
  way.contact_changes += part.contact_changes;
  way.tendon_changes += part.tendon_changes;
  way.pieces = part.pieces;
  const double solving = way.result.seconds_solve, certifying = way.result.seconds_certify;
  way.result = std::move(part.result);
  way.result.seconds_solve += solving;
  way.result.seconds_certify += certifying;
}

}  // namespace

std::vector<double> held_of(const Scene& scene, const Plan& plan) {
  std::vector<double> held = plan.moments;
  for (std::size_t a = 0; a < std::min(held.size(), scene.rod.actuators.size()); ++a) {
    const ActuatorSpec& actuator = scene.rod.actuators[a];
    if (!actuator.by_length) continue;
    if (a >= plan.turns.size()) throw Error("the result does not say by how much its tendons are shorter");
    held[a] = actuator.held(held[a], plan.turns[a]);
  }
  return held;
}

Execution execute(const Scene& scene, const std::vector<std::unique_ptr<Obstacle>>& obstacles,
                  const std::vector<double>& held, const ExecuteControl& control) {
  ExecuteControl own = control;
  const double first = control.start != nullptr && control.start->place.insertion
                           ? *control.start->place.insertion
                           : scene.rod.length() - scene.rod.drawn_in;
  const std::vector<double> shares = shares_at_knots(scene, control, first);
  Plan state;
  Execution before;
  double done = 0.0;
  for (const double share : shares) {
    std::vector<double> there = held_of(scene, *control.start);
    for (std::size_t a = 0; a < std::min(there.size(), held.size()); ++a) there[a] += share * (held[a] - there[a]);
    own.place = between(control.start->place, control.place, share);
    own.place.insertion = first + share * (*control.place.insertion - first);
    Execution part = Executor(scene, obstacles, there, own).run();
    add_part(part, done, share, before);
    if (before.result.status != PlanStatus::solved) return before;
    state = before.result;
    own.start = &state;
    done = share;
  }
  own.place = control.place;
  Execution last = Executor(scene, obstacles, held, own).run();
  if (shares.empty()) return last;
  add_part(last, done, 1.0, before);
  before.result.start_backbone = control.start->backbone;
  return before;
}

Execution execute(const Scene& scene, const std::vector<std::unique_ptr<Obstacle>>& obstacles, const Plan& plan,
                  const ExecuteControl& control) {
  return execute(scene, obstacles, held_of(scene, plan), control);
}

}  // namespace tendril
