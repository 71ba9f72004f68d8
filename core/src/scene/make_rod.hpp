#pragma once

#include "rod/rod.hpp"
#include "tendril/scale.hpp"
#include "tendril/scene.hpp"

namespace tendril {

/// The rod of a valid scene in units of `scale`.
TENDRIL_API Rod make_rod(const Scene& scene, const Scale& scale);

}  // namespace tendril
