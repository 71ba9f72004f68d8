#pragma once

#include <vector>

#include "tendril/execute.hpp"
#include "tendril/scene.hpp"

namespace tendril {

/// execute() and verify() for a scene whose two fingers are both planned (plans_both_fingers()). Each finger is carried
/// out on its own, with the object held where it is. What is reached reads like a plan of both: the upper finger's
/// state, the lower one's in `grasp`, the worse of both certificates, snaps of both. Fingers that end up crossing are
/// `not_converged`: contact between them is not computed.

/// `moments`: N m, those of the upper finger and then those of the lower one, closing ones negative. `palm_distance`:
/// m. `control.start` may be a plan of one mirrored finger too. Throws as execute() does.
TENDRIL_API Execution execute_both_fingers(const Scene& scene, double palm_distance, const std::vector<double>& moments,
                                           const ExecuteControl& control = {});

/// `control.start`: null or `&plan`: from the plan's own shape. `model_error` and `local_model_error` are the larger of
/// both fingers'.
TENDRIL_API Execution verify_both_fingers(const Scene& scene, Plan& plan, const ExecuteControl& control = {});

}  // namespace tendril
