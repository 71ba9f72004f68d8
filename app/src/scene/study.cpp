#include "tendril/app/study.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

namespace tendril::app {

namespace {

/// The values of a sweep; one empty value if there is no sweep.
template <class T>
std::vector<std::optional<T>> values_of(const std::vector<T>& sweep) {
  if (sweep.empty()) return {std::nullopt};
  return {sweep.begin(), sweep.end()};
}

/// Limits what an actuator is told; a side that is 0 stays 0.
void limit_input(ActuatorSpec& actuator, double limit) {
  if (actuator.by_length) {
    if (actuator.least_shortening < 0.0) actuator.least_shortening = -limit;
    if (actuator.most_shortening > 0.0) actuator.most_shortening = limit;
    return;
  }
  // The ends of a law of several coefficients are its limits; what comes back from moments is rounded.
  const bool law = !actuator.more_moment_per_pressure.empty();
  auto [low, high] = law ? std::pair(actuator.least_pressure, actuator.most_pressure)
                         : std::minmax({actuator.input_of(actuator.minimum), actuator.input_of(actuator.maximum)});
  if (low < 0.0) low = -limit;
  if (high > 0.0) high = limit;
  std::tie(actuator.minimum, actuator.maximum) = std::minmax({actuator.moment_of(low), actuator.moment_of(high)});
}

/// Adds `one` with every place of the obstacle that moves.
void add_obstacle_places(const StudySpec& study, StudyCase one, std::vector<StudyCase>& cases) {
  one.obstacle = study.obstacle.name;
  for (const auto& shift : values_of(study.obstacle.shifts)) {
    for (const auto& turn : values_of(study.obstacle.turns)) {
      one.index = static_cast<int>(cases.size());
      one.shift = shift;
      one.turn = turn;
      cases.push_back(one);
    }
  }
}

/// Adds `one` with every place of the rod.
void add_places(const StudySpec& study, StudyCase one, std::vector<StudyCase>& cases) {
  for (const auto& insertion : values_of(study.insertions)) {
    for (const auto& position : values_of(study.base_positions)) {
      for (const auto& angle : values_of(study.base_angles)) {
        one.insertion = insertion;
        one.base_position = position;
        one.base_angle = angle;
        add_obstacle_places(study, one, cases);
      }
    }
  }
}

}  // namespace

double StudyCase::held(const ActuatorSpec& actuator, double planned) const {
  if (pressure) return actuator.moment_of(actuator.input_of(planned) + *pressure);
  return planned + moment.value_or(0.0);
}

const std::vector<std::string>& study_mode_names() {
  static const std::vector<std::string> names{"ignore", "ignore_then_execute", "avoid", "allow", "require"};
  return names;
}

std::string_view to_string(StudyMode mode) { return study_mode_names()[static_cast<std::size_t>(mode)]; }

StudyMode study_mode(std::string_view name) {
  const std::vector<std::string>& names = study_mode_names();
  return static_cast<StudyMode>(std::find(names.begin(), names.end(), name) - names.begin());
}

std::vector<StudyCase> study_cases(const StudySpec& study) {
  std::vector<StudyCase> cases;
  for (const auto& limit : values_of(study.limits)) {
    for (const auto& force_limit : values_of(study.force_limits)) {
      for (const auto& mode : values_of(study.modes)) {
        for (const auto& target : values_of(study.targets)) {
          for (const auto& diameter : values_of(study.diameters)) {
            for (const auto& moment : values_of(study.moments)) {
              for (const auto& pressure : values_of(study.pressures)) {
                add_places(study, {0, limit, study.limited, mode, target, force_limit, diameter, moment, pressure},
                           cases);
              }
            }
          }
        }
      }
    }
  }
  return cases;
}

Scene scene_of(const Scene& scene, const StudyCase& one) {
  Scene changed = scene;
  const auto limit_moments = [&](RodSpec& rod) {
    for (ActuatorSpec& actuator : rod.actuators) {
      if (one.limited.unit != dimension::moment.unit) {
        limit_input(actuator, *one.limit);
        continue;
      }
      if (actuator.minimum < 0.0) actuator.minimum = -*one.limit;
      if (actuator.maximum > 0.0) actuator.maximum = *one.limit;
    }
  };
  if (one.limit) limit_moments(changed.rod);
  if (one.insertion) {
    changed.rod = out_of_port(changed.rod, *one.insertion);
    changed.rod.most_drawn_in = changed.rod.drawn_in = 0.0;
  }
  if (one.base_position) {
    changed.rod.base_position = *one.base_position;
    changed.rod.base_position_range.reset();
  }
  if (one.base_angle) {
    changed.rod.base_angle = *one.base_angle;
    changed.rod.base_angle_range.reset();
  }
  for (ObstacleSpec& obstacle : changed.obstacles) {
    if (obstacle.name != one.obstacle) continue;
    if (one.shift) obstacle.place.shift = *one.shift;
    if (one.turn) obstacle.place.turn = *one.turn;
  }
  for (FingerSpec& finger : changed.fingers) {
    if (one.limit) limit_moments(finger.rod);
    if (one.force_limit) finger.max_force = *one.force_limit;
  }
  if (one.mode) {
    switch (*one.mode) {
      case StudyMode::ignore:
      case StudyMode::ignore_then_execute:
        changed.contact.mode = ContactModeName::ignore;
        break;
      case StudyMode::avoid:
        changed.contact.mode = ContactModeName::avoid;
        break;
      case StudyMode::allow:
        changed.contact.mode = ContactModeName::allow;
        break;
      case StudyMode::require:
        changed.contact.mode = ContactModeName::require;
        break;
    }
  }
  if (one.target) changed.target.position = one.target;
  if (one.force_limit) changed.contact.max_force = *one.force_limit;
  if (one.diameter && changed.gripper) changed.gripper->object_diameter = *one.diameter;
  return changed;
}

}  // namespace tendril::app
