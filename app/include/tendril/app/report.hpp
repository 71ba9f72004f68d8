#pragma once

#include <string>

#include "tendril/app/result.hpp"

namespace tendril::app {

/// Tables for people, ending in a line feed.
std::string plan_report(const Scene& scene, const Plan& plan, const RunInfo& run);
std::string execution_report(const Scene& scene, const Execution& execution, const RunInfo& run);
std::string description_report(const Scene& scene, const Description& description, const RunInfo& run);

}  // namespace tendril::app
