#include "problem/calibrated_range.hpp"

#include <algorithm>
#include <cmath>

#include "tendril/numbers.hpp"
#include "tendril/tolerances.hpp"

namespace tendril {

void tell_beyond_calibration(const RodSpec& rod, const std::vector<double>& moments, const std::vector<double>& turns,
                             const std::string& whose, std::vector<std::string>& notes) {
  for (std::size_t a = 0; a < std::min({moments.size(), turns.size(), rod.actuators.size()}); ++a) {
    const ActuatorSpec& actuator = rod.actuators[a];
    const double low = actuator.calibrated_from;
    const double high = actuator.calibrated_to;
    if (!(low > -infinity || high < infinity)) continue;
    const double told = actuator.told(moments[a], turns[a]);
    const double within = std::isfinite(low) && std::isfinite(high) ? std::max(std::abs(low), std::abs(high)) : 0.0;
    if (told >= low - tolerance::bounds * within && told <= high + tolerance::bounds * within) continue;
    const bool pressure = actuator.kind == ActuatorKind::pressure;
    const double unit = pressure ? 1e3 : 1.0;
    const std::string name(pressure                                ? "kPa"
                           : actuator.by_length                    ? "m"
                           : actuator.kind == ActuatorKind::tendon ? "N"
                                                                   : "N m");
    notes.push_back(whose + "actuator " + std::to_string(a + 1) + " is told " + shown(told / unit, 4) + ' ' + name +
                    ", beyond what its rod was calibrated with (" + shown(low / unit + 0.0, 4) + " to " +
                    shown(high / unit + 0.0, 4) + ' ' + name + "): nothing says how true this is");
  }
}

}  // namespace tendril
