#pragma once

#include <string>

#include "result/result_object.hpp"
#include "tendril/trajectory.hpp"

namespace tendril::app {

/// {"steps": [plan, ...], "effort": ...}: each step a plan with how it was reached and what it took.
Json trajectory_object(const Scene& scene, const Trajectory& trajectory);
/// One JSON document, schema 1.
std::string trajectory_json(const Scene& scene, const Trajectory& trajectory, const RunInfo& run);
/// A table with one line for each step.
std::string trajectory_report(const Scene& scene, const Trajectory& trajectory);

}  // namespace tendril::app
