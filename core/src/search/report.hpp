#pragma once

#include "search/task.hpp"

namespace tendril {

/// Adds to the plan's notes what a reader should know of its target: that it is out of reach, missed, or read by
/// nothing.
void tell_target(const Task& task, Plan& plan);

/// Tells a point of one of the task's programs in SI: what it costs, coordinates, moments, tip and contacts. Allocates
/// nothing where the plan has told such a point before.
void tell_point(const Task& task, PoseProgram& program, ConstVectorRef x, Plan& plan);

}  // namespace tendril
