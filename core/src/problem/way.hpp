#pragma once

#include <vector>

#include "tendril/plan.hpp"

namespace tendril {

/// Where a rod is after so much of the way from one place to another.
RodPlace between(const RodPlace& a, const RodPlace& b, double share);

/// Adds snaps of an execution that went from one share of a way to another.
void add_snaps(const std::vector<Snap>& snaps, double from, double to, std::vector<Snap>& all);

}  // namespace tendril
