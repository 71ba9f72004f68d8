#pragma once

#include "search/task.hpp"

namespace tendril {

/// Tells a point of one of the task's programs in SI: what it costs, coordinates, moments, tip and contacts. Allocates
/// nothing where the plan has told such a point before.
void tell_point(const Task& task, PoseProgram& program, ConstVectorRef x, Plan& plan);

}  // namespace tendril
