#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tendril/scene.hpp"

namespace tendril::app {

/// A paradigm of planning with obstacles (docs/model.md section 6).
enum class StudyMode {
  ignore,               ///< no obstacle in plan or execution
  ignore_then_execute,  ///< planned as if there were no obstacle, carried out among them
  avoid,
  allow,
  require
};
std::string_view to_string(StudyMode mode);
/// The mode of a name out of study_mode_names().
StudyMode study_mode(std::string_view name);
const std::vector<std::string>& study_mode_names();

/// Where an obstacle is in turn: [study.obstacle], [[trajectory.obstacle]].
struct ObstaclePlaces {
  std::string name;           ///< of the obstacle
  std::vector<Vec2> shifts;   ///< m, as ObstaclePlace has them
  std::vector<double> turns;  ///< rad
};

/// The sweeps of a study. An empty one leaves what the scene says. Further sweeps are further members.
struct StudySpec {
  std::vector<double> limits;             ///< SI
  Dimension limited = dimension::moment;  ///< what they limit: moments, or what the actuators are told
  std::vector<StudyMode> modes;
  std::vector<Vec2> targets;         ///< m
  std::vector<double> force_limits;  ///< N
  std::vector<double> diameters;     ///< m, of a grasp's object
  std::vector<double> moments;       ///< N m, added to the planned moment of a grasp's last actuator, and carried out
  std::vector<double> pressures;     ///< Pa, instead: added to its pressure
  std::vector<double> insertions;    ///< m, of the rod that is out of its port
  std::vector<Vec2> base_positions;  ///< m
  std::vector<double> base_angles;   ///< rad
  ObstaclePlaces obstacle;
  std::vector<StudyMode> starts;  ///< whose results `allow` and `require` start from as well
};

/// One combination of the sweeps.
struct StudyCase {
  int index = 0;
  std::optional<double> limit;            ///< SI
  Dimension limited = dimension::moment;  ///< what it limits
  std::optional<StudyMode> mode;
  std::optional<Vec2> target;  ///< m
  std::optional<double> force_limit, diameter, moment, pressure;
  std::optional<double> insertion{};  ///< m
  std::optional<Vec2> base_position{};
  std::optional<double> base_angle{};
  std::string obstacle{};  ///< that is shifted or turned
  std::optional<Vec2> shift{};
  std::optional<double> turn{};

  /// The last actuator of a grasp holds another moment than the planned one.
  bool changes_input() const { return moment || pressure; }
  /// N m, that moment.
  double held(const ActuatorSpec& actuator, double planned) const;
};

/// Every combination, in the order of limits, force limits, modes, targets, diameters, moments, pressures, insertions,
/// base positions, base angles, shifts, turns.
std::vector<StudyCase> study_cases(const StudySpec& study);

/// The scene of one case.
Scene scene_of(const Scene& scene, const StudyCase& one);

}  // namespace tendril::app
