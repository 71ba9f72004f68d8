#pragma once

#include "tendril/plan.hpp"
#include "tendril/scene.hpp"

namespace tendril::bench {

/// Whether a plan of the scene may end in this state of an execution.
bool allowed(const Scene& scene, const Plan& state);

}  // namespace tendril::bench
