#include "problem/calibrated_range.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "tendril/numbers.hpp"
#include "tendril/tolerances.hpp"

namespace tendril {
namespace {

std::string beyond(const std::string& range) {
  return ", beyond what its rod was calibrated with (" + range + "): nothing says how true this is";
}

void tell_inputs(const RodSpec& rod, const std::vector<double>& moments, const std::vector<double>& turns,
                 const std::string& whose, std::vector<std::string>& notes) {
  for (std::size_t a = 0; a < std::min({moments.size(), turns.size(), rod.actuators.size()}); ++a) {
    const ActuatorSpec& actuator = rod.actuators[a];
    const double low = actuator.calibrated_from;
    const double high = actuator.calibrated_to;
    if (!(low > -infinity || high < infinity)) continue;
    const double told = actuator.told(moments[a], turns[a]);
    if (std::isnan(told)) continue;  // a shortening that nobody knows
    const double within = std::isfinite(low) && std::isfinite(high) ? std::max(std::abs(low), std::abs(high)) : 0.0;
    if (told >= low - tolerance::bounds * within && told <= high + tolerance::bounds * within) continue;
    const bool pressure = actuator.kind == ActuatorKind::pressure;
    const double unit = pressure ? 1e3 : 1.0;
    const std::string name(pressure                                ? "kPa"
                           : actuator.by_length                    ? "m"
                           : actuator.kind == ActuatorKind::tendon ? "N"
                                                                   : "N m");
    notes.push_back(whose + "actuator " + std::to_string(a + 1) + " is told " + shown(told / unit, 4) + ' ' + name +
                    beyond(shown(low / unit + 0.0, 4) + " to " + shown(high / unit + 0.0, 4) + ' ' + name));
  }
}

}  // namespace

void tell_beyond_calibration(const Scene& scene, const std::vector<double>& moments, const std::vector<double>& turns,
                             double base_angle, const std::string& whose, std::vector<std::string>& notes) {
  const RodSpec& rod = scene.rod;
  tell_inputs(rod, moments, turns, whose, notes);
  // What is said has no heap memory before there is something to say.
  const bool calibrated = rod.calibrated_gravity || rod.calibrated_tip_force;
  const auto tell = [&](std::string_view name, Vec2 load, const std::optional<LoadRange>& range, const char* unit) {
    if (!calibrated && !range) return;
    // What a calibrated rod says nothing of, it did not carry.
    const auto [low, high] = range.value_or(LoadRange{});
    const Vec2 seen = seen_from_base(load, base_angle);
    const double rounding = tolerance::bounds * std::max({norm(low), norm(high), norm(seen)});
    const auto inside = [&](double x, double from, double to) { return x >= from - rounding && x <= to + rounding; };
    if (inside(seen.x, low.x, high.x) && inside(seen.y, low.y, high.y)) return;
    const auto text = [&](Vec2 v) {
      const auto part = [&](double x) { return shown(std::abs(x) <= rounding ? 0.0 : x, 4); };
      return '(' + part(v.x) + ", " + part(v.y) + ')';
    };
    notes.push_back(whose + std::string(name) + " is " + text(seen) + ' ' + unit + " along and across the rod's base" +
                    beyond(text(low) + " to " + text(high) + ' ' + unit));
  };
  const Vec2 gravity = scene.gravity.value_or(Vec2{});
  const bool weighs = std::any_of(rod.segments.begin(), rod.segments.end(), [](const SegmentSpec& s) {
    return s.linear_density > 0.0 || !s.more_linear_density.empty();
  });
  if (weighs) tell("gravity", gravity, rod.calibrated_gravity, "m/s^2");
  tell("the force at the tip", scene.tip_load.force + scene.tip_load.mass * gravity, rod.calibrated_tip_force, "N");
  for (std::size_t i = 0; i < rod.loads.size(); ++i) {
    const RodLoadSpec& load = rod.loads[i];
    tell("load " + std::to_string(i + 1), load.force + load.mass * gravity, load.calibrated,
         load.from < load.to ? "N/m" : "N");
  }
}

}  // namespace tendril
