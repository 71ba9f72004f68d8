// What an actuator is told, and the moment that stands for it.

#include <algorithm>
#include <cmath>

#include "tendril/scene.hpp"

namespace tendril {

std::string_view to_string(ActuatorKind kind) {
  switch (kind) {
    case ActuatorKind::moment:
      return "moment";
    case ActuatorKind::tendon:
      return "tendon";
    case ActuatorKind::pressure:
      return "pressure";
  }
  return "?";
}

double excess(const ActuatorSpec& actuator, double moment) {
  return std::max(actuator.minimum - moment, moment - actuator.maximum);
}

ActuatorKind ActuatorSpec::input() const {
  return kind == ActuatorKind::moment && moment_per_pressure != 0.0 ? ActuatorKind::pressure : kind;
}

Dimension ActuatorSpec::input_dimension() const {
  switch (input()) {
    case ActuatorKind::tendon:
      return dimension::force;
    case ActuatorKind::pressure:
      return dimension::pressure;
    case ActuatorKind::moment:
      break;
  }
  return dimension::moment;
}

double ActuatorSpec::largest_offset() const {
  const auto largest = std::max_element(offset.begin(), offset.end(), [](const OffsetPoint& a, const OffsetPoint& b) {
    return std::abs(a.offset) < std::abs(b.offset);
  });
  return largest == offset.end() ? 0.0 : largest->offset;
}

double ActuatorSpec::moment_per_input() const {
  switch (input()) {
    case ActuatorKind::tendon:
      return largest_offset();
    case ActuatorKind::pressure:
      return moment_per_pressure;
    case ActuatorKind::moment:
      break;
  }
  return 1.0;
}

}  // namespace tendril
