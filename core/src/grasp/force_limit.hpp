#pragma once

#include "search/task.hpp"

namespace tendril {

/// A grasp whose objectives leave the force open presses as hard as it may. Where no such grasp is certified it presses
/// as the objectives have it, and the plan says so.
Plan plan_grasp(Task& task, const PlanControl& control);

}  // namespace tendril
