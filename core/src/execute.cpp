#include "tendril/execute.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "clock.hpp"
#include "plan_report.hpp"
#include "tendril/clearance.hpp"
#include "tendril/coordinate_model.hpp"
#include "tendril/planner.hpp"
#include "tendril/rod.hpp"
#include "tendril/scale.hpp"
#include "tendril/self_overlap.hpp"
#include "tendril/tolerances.hpp"
#include "tracker.hpp"

namespace tendril {
namespace {

/// A start nearer to an obstacle's core than this (in L) lies on neither side of it.
constexpr double core_side = 1e-6;
/// Load fraction by which a rod that lies along an obstacle is carried on at a time.
constexpr double longest_load_step = 0.1;

/// Moments that hold a constant curvature against the rod's own stiffness, and what they leave over: one more actuator
/// per stretch whose moment fades as the loads grow.
LoadPath::Ends from_rest(Rod& rod, double curvature, const std::vector<double>& last) {
  const std::vector<double> knots = rod.fixed_knots();
  const auto stretches = static_cast<Eigen::Index>(knots.size()) - 1;
  const auto count = static_cast<Eigen::Index>(last.size());
  Eigen::MatrixXd spans = Eigen::MatrixXd::Zero(stretches, count);
  Eigen::VectorXd wanted(stretches);
  for (Eigen::Index r = 0; r < stretches; ++r) {
    const double middle = 0.5 * (knots[static_cast<std::size_t>(r)] + knots[static_cast<std::size_t>(r) + 1]);
    const Rod::Segment& segment = rod.segment_at(middle);
    wanted[r] = segment.stiffness * (curvature - segment.rest_curvature);
    for (Eigen::Index a = 0; a < count; ++a) {
      const Rod::Actuator& actuator = rod.actuators[static_cast<std::size_t>(a)];
      if (middle > actuator.from && middle < actuator.to) spans(r, a) = 1.0;
    }
  }
  LoadPath::Ends ends;
  Eigen::VectorXd left = wanted;
  if (count > 0) {
    const Eigen::VectorXd u = spans.completeOrthogonalDecomposition().solve(wanted);
    ends.first.assign(u.data(), u.data() + count);
    left -= spans * u;
  }
  ends.last = last;
  for (Eigen::Index r = 0; r < stretches; ++r) {
    if (std::abs(left[r]) <= 1e-14 * (1.0 + wanted.cwiseAbs().maxCoeff())) continue;
    rod.actuators.push_back(
        {knots[static_cast<std::size_t>(r)], knots[static_cast<std::size_t>(r) + 1], -infinity, infinity});
    ends.first.push_back(left[r]);
    ends.last.push_back(0.0);
  }
  return ends;
}

class Executor {
 public:
  Executor(const Scene& scene, const std::vector<std::unique_ptr<Obstacle>>& obstacles,
           const std::vector<double>& moments, const ExecuteControl& control)
      : scene_(scene), moments_(moments), control_(control), deadline_(now() + control.time_limit) {
    validate(scene);
    scale_ = scale_of(scene);
    names_ = obstacle_names(scene);
    rod_ = make_rod(scene, scale_);
    if (moments.size() != scene.rod.actuators.size()) {
      throw Error("expected " + std::to_string(scene.rod.actuators.size()) + " moments, one per actuator, found " +
                  std::to_string(moments.size()));
    }
    for (const double m : moments) {
      if (!std::isfinite(m)) throw Error("expected finite moments, found " + std::to_string(m));
      last_.push_back(scale_.to_dimensionless(m, dimension::moment));
    }
    if (!control.with_obstacles) return;
    if (obstacles.size() != scene.obstacles.size()) throw Error("one shape per obstacle is needed");
    for (std::size_t i = 0; i < obstacles.size(); ++i) {
      obstacles_.push_back(obstacles[i].get());
      const double distance = obstacles_.back()->at(rod_.base).distance;
      if (distance >= 0.0) continue;
      char text[64];
      std::snprintf(text, sizeof text, "%.6g m", -scale_.to_si(distance, dimension::length));
      throw SceneError("obstacle[" + std::to_string(i) + "]",
                       names_[i] + " lies around the rod's base (" + text + " deep): no shape is free of it");
    }
  }

  Execution run();

 private:
  bool must_stop() const { return (control_.stop != nullptr && control_.stop->load()) || now() > deadline_; }
  RodState start_state() const;
  bool grow_overlapped(LoadPath& path, const RodState& start) const;
  void report(Tracker& tracker, bool arrived, Execution& out);
  /// From where no point contact holds the rod to the final loads, with a run of contacts that stands for the stretch
  /// along which it lies.
  void lie(LoadPath& path, Tracker& tracker, Execution& out);
  Snap to_si(TrackedSnap& snap, const LoadPath& path) const;

  const Scene& scene_;
  const std::vector<double>& moments_;
  const ExecuteControl& control_;
  double deadline_;
  Scale scale_;
  Rod rod_;
  std::vector<std::string> names_;
  std::vector<const Obstacle*> obstacles_;
  std::vector<double> last_;
};

RodState Executor::start_state() const {
  RodState state;
  if (control_.start == nullptr) {
    state.curvature = [angle = scene_.start_tip_angle](double) { return angle; };
    return state;
  }
  state.curvature = curvature_of(*control_.start, scale_.length);
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
    state.contacts.push_back(p);
  }
  return state;
}

/// Obstacles that the start overlaps grow with the loads; true if there is any.
bool Executor::grow_overlapped(LoadPath& path, const RodState& start) const {
  path.apply(1.0);
  Statics free(path, std::make_shared<LegendreBasis>(12, 4), {}, suggested_nodes(12, 4.0));
  const Eigen::VectorXd z = free.point({start.curvature, {}, 1.0});
  Curve curve(free.at(z).chain().curve_tables());
  curve.follow(free.at(z).backbone());
  bool any = false;
  for (std::size_t o = 0; o < obstacles_.size(); ++o) {
    const Obstacle& obstacle = *obstacles_[o];
    double deepest = 0.0;
    double core = infinity;
    for (const ClosestApproach& at : closest_approaches(curve, obstacle, 0.0)) {
      deepest = std::min(deepest, at.distance);
      core = std::min(core, obstacle.core_distance(curve.position(at.piece, at.sigma)));
    }
    // A contact of an earlier result is closed to rounding, or to the accuracy of its basis.
    const bool touched = std::any_of(start.contacts.begin(), start.contacts.end(),
                                     [&](const PointContact& c) { return c.setup.obstacle == static_cast<int>(o); });
    if (!(deepest < (touched ? -0.02 : -tolerance::penetration))) continue;
    any = true;
    if (!std::isfinite(obstacle.smallest_radius())) {
      path.grow(o, -deepest);
      continue;
    }
    if (!(core > core_side)) {
      throw SceneError(control_.start != nullptr ? "obstacle[" + std::to_string(o) + "]" : "start.tip_angle",
                       "the start shape runs through the core of " + names_[o] +
                           ", so it is on neither side of it: expected a start that passes on one side");
    }
    path.grow(o, obstacle.rounding());
  }
  return any;
}

Execution Executor::run() {
  Execution out;
  const double begin = now();
  LoadPath::Ends ends;
  bool moves = true;
  if (control_.start == nullptr) {
    ends = from_rest(rod_, scene_.start_tip_angle, last_);
  } else {
    if (control_.start->backbone.empty()) throw Error("the result to start from has no shape");
    if (control_.start->moments.size() != last_.size()) throw Error("the result to start from has other actuators");
    ends.loads_grow = false;
    ends.last = last_;
    for (const double m : control_.start->moments) ends.first.push_back(scale_.to_dimensionless(m, dimension::moment));
    moves = ends.first != ends.last;
  }
  LoadPath path(rod_, obstacles_, ends);
  RodState start = start_state();
  const bool grows = grow_overlapped(path, start);
  if (grows) {
    std::erase_if(start.contacts, [&](const PointContact& c) { return path.distance_rate(c.setup.obstacle) != 0.0; });
  }
  Tracker tracker(path, [this] { return must_stop(); });
  bool arrived = tracker.begin(start, control_.start == nullptr);
  if (arrived && !moves && !grows) {
    // Nothing changes along this path: its beginning is its end.
    Settled& s = tracker.current();
    s.z[s.statics->size()] = 1.0;
  } else if (arrived) {
    arrived = tracker.follow();
  }
  for (TrackedSnap& snap : tracker.snaps()) out.snaps.push_back(to_si(snap, path));
  report(tracker, arrived, out);
  if (!arrived && tracker.spread() && tracker.current().statics != nullptr && !must_stop()) lie(path, tracker, out);
  out.result.start_backbone = control_.start != nullptr
                                  ? control_.start->backbone
                                  : outline(constant_curvature(scene_.start_tip_angle), rod_, scale_.length);
  out.result.seconds_solve = now() - begin - out.result.seconds_certify;
  return out;
}

void Executor::lie(LoadPath& path, Tracker& tracker, Execution& out) {
  Settled& end = tracker.current();
  const double from = end.z[end.statics->size()];
  const int steps = std::max(1, static_cast<int>(std::ceil((1.0 - from) / longest_load_step)));
  std::function<double(double)> curvature = end.statics->state(end.z).curvature;
  Descent down;
  for (int i = 1; i <= steps; ++i) {
    path.apply(i == steps ? 1.0 : from + (1.0 - from) * i / steps);
    down = descend(
        path, curvature, [this] { return must_stop(); }, i == steps);
    if (!down.converged) return;
    curvature = [shape = down.shape](double s) { return shape.curvature(s); };
  }
  Statics statics(path, down.basis, {}, suggested_nodes(down.basis->function_count(), 4.0));
  const Eigen::VectorXd z = statics.point({curvature, {}, 1.0});
  const PoseProgram& program = statics.at(z);
  Curve curve(program.chain().curve_tables());
  curve.follow(program.backbone());
  const std::vector<PressedPoint>& points = down.points;
  const auto lies = [&](std::size_t i) { return points[i].joined || (i + 1 < points.size() && points[i + 1].joined); };
  std::vector<PlannedContact> contacts;
  const std::span<const double> no_knots;
  double first = 1.0;
  double last = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const PressedPoint& p = points[i];
    const auto o = static_cast<std::size_t>(p.obstacle);
    const int j = p.at_tip ? program.chain().piece_count() - 1 : program.chain().piece_at(p.s, no_knots);
    const double from_start = p.s - program.chain().start(j, no_knots);
    const Vec2 point = curve.position(j, std::clamp(from_start / program.chain().length(j, no_knots), 0.0, 1.0));
    const SurfacePoint surface = path.obstacles()[o]->at(point);
    PlannedContact c;
    c.obstacle = p.obstacle;
    c.obstacle_name = names_[o];
    c.at_tip = p.at_tip;
    c.arc_length = p.s * scale_.length;
    c.point = scale_.length * point;
    c.normal = surface.normal;
    c.force = p.force * scale_.force();
    c.gap = surface.distance * scale_.length;
    c.extended = lies(i);
    contacts.push_back(c);
    if (!c.extended) continue;
    first = std::min(first, p.s);
    last = std::max(last, p.s);
  }
  // Beyond the place where it spread the rod may stand on points again; how it came to that is not known.
  if (!(last > first)) return;
  char text[240];
  std::snprintf(text, sizeof text,
                "; carried on to the final loads: between %.4f L and %.4f L the rod lies on check points, a run of "
                "contacts that stands for a distributed force",
                first, last);
  Plan& plan = out.result;
  plan.contacts = std::move(contacts);
  plan.message += text;
  plan.certificate = {};
  plan.certificate.equilibrium = down.gradient;
  plan.certificate.penetration = 0.0;
  for (const Obstacle* o : path.obstacles()) {
    plan.certificate.penetration = std::max(plan.certificate.penetration, certified_depth(curve, *o));
  }
  plan.certificate.failures = {plan.message};
  plan.order = program.chain().functions();
  out.pieces = program.chain().piece_count();
  out.load = 1.0;
  plan.coordinates.assign(z.data(), z.data() + statics.coordinates());
  const Vec2 tip = program.backbone().tip();
  plan.tip_x = tip.x * scale_.length;
  plan.tip_y = tip.y * scale_.length;
  plan.tip_angle = program.backbone().tip_angle();
  if (scene_.target.position) plan.target_error = norm(Vec2{plan.tip_x, plan.tip_y} - *scene_.target.position);
  plan.backbone = sampled_backbone(program, scale_.length);
  plan.self_overlap = self_overlap(plan.backbone);
}

Snap Executor::to_si(TrackedSnap& snap, const LoadPath& path) const {
  Snap s;
  s.kind = snap.kind;
  s.load = snap.load;
  s.stability_after = snap.margin;
  for (std::size_t a = 0; a < last_.size(); ++a) s.moments.push_back(path.moment(a, snap.load) * scale_.moment());
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
  plan.coordinates_name = LegendreBasis::name;
  plan.split_at_contact = true;
  plan.solver_name = "continuation";
  plan.solver.status = arrived ? SolveStatus::converged : SolveStatus::stalled;
  plan.solver.iterations = tracker.steps();
  plan.moments = moments_;
  plan.message = tracker.trouble();
  const bool stopped = control_.stop != nullptr && control_.stop->load();
  Settled& end = tracker.current();
  if (end.statics == nullptr) {
    plan.status = stopped             ? PlanStatus::interrupted
                  : now() > deadline_ ? PlanStatus::time_limit
                                      : PlanStatus::not_converged;
    return;
  }
  if (arrived) tracker.refine_fully();
  const double begin = now();
  Statics& statics = *end.statics;
  plan.certificate = statics.certify(end.z);
  if (!(plan.certificate.moment_balance <= tolerance::moment_balance)) {
    char text[96];
    std::snprintf(text, sizeof text, "local moment balance %.2e is above %.0e", plan.certificate.moment_balance,
                  tolerance::moment_balance);
    plan.certificate.failures.emplace_back(text);
  }
  plan.seconds_certify = now() - begin;
  out.load = end.z[statics.size()];
  if (arrived) {
    const bool valid = plan.certificate.valid();
    const bool unstable =
        !valid && plan.certificate.failures.size() == 1 && !(plan.certificate.stability > tolerance::stability);
    plan.status = valid ? PlanStatus::solved : unstable ? PlanStatus::unstable : PlanStatus::not_converged;
    if (!valid) plan.message = plan.certificate.failures.front();
  } else if (stopped) {
    plan.status = PlanStatus::interrupted;
    plan.message = "interrupted before the final loads were reached";
  } else if (now() > deadline_) {
    plan.status = PlanStatus::time_limit;
    plan.message =
        "the time limit of " + std::to_string(control_.time_limit) + " s was reached before the final loads were";
  } else {
    plan.status = PlanStatus::not_converged;
  }
  const PoseProgram& program = statics.at(end.z);
  const Chain& chain = program.chain();
  plan.order = chain.functions();
  out.pieces = chain.piece_count();
  plan.coordinates.assign(end.z.data(), end.z.data() + statics.coordinates());
  const Vec2 tip = program.backbone().tip();
  plan.tip_x = tip.x * scale_.length;
  plan.tip_y = tip.y * scale_.length;
  plan.tip_angle = program.backbone().tip_angle();
  if (scene_.target.position) plan.target_error = norm(Vec2{plan.tip_x, plan.tip_y} - *scene_.target.position);
  plan.contacts = planned_contacts(program, names_, scale_);
  std::erase_if(plan.contacts, [&](const PlannedContact& c) { return !(c.force > tolerance::force * scale_.force()); });
  plan.backbone = sampled_backbone(program, scale_.length);
  plan.self_overlap = self_overlap(plan.backbone);
}

}  // namespace

std::string_view to_string(SnapKind kind) {
  switch (kind) {
    case SnapKind::fold:
      return "fold";
    case SnapKind::bifurcation:
      return "bifurcation";
    case SnapKind::release:
      return "release";
    case SnapKind::slip:
      return "slip";
    case SnapKind::start:
      return "start";
  }
  return "?";
}

Execution execute(const Scene& scene, const std::vector<std::unique_ptr<Obstacle>>& obstacles,
                  const std::vector<double>& moments, const ExecuteControl& control) {
  return Executor(scene, obstacles, moments, control).run();
}

}  // namespace tendril
