#pragma once

#include "search/task.hpp"

namespace tendril {

/// Where a plan has failed and a component has done what none may (a term that is no number somewhere, a basis whose
/// functions depend on each other), says so in place of what came of it. The status is then `failed`.
void blame_components(const Task& task, Plan& plan);

}  // namespace tendril
