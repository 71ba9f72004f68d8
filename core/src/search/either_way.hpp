#pragma once

#include "search/task.hpp"

namespace tendril {

/// Plans a pose. A direction that is asked for counts modulo a full turn: the turn of the tip that is nearest comes
/// first, and where that does not get there the others that moments can bring. Where the target's tolerances cannot be
/// kept, the plan is the best one without them, and infeasible. All within one time limit.
Plan plan_to_target(Task& task, const PlanControl& control);

}  // namespace tendril
