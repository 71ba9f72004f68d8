#pragma once

#include "tendril/app/commands.hpp"

namespace tendril::app {

/// Calibrates the rod of a session's scene, and gives the table, the figure and, beside the result, the scene fragment
/// rod.toml. Exit code 0: every number is identifiable.
int run_calibrate(Session& session, const ResultPlaces& places);
/// Only writes the files; returns why there is no figure.
std::vector<std::string> write_calibration(Session& session, const Calibration& calibration,
                                           const ResultPlaces& places);

}  // namespace tendril::app
