// What an actuator is told, and the moment that stands for it.

#include <algorithm>
#include <cmath>
#include <span>

#include "tendril/scene.hpp"

namespace tendril {
namespace {

/// What a pressure or a tension gives, and its derivatives by it.
struct Law {
  double value = 0.0, slope = 0.0, bend = 0.0;
};

/// `first` and `more`: coefficients of the pressure, its square, and so on.
Law law_of(const ActuatorSpec& a, double first, std::span<const double> more, double pressure) {
  if (more.empty()) return {first * pressure, first, 0.0};
  const double p = std::clamp(pressure, a.least_pressure, a.most_pressure);
  double share = 0.0;  // the value over the pressure, and its derivatives
  double slope = 0.0;
  double half_bend = 0.0;
  const auto add = [&](double c) {
    half_bend = half_bend * p + slope;
    slope = slope * p + share;
    share = share * p + c;
  };
  for (auto c = more.rbegin(); c != more.rend(); ++c) add(*c);
  add(first);
  const double by_pressure = share + p * slope;
  const bool beyond = p != pressure;
  return {share * p + by_pressure * (pressure - p), by_pressure, beyond ? 0.0 : 2.0 * (slope + p * half_bend)};
}

Law moment_law(const ActuatorSpec& a, double pressure) {
  return law_of(a, a.moment_per_pressure, a.more_moment_per_pressure, pressure);
}

/// By bisection between the two pressures of the law.
double pressure_of(const ActuatorSpec& a, double moment) {
  double low = a.least_pressure;
  double high = a.most_pressure;
  const Law at_low = moment_law(a, low);
  const Law at_high = moment_law(a, high);
  const double side = at_high.value > at_low.value ? 1.0 : -1.0;
  if (side * (moment - at_low.value) <= 0.0) return low + (moment - at_low.value) / at_low.slope;
  if (side * (moment - at_high.value) >= 0.0) return high + (moment - at_high.value) / at_high.slope;
  for (;;) {
    const double middle = 0.5 * (low + high);
    if (!(middle > low && middle < high)) return middle;
    (side * (moment_law(a, middle).value - moment) < 0.0 ? low : high) = middle;
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

Dimension ActuatorSpec::input_dimension() const { return by_length ? dimension::length : effort_dimension(); }

Dimension ActuatorSpec::effort_dimension() const {
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
      if (!has_law()) return input * largest_offset();
      [[fallthrough]];
    case ActuatorKind::pressure:
      return moment_law(*this, input).value;
    case ActuatorKind::moment:
      break;
  }
  return input;
}

bool ActuatorSpec::pulls_in_proportion() const {
  // Every coefficient in the proportion of the first two that are there.
  const std::size_t count = std::max(force_per_pressure.size(), more_moment_per_pressure.size() + 1);
  const auto force = [&](std::size_t i) { return i < force_per_pressure.size() ? force_per_pressure[i] : 0.0; };
  const auto bends = [&](std::size_t i) {
    return i == 0 ? moment_per_pressure : i <= more_moment_per_pressure.size() ? more_moment_per_pressure[i - 1] : 0.0;
  };
  std::size_t first = 0;
  while (first + 1 < count && bends(first) == 0.0) ++first;
  for (std::size_t i = 0; i < count; ++i) {
    const double other = force(i) * bends(first);
    if (std::abs(other - force(first) * bends(i)) > 1e-12 * std::abs(other)) return false;
  }
  return true;
}

ActuatorSpec::Pull ActuatorSpec::pull_of(double moment) const {
  if (force_per_pressure.empty() || !knows_pressure()) return {};
  const double pressure = more_moment_per_pressure.empty() ? moment / moment_per_pressure : pressure_of(*this, moment);
  const Law bends = moment_law(*this, pressure);
  const Law pulls = law_of(*this, force_per_pressure.front(), std::span(force_per_pressure).subspan(1), pressure);
  const double slope = pulls.slope / bends.slope;
  return {pulls.value, slope, (pulls.bend - slope * bends.bend) / (bends.slope * bends.slope)};
}

std::optional<ActuatorSpec::Gain> ActuatorSpec::gain_of(int power, double moment) const {
  if (power == 0 && offset.size() == 1 && !has_law())
    return Gain{moment / offset.front().offset, 1.0 / offset.front().offset};
  if (power < 1 || !has_law()) return std::nullopt;
  const double pressure = input_of(moment);
  const double p = std::clamp(pressure, least_pressure, most_pressure);
  const double slope = power * std::pow(p, power - 1);
  return Gain{std::pow(p, power) + slope * (pressure - p), slope / moment_law(*this, pressure).slope};
}

double ActuatorSpec::input_of(double moment) const {
  switch (input()) {
    case ActuatorKind::tendon:
      if (!has_law()) return moment / largest_offset();
      [[fallthrough]];
    case ActuatorKind::pressure:
      return more_moment_per_pressure.empty() ? moment / moment_per_pressure : pressure_of(*this, moment);
    case ActuatorKind::moment:
      break;
  }
  return moment;
}

}  // namespace tendril
