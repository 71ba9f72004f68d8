// What an actuator is told, and the moment that stands for it.

#include <algorithm>
#include <cmath>

#include "tendril/scene.hpp"

namespace tendril {
namespace {

/// The moment that a pressure gives, and its slope.
struct Law {
  double moment = 0.0;  ///< N m
  double slope = 0.0;   ///< N m / Pa
};

Law law_of(const ActuatorSpec& a, double pressure) {
  if (a.more_moment_per_pressure.empty()) return {a.moment_per_pressure * pressure, a.moment_per_pressure};
  const double p = std::clamp(pressure, a.least_pressure, a.most_pressure);
  double share = 0.0;  // the moment over the pressure, and its slope
  double bend = 0.0;
  for (auto c = a.more_moment_per_pressure.rbegin(); c != a.more_moment_per_pressure.rend(); ++c) {
    bend = bend * p + share;
    share = share * p + *c;
  }
  bend = bend * p + share;
  share = share * p + a.moment_per_pressure;
  const double slope = share + p * bend;
  return {share * p + slope * (pressure - p), slope};
}

/// By bisection between the two pressures of the law.
double pressure_of(const ActuatorSpec& a, double moment) {
  double low = a.least_pressure;
  double high = a.most_pressure;
  const Law at_low = law_of(a, low);
  const Law at_high = law_of(a, high);
  const double side = at_high.moment > at_low.moment ? 1.0 : -1.0;
  if (side * (moment - at_low.moment) <= 0.0) return low + (moment - at_low.moment) / at_low.slope;
  if (side * (moment - at_high.moment) >= 0.0) return high + (moment - at_high.moment) / at_high.slope;
  for (;;) {
    const double middle = 0.5 * (low + high);
    if (!(middle > low && middle < high)) return middle;
    (side * (law_of(a, middle).moment - moment) < 0.0 ? low : high) = middle;
  }
}

}  // namespace

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
  return kind == ActuatorKind::moment && knows_pressure() ? ActuatorKind::pressure : kind;
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

double ActuatorSpec::moment_of(double input) const {
  switch (this->input()) {
    case ActuatorKind::tendon:
      return input * largest_offset();
    case ActuatorKind::pressure:
      return law_of(*this, input).moment;
    case ActuatorKind::moment:
      break;
  }
  return input;
}

double ActuatorSpec::input_of(double moment) const {
  switch (input()) {
    case ActuatorKind::tendon:
      return moment / largest_offset();
    case ActuatorKind::pressure:
      return more_moment_per_pressure.empty() ? moment / moment_per_pressure : pressure_of(*this, moment);
    case ActuatorKind::moment:
      break;
  }
  return moment;
}

}  // namespace tendril
