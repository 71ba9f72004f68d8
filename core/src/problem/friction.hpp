#pragma once

#include <atomic>

#include "tendril/plan.hpp"

namespace tendril {

struct Scene;
struct Task;

/// Whether the tangential forces of a plan's contacts are in the cones that the scene has, and on their edges where
/// they slip: Certificate::friction. What is not is solved no longer. `force_unit`: N.
TENDRIL_API void judge_cones(const Scene& scene, double force_unit, Plan& plan);

/// What the unknown state of friction can do to a solved plan at its moments (model.md section 11, "range"): fills
/// Plan::friction where obstacles that the plan touches have friction. Every corner of the cones of its contacts is
/// followed to from the state without friction: in the plan's own coordinates, or where contacts come and go by
/// execution. Where one is not reached the plan is solved no longer, unless it was made for a state of its own.
void find_friction_range(const Task& task, Plan& plan, const std::atomic<bool>* stop);

}  // namespace tendril
