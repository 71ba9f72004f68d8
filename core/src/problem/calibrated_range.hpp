#pragma once

#include <string>
#include <vector>

#include "tendril/scene.hpp"

namespace tendril {

/// Adds a note for every actuator that is told less, or more, than its rod was calibrated with. `moments` (N m) and
/// `turns` as in Plan; `whose`: stands before it, as "lower finger: ".
void tell_beyond_calibration(const RodSpec& rod, const std::vector<double>& moments, const std::vector<double>& turns,
                             const std::string& whose, std::vector<std::string>& notes);

}  // namespace tendril
