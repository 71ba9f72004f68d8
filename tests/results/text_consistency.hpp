#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tendril/scene.hpp"

namespace tendril::results {

/// Lines of a report that do not say what the JSON of the same result says, to the report's digits: those that follow
/// from the JSON and are missing in the text. For plans, executions, trajectories and estimates. Empty: they agree.
std::vector<std::string> lines_missing(const std::string& text, const nlohmann::json& result, const Scene& scene);

/// Numbers as reports write them.
std::string six_digits(double value);
/// The units that a report chooses: those that the scene uses most; of a scene that names none um for rods below 2 mm,
/// m from 2 m on, else mm, and N times that.
WrittenUnit unit_of(const Scene& scene);
WrittenUnit moment_unit_of(const Scene& scene);
std::string length_text(double si, const Scene& scene);
std::string moment_text(double si, const Scene& scene);
std::string force_text(double si);

}  // namespace tendril::results
