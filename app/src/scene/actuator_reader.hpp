#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "scene/keys.hpp"
#include "tendril/scene.hpp"

namespace tendril::app {

/// [[rod.actuator]] as written, before the rod's length is known.
struct ActuatorDraft {
  std::optional<double> from, to;
  std::optional<double> limit, minimum, maximum, smallest_pressure, largest_pressure;  ///< of what its kind is told
  std::vector<double> moment_per_pressure{}, force_per_pressure{};  ///< of the pressure, its square, ...
  std::vector<double> moment_per_tension{};                         ///< of the tension, its square, ...
  ActuatorKind kind = ActuatorKind::moment;
  bool by_length = false;
  std::optional<double> largest_tension{};
  std::vector<double> offset{};                           ///< at both ends, or one for all
  std::vector<Vec2> offset_table{};                       ///< (arc length, offset)
  std::optional<std::pair<double, double>> calibrated{};  ///< of what its kind is told
  SourcePosition position{};
};

/// Coefficients that a law of the pressure or the tension may have.
inline constexpr std::size_t most_coefficients = 5;

Table<ActuatorDraft> actuator_table();

/// `path`: of its keys. `length`: of the rod.
ActuatorSpec finish_actuator(const Document& document, const std::string& path, const ActuatorDraft& actuator,
                             double length);

}  // namespace tendril::app
