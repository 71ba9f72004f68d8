#pragma once

#include <string>
#include <vector>

#include "result/uncertainty_result.hpp"
#include "tendril/app/session.hpp"
#include "tendril/files/scene_file.hpp"

namespace tendril::app {

using files::SensitivityWishes;

/// Derivatives of a result, and what they are by the keys of its scene.
struct SceneSensitivity {
  Sensitivity of;
  std::vector<KeySensitivity> keys{};  ///< none where `of` has its trouble
};

/// Plans, or executes the moments that are wished, and tells how the result follows the numbers of its scene. Throws
/// InputError.
SceneSensitivity sensitivities_of(Session& session, const SensitivityWishes& wishes);

}  // namespace tendril::app
