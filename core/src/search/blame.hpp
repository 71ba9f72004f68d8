#pragma once

#include "search/task.hpp"

namespace tendril {

/// Throws SceneError if functions of the basis depend linearly on each other, so that one shape has many coordinates
/// and no search for them ends.
void require_independent_functions(const Task& task);

/// Names terms that were no number somewhere, and the place: as the reason of a plan that failed, whose status is then
/// `failed`, and among what a solved one left out.
void blame_terms(const Task& task, Plan& plan);

}  // namespace tendril
