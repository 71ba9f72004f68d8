#pragma once

#include <string>

#include "tendril/files/scene_file.hpp"

namespace tendril::files {

/// `tendril plan` of an estimate, as its JSON: of a single shape, or of a sequence where the file of points has several
/// frames. `run.start` is not used. Throws Error.
TENDRIL_API std::string estimate_json(const SceneSource& source, const Run& run = {});

}  // namespace tendril::files
