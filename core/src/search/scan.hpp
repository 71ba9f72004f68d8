#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "search/rest.hpp"
#include "search/task.hpp"

namespace tendril {

/// The actuators whose moments can be chosen, each within finite limits, so that all equilibria over the box of
/// moments can be looked for. Nothing: some have no limits, or more than moments can be chosen, as tangential forces
/// are.
std::optional<std::vector<std::size_t>> scanned_actuators(const Task& task);

/// Whether two rests under the same moments are one, reached on two ways.
bool same_rest(const Rest& a, const Rest& b);

/// A stable equilibrium that a scan met, where the moments stand on a node of its grid.
struct ScannedRest {
  Rest rest;
  std::vector<int> node;                  ///< one number per actuator that can be chosen
  std::vector<std::size_t> neighbours{};  ///< equilibria at nodes beside, to which the rod goes without a jump
};

/// Stable equilibria over the box of moments (docs/search.md).
struct EquilibriumScan {
  std::vector<ScannedRest> met;
  std::vector<double> steps;  ///< EI/L, between nodes, one per actuator that can be chosen
  int lost = 0;               ///< ways from node to node that could not be followed to their end
  bool whole = true;          ///< it was not stopped before
};

/// Starts from shapes that are let go at the corners and in the middle of the box, and from rests, and follows every
/// equilibrium to the nodes beside, through contacts made and lost; where it ends, to what the rod falls to.
EquilibriumScan scan_equilibria(const Task& task, const std::vector<std::size_t>& actuators, int intervals,
                                const std::vector<StartShape>& shapes, const std::vector<Rest>& rests,
                                const std::function<bool()>& must_stop);

}  // namespace tendril
