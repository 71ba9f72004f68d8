#pragma once

#include <atomic>

#include "tendril/plan.hpp"

namespace tendril {

struct Task;

/// The tangential part of a plan's contact forces for each unit of the normal one, per obstacle; empty: there is none.
std::vector<double> ratios_of(const Plan& plan, std::size_t obstacles);

/// What the unknown state of friction can do to a solved plan at its moments (model.md section 11, "range"): fills
/// Plan::friction where obstacles that the plan touches have friction. Every corner of the cones of its contacts is
/// followed to from the state without friction; where one is not reached the plan is solved no longer.
void find_friction_range(const Task& task, Plan& plan, const std::atomic<bool>* stop);

}  // namespace tendril
