#pragma once

#include <functional>

#include "search/task.hpp"

/// Plans of contacts that rub (model.md section 11).
namespace tendril {

/// The best plan with tangential forces as variables. `search`: finds one of the task as it is. A plan without them is
/// looked for first and is a start, so that they never cost anything. All within the task's time limit.
Plan plan_any(Task& task, const PlanControl& control, const std::function<Plan(const PlanControl&)>& search);

/// The plan of a pose, or of a mirrored grasp, whose cost in the worst state of friction is least, and that keeps every
/// limit in all of them; it shows the rod in that state. Of each way of being in contact the best plan without friction
/// is the start, and what that costs bounds the worst state from below. `search`: as above. All within the task's time
/// limit.
Plan plan_worst(Task& task, const PlanControl& control, const std::function<Plan(const PlanControl&)>& search);

}  // namespace tendril
