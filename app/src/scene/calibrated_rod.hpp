#pragma once

#include <string>

#include "tendril/app/document.hpp"
#include "tendril/app/units.hpp"
#include "tendril/calibrate.hpp"

namespace tendril::app {

/// [rod] of a scene with the numbers that a calibration found, as TOML that other scenes can include. What is known of
/// them, and what [rod] has no key for, stands above it as comments.
std::string calibrated_rod(const Document& document, const Units& units, const Calibration& calibration);

}  // namespace tendril::app
