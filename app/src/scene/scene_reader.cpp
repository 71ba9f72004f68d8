#include "tendril/app/scene_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scene/measurement_reader.hpp"
#include "scene/plain_numbers.hpp"
#include "scene/rod_reader.hpp"
#include "scene/scene_tables.hpp"
#include "scene/table_file.hpp"
#include "tendril/app/input_error.hpp"

namespace tendril::app {

namespace {

/// A kind of problem that exists in the format but not in this version deserves a better answer than "unknown word".
void refuse_other_problems(const Document& document) {
  const Node* node = document.root().find("problem");
  if (node == nullptr) return;
  const auto* kind = std::get_if<std::string>(&node->value);
  if (kind == nullptr) return;
  for (const std::string_view other : {"study"}) {
    if (*kind == other) {
      document.fail(node->position, "found problem = \"" + *kind +
                                        "\", which is not available in this version, expected one of \"pose\", "
                                        "\"trajectory\", \"grasp\", \"execute\", \"estimate\"");
    }
  }
}

/// The rows of a file beside the scene that hold numbers alone; the others and columns that are not read are counted.
/// `reads`: in words.
std::vector<std::vector<double>> read_rows(const Context& context, const std::string& name, TableFileSpec spec,
                                           const std::string& reads, Scene& scene) {
  spec.most_rows = most_measured_points;
  TableFile file =
      read_table_file(std::filesystem::path(context.document.file()).parent_path() / name, spec, context.units);
  const std::size_t all = file.rows.size();
  std::erase_if(file.rows, [](const std::vector<double>& row) {
    return std::any_of(row.begin(), row.end(), [](double v) { return std::isnan(v); });
  });
  for (const std::string& column : file.unread) {
    scene.left_out.push_back({"column \"" + column + "\" of " + name, "a " + spec.what + " reads " + reads});
  }
  if (file.rows.size() < all) {
    scene.left_out.push_back({fmt::format("{} of the {} rows of {}", all - file.rows.size(), all, name),
                              "they hold no " + reads + ": a value is empty or not a number"});
  }
  return file.rows;
}

/// Targets of a file: x, y or x, y, angle or angle alone on each line.
std::vector<TargetSpec> read_targets(const Context& context, const std::string& name, Scene& scene) {
  TableFileSpec spec;
  spec.what = "trajectory";
  spec.columns = {
      {"x", dimension::length}, {"y", dimension::length}, {"angle", dimension::angle, {"phi", "direction"}}};
  spec.forms = {{0, 1}, {0, 1, 2}, {2}};
  std::vector<TargetSpec> targets;
  for (const std::vector<double>& row : read_rows(context, name, spec, "x, y and angle", scene)) {
    TargetSpec target;
    if (row.size() > 1) target.position = Vec2{row[0], row[1]};
    if (row.size() != 2) target.angle = row.back();
    targets.push_back(target);
  }
  return targets;
}

void finish_start(const Context& context, const std::string& file, Scene& scene) {
  const Document& document = context.document;
  const Node* start = document.root().find("start");
  const auto given = [start](const char* key) { return start != nullptr && start->find(key) != nullptr; };
  const bool points = given("points");
  if (points && !file.empty()) {
    document.fail(document.find("start.file"), "found 'file' beside 'points', expected either of them");
  }
  if ((points || !file.empty()) && given("tip_angle")) {
    document.fail(document.find("start.tip_angle"), "found 'tip_angle' beside points, expected either of them");
  }
  if (file.empty()) return;
  TableFileSpec spec;
  spec.what = "start";
  spec.columns = {{"x", dimension::length}, {"y", dimension::length}};
  spec.forms = {{0, 1}};
  for (const std::vector<double>& row : read_rows(context, file, spec, "x and y", scene)) {
    scene.start_points.push_back({row[0], row[1]});
  }
}

/// The index of an obstacle by its name; `path` names the table that has it.
std::size_t obstacle_of(const Document& document, const std::vector<ObstacleSpec>& obstacles, const std::string& name,
                        const std::string& path) {
  std::vector<std::string> names;
  names.reserve(obstacles.size());
  for (const ObstacleSpec& obstacle : obstacles) names.push_back(obstacle.name);
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  document.fail(document.find(path + ".name"),
                fmt::format("found '{}', expected the name of an obstacle{}", name, did_you_mean(name, names)));
}

/// Obstacles that move from target to target of a trajectory.
void finish_moving_obstacles(const Context& context, const std::vector<ObstaclePlaces>& moving, Scene& scene) {
  const Document& document = context.document;
  std::vector<TargetSpec>& targets = scene.trajectory.targets;
  for (std::size_t k = 0; k < moving.size(); ++k) {
    const std::string path = fmt::format("trajectory.obstacle[{}]", k);
    const ObstaclePlaces& places = moving[k];
    const std::size_t obstacle = obstacle_of(document, scene.obstacles, places.name, path);
    const std::size_t count = std::max(places.shifts.size(), places.turns.size());
    if (count == 0) document.fail(document.find(path), "found neither 'shifts' nor 'turns', expected one of them");
    if (targets.empty()) {
      targets.assign(count, scene.target);
      scene.target = {};
    }
    for (const auto& [key, given] :
         {std::pair("shifts", places.shifts.size()), std::pair("turns", places.turns.size())}) {
      if (given == 0 || given == targets.size()) continue;
      document.fail(document.find(path + '.' + key),
                    fmt::format("found {} {} for {} steps, expected one for each", given, key, targets.size()));
    }
    for (std::size_t i = 0; i < targets.size(); ++i) {
      ObstaclePlace place = scene.obstacles[obstacle].place;
      if (!places.shifts.empty()) place.shift = places.shifts[i];
      if (!places.turns.empty()) place.turn = places.turns[i];
      targets[i].obstacles.push_back({static_cast<int>(obstacle), place});
    }
  }
}

std::vector<TargetSpec> finish_trajectory(const Context& context, const TrajectoryDraft& draft, Scene& scene) {
  const Document& document = context.document;
  const std::size_t positions = draft.positions.size();
  const std::size_t angles = draft.angles.size();
  if (!draft.file.empty()) {
    if (positions > 0 || angles > 0) {
      document.fail(document.find("trajectory.file"),
                    "found 'file' beside 'positions' or 'angles', expected either of them");
    }
    return read_targets(context, draft.file, scene);
  }
  if (positions > 0 && angles > 0 && positions != angles) {
    document.fail(document.find("trajectory.angles"),
                  fmt::format("found {} angles for {} positions, expected one for each", angles, positions));
  }
  if (positions == 0 && angles == 0 && draft.obstacles.empty() && document.root().find("trajectory") != nullptr) {
    document.fail(
        document.find("trajectory"),
        "[trajectory] has neither 'positions' nor 'angles' nor 'file' nor an 'obstacle', expected one of them");
  }
  std::vector<TargetSpec> targets(std::max(positions, angles));
  for (std::size_t i = 0; i < positions; ++i) targets[i].position = draft.positions[i];
  for (std::size_t i = 0; i < angles; ++i) targets[i].angle = draft.angles[i];
  return targets;
}

void finish_pressures(const Document& document, const std::vector<ActuatorSpec>& actuators, const StudySpec& study) {
  if (study.pressures.empty()) return;
  const auto refuse = [&](const std::string& why) { document.fail(document.find("study.pressures"), why); };
  if (!study.moments.empty()) refuse("found 'pressures' beside 'moments', expected one of them");
  if (actuators.empty() || !actuators.back().knows_pressure()) {
    refuse("found 'pressures', expected 'moment_per_pressure' in the last [[rod.actuator]], or 'moments'");
  }
}

void finish_moments(const Document& document, const std::vector<ActuatorSpec>& actuators, const StudySpec& study) {
  if (study.moments.empty() || actuators.empty() || !actuators.back().by_length) return;
  document.fail(document.find("study.moments"),
                "found changes of a moment, but the last actuator is told its length, expected one told its tension");
}

/// Limits of what the actuators are told have to fit each of them.
void finish_limits(const Document& document, const std::vector<ActuatorSpec>& actuators, const StudySpec& study) {
  if (study.limits.empty() || study.limited.unit == dimension::moment.unit) return;
  for (std::size_t a = 0; a < actuators.size(); ++a) {
    const ActuatorSpec& actuator = actuators[a];
    const SourcePosition at = document.find("study.limits");
    if (actuator.input_dimension().unit != study.limited.unit) {
      document.fail(at, fmt::format("found limits in {}, but actuator {} is told {}, expected limits of that or of "
                                    "moments",
                                    study.limited.unit, a + 1, expected_quantity(actuator.input_dimension())));
    }
    const double most = std::max(std::abs(actuator.least_pressure), std::abs(actuator.most_pressure));
    for (const double limit : study.limits) {
      if (actuator.more_moment_per_pressure.empty() || limit <= most) continue;
      document.fail(at, fmt::format("found a limit of {0} {3}, but the law of actuator {1} is known up to {2} {3} only",
                                    limit, a + 1, most, study.limited.unit));
    }
  }
}

}  // namespace

std::vector<KeySpec> scene_keys() { return scene_table().specs(); }

Scene read_scene(const Document& document, std::shared_ptr<const Units> units) {
  refuse_other_problems(document);
  SceneDraft draft;
  std::vector<std::string> warnings;
  const Context context{document, *units, warnings};
  draft.scene.coordinates.plugin = default_coordinates;
  draft.scene.solver.plugin = default_solver;
  draft.scene.coordinates.position = document.find("coordinates");
  draft.scene.solver.position = document.find("solver");
  read_table(context, document.root(), "", scene_table(), draft);
  Scene scene = std::move(draft.scene);
  scene.rod = finish_rod(context, "rod", draft.rod);
  const auto states_axial = [](const SectionDraft& section) { return section.axial_stiffness.has_value(); };
  if (scene.coordinates.stretch_order == 0 &&
      (states_axial(draft.rod) || std::any_of(draft.rod.segments.begin(), draft.rod.segments.end(), states_axial))) {
    scene.left_out.push_back({"axial_stiffness", "[coordinates] has no stretch_order: the rod does not stretch"});
  }
  scene.fingers = finish_fingers(context, draft.rod, draft.fingers, scene);
  const auto require_two = [&](const auto& range, const std::string& path, const char* what = "lengths") {
    if (range && std::isnan(range->second))
      document.fail(document.find(path), fmt::format("expected two {}: the smallest and the largest", what));
  };
  if (scene.gripper) {
    require_two(scene.gripper->palm_distance_range, "gripper.palm_distance_range");
    require_two(scene.gripper->half_palm_range, "gripper.half_palm_range");
    require_two(scene.gripper->finger_angle_range, "gripper.finger_angle_range", "angles");
  }
  for (std::size_t i = 0; i < draft.fingers.size(); ++i) {
    require_two(scene.fingers[i].finger_angle_range, fmt::format("finger[{}].angle_range", i), "angles");
  }
  scene.measurement = finish_measurement(context, draft.measurement, scene);
  scene.trajectory.targets = finish_trajectory(context, draft.trajectory, scene);
  finish_start(context, draft.start_file, scene);
  if (scene.contact.min_force > scene.contact.max_force) {
    document.fail(document.find("contact.min_force"),
                  fmt::format("found min_force {} N above max_force {} N, expected min_force <= max_force",
                              scene.contact.min_force, scene.contact.max_force));
  }
  scene.obstacles = finish_obstacles(context, std::move(draft.obstacles), scene);
  finish_moving_obstacles(context, draft.trajectory.obstacles, scene);
  scene.warnings.insert(scene.warnings.begin(), warnings.begin(), warnings.end());
  for (std::string& question : doubtful_numbers(document, scene)) scene.warnings.push_back(std::move(question));
  scene.file = document.file();
  scene.units = units->most_used();
  scene.read_quantity = [units = std::move(units)](std::string_view number, const Dimension& wanted) {
    try {
      return units->read(number, wanted);
    } catch (const QuantityError& error) {
      // Whoever resolves options says what was found and expected.
      throw InputError(error.why());
    }
  };
  return scene;
}

CalibrationSpec read_calibration(const Document& document, const Units& units, Scene& scene) {
  SceneDraft draft;
  std::vector<std::string> told_by_read_scene;
  const Context context{document, units, told_by_read_scene};
  read_table(context, document.root(), "", scene_table(), draft);
  if (!draft.calibration) document.fail({1, 1}, "the scene has no [calibrate], expected one with files and unknowns");
  return finish_calibration(context, *draft.calibration, scene);
}

StudySpec read_study(const Document& document, const Units& units) {
  SceneDraft draft;
  std::vector<std::string> told_by_read_scene;
  const Context context{document, units, told_by_read_scene};
  read_table(context, document.root(), "", scene_table(), draft);
  if (!draft.study) document.fail({1, 1}, "the scene has no [study], expected one with targets, modes or limits");
  StudySpec study = std::move(*draft.study);
  const RodSpec rod = finish_rod(context, "rod", draft.rod);
  finish_pressures(document, rod.actuators, study);
  finish_moments(document, rod.actuators, study);
  finish_limits(document, rod.actuators, study);
  if (!study.obstacle.name.empty()) {
    std::vector<ObstacleSpec> obstacles;
    for (ObstacleDraft& obstacle : draft.obstacles) obstacles.push_back(std::move(obstacle.spec));
    name_obstacles(obstacles);
    obstacle_of(document, obstacles, study.obstacle.name, "study.obstacle");
    if (study.obstacle.shifts.empty() && study.obstacle.turns.empty()) {
      document.fail(document.find("study.obstacle"), "found neither 'shifts' nor 'turns', expected one of them");
    }
  }
  for (const double insertion : study.insertions) {
    if (insertion <= rod.length() * (1.0 + 1e-9)) continue;
    document.fail(document.find("study.insertions"),
                  fmt::format("found an insertion of {} m, expected at most {} m, what is out of the port at most",
                              insertion, rod.length()));
  }
  return study;
}

}  // namespace tendril::app
