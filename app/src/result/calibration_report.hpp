#pragma once

#include <string>

#include "tendril/app/result.hpp"
#include "tendril/calibrate.hpp"

namespace tendril::app {

/// A calibration as JSON, and as text for a person.
std::string calibration_json(const Scene& scene, const Calibration& calibration, const RunInfo& run);
std::string calibration_report(const Scene& scene, const Calibration& calibration);

}  // namespace tendril::app
