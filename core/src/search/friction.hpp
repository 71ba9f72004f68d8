#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "search/friction_states.hpp"
#include "search/task.hpp"

/// Plans of contacts that rub (model.md section 11).
namespace tendril {

/// Coefficients of friction of the obstacles that a task respects; empty: all are 0.
std::vector<double> coefficients_of_friction(const Task& task);

/// The best plan with tangential forces as variables. `search`: finds one of the task as it is. A plan without them is
/// looked for first and is a start, so that they never cost anything. All within the task's time limit.
Plan plan_any(Task& task, const PlanControl& control, const std::function<Plan(const PlanControl&)>& search);

/// The plan of a pose, or of a mirrored grasp, whose cost in the worst state of friction is least, and that keeps every
/// limit in all of them; it shows the rod in that state. Of each way of being in contact the best plan without friction
/// is the start, and what that costs bounds the worst state from below. `search`: as above. All within the task's time
/// limit.
Plan plan_worst(Task& task, const PlanControl& control, const std::function<Plan(const PlanControl&)>& search);

/// A solved plan's states at its moments: without friction, then with every contact about to slip either way. They are
/// followed to in the plan's own coordinates, touching what it touches; an object that is held stays where it is.
/// Nothing where that is not possible; limits of forces and of the target are not looked at.
std::optional<FrictionStates> friction_states(const Task& task, const Plan& plan);

}  // namespace tendril
