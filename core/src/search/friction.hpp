#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "search/task.hpp"

/// Plans of contacts that rub (model.md section 11).
namespace tendril {

/// Obstacles whose contacts are followed over their cones: corners double with every one.
inline constexpr std::size_t most_rubbing = 5;

/// Coefficients of friction of the obstacles that a task respects; empty: all are 0.
std::vector<double> coefficients_of_friction(const Task& task);

/// The best plan with tangential forces as variables. `search`: finds one of the task as it is. A plan without them is
/// looked for first and is a start, so that they never cost anything. All within the task's time limit.
Plan plan_any(Task& task, const PlanControl& control, const std::function<Plan(const PlanControl&)>& search);

/// The plan of a pose whose cost in the worst state of friction is least, and that keeps every limit in all of them; it
/// shows the rod in that state. Of each way of being in contact the best plan without friction is the start, and what
/// that costs bounds the worst state from below. All within the task's time limit.
Plan plan_worst(Task& task, const PlanControl& control);

/// A solved plan's states at its moments: without friction, then with every contact about to slip either way. They are
/// followed to in the plan's own coordinates, touching what it touches. Nothing where one of them, or half-way to it,
/// is no certified equilibrium; limits of forces and of the target are not looked at.
std::optional<std::vector<FrictionRange>> friction_states(const Task& task, const Plan& plan);

}  // namespace tendril
