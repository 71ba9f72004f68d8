#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scene/keys.hpp"
#include "tendril/calibrate.hpp"

namespace tendril::app {

/// [[calibrate.unknown]] as written; numbers are read once the unknown's dimension is known.
struct UnknownDraft {
  CalibrationUnknownSpec spec;
  std::optional<Node> start, minimum, maximum, prior, prior_error;
  SourcePosition position{};
};

/// [calibrate] as written.
struct CalibrationDraft {
  std::vector<std::string> files, check_files;
  std::vector<UnknownDraft> unknowns;
  CalibrationSpec spec;  ///< without recordings and unknowns
};

/// Keys of [calibrate].
Table<CalibrationDraft> calibration_table();

/// Reads the files beside the scene. What of them is not read is told in Scene::left_out. Throws InputError.
CalibrationSpec finish_calibration(const Context& context, const CalibrationDraft& draft, Scene& scene);

}  // namespace tendril::app
