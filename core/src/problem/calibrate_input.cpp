#include "problem/calibrate_input.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "estimate/estimate_fit.hpp"
#include "scene/make_rod.hpp"
#include "tendril/error.hpp"

namespace tendril {
namespace {

/// The weights of a rod whose scene has no gravity are made with that of the earth.
constexpr double standard_gravity = 9.80665;
/// Markers may lie this much further from the base than the rod reaches, in L, and by its own length where it
/// stretches.
constexpr double reach_tolerance = 0.1;
/// Shapes may leave their plane by this much, and are told from the other one on, in L.
constexpr double most_out_of_plane = 0.05;
constexpr double told_out_of_plane = 0.01;

std::string text(double value) { return shown(value, 4); }

std::string counted(std::size_t count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

[[noreturn]] void fail(const Recording& recording, const std::string& message) {
  throw SceneError("calibrate", (recording.place.empty() ? "" : recording.place + ": ") + "recording \"" +
                                    recording.name + "\": " + message);
}

/// How far a shape may turn, as its markers show it; chords show about half of it.
double turn_of(const Rod& rod, const SeenShape& shape) {
  constexpr double most = 30.0;
  MeasuredShape measured;
  double turn = 0.0;
  for (const SeenMarker& m : shape.markers) {
    if (m.has_angle) turn = std::max(turn, std::abs(m.angle - rod.base_angle));
    if (!m.has_position || m.arc_length == 0.0) continue;
    measured.arc_lengths.push_back(m.arc_length);
    measured.points.conservativeResize(measured.points.size() + 2);
    measured.points.tail<2>() << m.position.x, m.position.y;
  }
  return std::min(most, std::max(turn, 2.0 * measured_turn(rod, measured)) + 1.0);
}

Push dimensionless(const Scale& scale, Vec2 force, double moment = 0.0) {
  return {{scale.to_dimensionless(force.x, dimension::force), scale.to_dimensionless(force.y, dimension::force)},
          scale.to_dimensionless(moment, dimension::moment)};
}

}  // namespace

std::string input_name(ActuatorKind kind) {
  return kind == ActuatorKind::tendon ? "tension" : std::string(to_string(kind));
}

std::string input_unit(ActuatorKind kind) {
  return kind == ActuatorKind::tendon ? "N" : kind == ActuatorKind::pressure ? "Pa" : "N m";
}

std::string law_unit(CalibrationUnknown law, ActuatorKind kind, int power) {
  const std::string of = law == CalibrationUnknown::moment ? "N m" : "N";
  if (of == input_unit(kind) && power == 1) return "";
  const std::string unit = kind == ActuatorKind::moment ? "(N m)" : input_unit(kind);
  return of + '/' + unit + (power == 1 ? "" : "^" + std::to_string(power));
}

CalibrationInput::CalibrationInput(const Scene& scene, const CalibrationSpec& spec) {
  validate(scene);
  if (spec.recordings.empty()) throw SceneError("calibrate", "there are no recordings, expected files with some");
  if (spec.unknowns.empty()) throw SceneError("calibrate", "nothing is looked for, expected [[calibrate.unknown]]");
  scale = scale_of(scene);
  Scene weighed = scene;
  gravity_ = scene.gravity && norm(*scene.gravity) > 0.0 ? norm(*scene.gravity) : standard_gravity;
  weighed.gravity = Vec2{gravity_, 0.0};
  problem.rod = make_rod(weighed, scale);
  if (problem.rod.stretches()) problem.rod.stretch_order = Rod::stretch_as_fine;
  // What acts at points and at the tip differs between recordings; here it only says where.
  for (Rod::Load& load : problem.rod.loads) {
    if (!load.at_point()) continue;
    load.force = {};
    load.weight = 0.0;
  }
  problem.rod.payload = 0.0;
  problem.rod.tip_force = {};
  problem.noise = spec.noise / scale.length;
  problem.angle_weight =
      spec.noise > 0.0 && spec.angle_noise > 0.0 ? spec.noise / (spec.angle_noise * scale.length) : 0.5;
  problem.robust = spec.robust;
  add_inputs(scene, spec);
  add_shapes(scene, spec);
  add_unknowns(scene, spec);
  require_one_known_load();
  require_enough(spec);
}

bool CalibrationInput::is_sought(CalibrationUnknown kind) const {
  return std::any_of(problem.unknowns.begin(), problem.unknowns.end(), [&](const Sought& u) { return u.kind == kind; });
}

bool CalibrationInput::is_sought(CalibrationUnknown kind, int index) const {
  return std::any_of(problem.unknowns.begin(), problem.unknowns.end(),
                     [&](const Sought& u) { return u.kind == kind && u.index == index; });
}

/// The largest input of each actuator, and whether recordings agree in what they are.
void CalibrationInput::add_inputs(const Scene& scene, const CalibrationSpec& spec) {
  const std::vector<ActuatorSpec>& actuators = scene.rod.actuators;
  input_sizes_.assign(actuators.size(), 0.0);
  for (const Recording& r : spec.recordings) {
    const auto known_at = [](const ActuatorSpec& a) { return a.minimum == a.maximum; };
    if (r.inputs.empty() && std::all_of(actuators.begin(), actuators.end(), known_at)) continue;
    if (r.inputs.size() != actuators.size() || r.input_kinds.size() != actuators.size()) {
      fail(r, "found what " + counted(r.inputs.size(), "actuator") + " was told, expected one input for each of the " +
                  counted(actuators.size(), "actuator") + " of the rod: a column moment_1, tension_1 or pressure_1");
    }
    for (std::size_t a = 0; a < actuators.size(); ++a) {
      if (!std::isfinite(r.inputs[a])) fail(r, "the input of actuator " + std::to_string(a + 1) + " is not finite");
      if (r.input_kinds[a] != spec.recordings.front().input_kinds[a]) {
        fail(r, "found a " + input_name(r.input_kinds[a]) + " of actuator " + std::to_string(a + 1) + ", expected a " +
                    input_name(spec.recordings.front().input_kinds[a]) + " as in the recordings before");
      }
      input_sizes_[a] = std::max(input_sizes_[a], std::abs(r.inputs[a]));
    }
  }
}

void CalibrationInput::add_shapes(const Scene& scene, const CalibrationSpec& spec) {
  std::map<std::string, int> groups;
  std::map<std::vector<double>, std::string> seen;
  const bool base_per_recording =
      std::any_of(spec.unknowns.begin(), spec.unknowns.end(),
                  [](const CalibrationUnknownSpec& u) { return u.per == CalibrationScope::recording; });
  for (std::size_t i = 0; i < spec.recordings.size(); ++i) {
    const Recording& r = spec.recordings[i];
    SeenShape shape;
    shape.group = base_per_recording ? static_cast<int>(i)
                                     : groups.emplace(r.group, static_cast<int>(groups.size())).first->second;
    const auto actuators = static_cast<Eigen::Index>(scene.rod.actuators.size());
    shape.inputs.setZero(actuators);
    shape.moments.setZero(actuators);
    add_loads(scene, r, shape);
    add_markers(r, shape);
    require_plausible(r, shape);
    std::vector<double> whole;
    for (const Known& k : known.back()) whole.push_back(k.value);
    for (const SeenMarker& m : shape.markers) {
      for (const double v : {m.arc_length, m.position.x, m.position.y, m.angle}) whole.push_back(v);
    }
    if (const auto [other, fresh] = seen.emplace(std::move(whole), r.name); !fresh) {
      warnings.push_back("the recordings \"" + other->second + "\" and \"" + r.name +
                         "\" are the same number by number: errors are smaller than they should be if one was copied");
    }
    turn = std::max(turn, turn_of(problem.rod, shape));
    (r.check_only ? checked : fitted).push_back(static_cast<int>(i));
    problem.shapes.push_back(std::move(shape));
  }
  if (aside_ > told_out_of_plane) {
    warnings.push_back("points lie up to " + text(100.0 * aside_) +
                       " % of the length out of the plane, of which a planar rod knows nothing");
  }
  if (fitted.empty()) throw SceneError("calibrate", "all recordings are only checked, expected some to be fitted");
}

/// What was known of a recording, as loads, and by name.
void CalibrationInput::add_loads(const Scene& scene, const Recording& r, SeenShape& shape) {
  std::vector<Known>& list = known.emplace_back();
  for (std::size_t a = 0; a < scene.rod.actuators.size(); ++a) {
    const ActuatorSpec& actuator = scene.rod.actuators[a];
    const bool told = !r.inputs.empty();
    const ActuatorKind kind = told ? r.input_kinds[a] : ActuatorKind::moment;
    const double input = told ? r.inputs[a] : actuator.minimum;
    list.push_back({input_name(kind) + " of actuator " + std::to_string(a + 1), input_unit(kind), input});
    const auto i = static_cast<Eigen::Index>(a);
    shape.inputs[i] = input_sizes_[a] > 0.0 ? input / input_sizes_[a] : 0.0;
    // As long as nothing says that it is sought.
    const bool itself = kind == ActuatorKind::moment;
    const double moment = itself ? input : kind == actuator.input() ? actuator.moment_of(input) : 0.0;
    shape.moments[i] = scale.to_dimensionless(moment, dimension::moment);
  }
  const Vec2 gravity = r.gravity ? *r.gravity : scene.gravity.value_or(Vec2{});
  shape.loads.gravity = (1.0 / gravity_) * gravity;
  list.push_back({"gravity along x", "m/s^2", gravity.x});
  list.push_back({"gravity along y", "m/s^2", gravity.y});
  const std::vector<RodLoadSpec>& loads = scene.rod.loads;
  for (const std::size_t given : {r.load_forces.size(), r.load_moments.size()}) {
    if (given != 0 && given != loads.size()) {
      fail(r, "found " + counted(given, "load") + ", expected one for each of the " + counted(loads.size(), "load") +
                  " of the rod");
    }
  }
  const auto pull = [&](const std::string& where, Vec2 force, double moment) {
    list.push_back({"force along x " + where, "N", force.x});
    list.push_back({"force along y " + where, "N", force.y});
    list.push_back({"moment " + where, "N m", moment});
    return dimensionless(scale, force, moment);
  };
  for (std::size_t l = 0; l < loads.size(); ++l) {
    const Vec2 force = r.load_forces.empty() ? Vec2{} : r.load_forces[l];
    const double moment = r.load_moments.empty() ? 0.0 : r.load_moments[l];
    if (loads[l].from != loads[l].to) {
      if (force != Vec2{} || moment != 0.0)
        fail(r, "load " + std::to_string(l + 1) + " of the rod acts along it, so that no recording can change it");
      continue;
    }
    shape.loads.at.push_back(
        pull("at load " + std::to_string(l + 1), loads[l].force + loads[l].mass * gravity + force, moment));
  }
  shape.loads.tip =
      pull("at the tip", scene.tip_load.force + scene.tip_load.mass * gravity + r.tip_force, r.tip_moment);
}

void CalibrationInput::add_markers(const Recording& r, SeenShape& shape) {
  if (r.markers.empty()) fail(r, "found no points, expected at least one");
  double before = -infinity;
  for (const CalibrationMarker& m : r.markers) {
    SeenMarker seen;
    seen.arc_length = m.arc_length / scale.length;
    if (!(seen.arc_length >= 0.0 && seen.arc_length <= 1.0 + beyond_tip)) {
      fail(r, "found a point at arc length " + text(m.arc_length) + " m, expected at least 0 and at most the rod's " +
                  "length, " + text(scale.length) + " m: " +
                  (seen.arc_length > 20.0 && 1e-3 * seen.arc_length <= 1.0 + reach_tolerance
                       ? "is it in mm? A plain number is in m"
                       : "are its unit and the rod's length right?"));
    }
    if (!(m.arc_length > before)) {
      fail(r, "found a point at arc length " + text(m.arc_length) + " m behind one at " + text(before) +
                  " m, expected ascending arc lengths: is one twice there, or out of order?");
    }
    before = m.arc_length;
    seen.arc_length = std::min(1.0, seen.arc_length);
    seen.along_normal = m.along_normal / scale.length;
    seen.along_tangent = m.along_tangent / scale.length;
    seen.has_position = m.position.has_value();
    seen.has_angle = m.angle.has_value();
    if (m.position) seen.position = (1.0 / scale.length) * *m.position;
    if (m.angle) seen.angle = *m.angle;
    if (!std::isfinite(seen.position.x) || !std::isfinite(seen.position.y) || !std::isfinite(seen.angle)) {
      fail(r, "a measured value is not finite");
    }
    const double aside = std::abs(m.out_of_plane) / scale.length;
    if (!(aside <= most_out_of_plane)) {
      fail(r, "found a point " + text(m.out_of_plane) + " m out of the plane, " + text(100.0 * aside) +
                  " % of the rod's length, expected a planar shape (at most " + text(100.0 * most_out_of_plane) +
                  " %)");
    }
    aside_ = std::max(aside_, aside);
    if (!seen.has_position && !seen.has_angle) fail(r, "found a point without position and angle, expected either");
    shape.markers.push_back(seen);
  }
}

/// Refuses points that no shape of the rod has.
void CalibrationInput::require_plausible(const Recording& r, const SeenShape& shape) const {
  const SeenMarker* before = nullptr;
  const double longest = problem.rod.stretches() ? 2.0 : 1.0;
  for (const SeenMarker& m : shape.markers) {
    if (!m.has_position) continue;
    const auto stalk = [](const SeenMarker& of) { return std::hypot(of.along_normal, of.along_tangent); };
    const double distance = norm(m.position - problem.rod.base);
    const std::string where = "the point at arc length " + text(m.arc_length * scale.length) + " m ";
    const double reach = longest * m.arc_length + stalk(m) + reach_tolerance;
    if (distance > reach) {
      const bool thousandth = 1e-3 * distance <= reach && distance > 20.0;
      fail(r, where + "lies " + text(distance * scale.length) +
                  " m from the base, further than the rod reaches there: " +
                  (thousandth ? "is it in mm? A plain number is in m"
                              : "are unit, origin and arc length right, and the arc lengths counted from the base?"));
    }
    if (before != nullptr) {
      const double chord = norm(m.position - before->position);
      if (chord > longest * (m.arc_length - before->arc_length) + stalk(m) + stalk(*before) + reach_tolerance) {
        fail(r, where + "lies " + text(chord * scale.length) +
                    " m from the one before, further than along the rod: " + "are the points in order?");
      }
    }
    before = &m;
  }
}

void CalibrationInput::add_unknowns(const Scene& scene, const CalibrationSpec& spec) {
  for (std::size_t i = 0; i < spec.unknowns.size(); ++i) {
    const CalibrationUnknownSpec& u = spec.unknowns[i];
    at_ = "calibrate.unknown[" + std::to_string(i) + "]";
    if (u.per != CalibrationScope::all && !is_base(u.kind)) {
      throw SceneError(at_ + ".per",
                       std::string(to_string(u.kind)) + " per recording or group, expected only the base's to differ");
    }
    if (u.per == CalibrationScope::all) {
      add_unknown(scene, spec, u, -1, "");
      continue;
    }
    std::vector<int> done;
    for (const int s : fitted) {
      const Recording& r = spec.recordings[static_cast<std::size_t>(s)];
      const int group = problem.shapes[static_cast<std::size_t>(s)].group;
      if (std::find(done.begin(), done.end(), group) != done.end()) continue;
      done.push_back(group);
      const bool each = u.per == CalibrationScope::recording;
      add_unknown(scene, spec, u, group, each ? " of recording " + r.name : " of group " + r.group);
    }
  }
  for (std::size_t a = 0; a < scene.rod.actuators.size(); ++a) {
    const Recording& r = spec.recordings.front();
    const bool sought = is_sought(CalibrationUnknown::moment, static_cast<int>(a));
    if (!sought && !r.input_kinds.empty() && r.input_kinds[a] != ActuatorKind::moment &&
        r.input_kinds[a] != scene.rod.actuators[a].input()) {
      fail(r, "found a " + input_name(r.input_kinds[a]) + " of actuator " + std::to_string(a + 1) +
                  ", whose moment is " +
                  "not known: expected 'moment' of that actuator among the unknowns, or its law in [[rod.actuator]]");
    }
    for (SeenShape& shape : problem.shapes) {
      if (sought) shape.moments[static_cast<Eigen::Index>(a)] = 0.0;
    }
  }
}

void CalibrationInput::require_enough(const CalibrationSpec& spec) const {
  const int count = CalibrationFit::count(problem, fitted);
  const auto unknowns = static_cast<int>(problem.unknowns.size());
  const int needed = unknowns + (spec.noise > 0.0 ? 0 : 1);
  if (count < needed) {
    throw SceneError("calibrate", "found " + counted(problem.unknowns.size(), "unknown") + " and " +
                                      std::to_string(count) + " measured numbers, expected at least " +
                                      std::to_string(needed) + (spec.noise > 0.0 ? "" : ", as the noise is not known") +
                                      ": measure more or look for less");
  }
}

}  // namespace tendril
