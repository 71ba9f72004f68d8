#pragma once

#include <vector>

#include "search/task.hpp"
#include "statics/descent.hpp"

namespace tendril {

/// A shape of the rod under moments that are known, with its contacts: what searches start from.
struct Rest {
  Curvature curvature;
  std::vector<double> moments;  ///< EI/L, one per actuator; empty: unknown
  std::vector<PointContact> contacts;
  std::vector<double> moves{};  ///< of the rod (Rod::moves); empty: where searches begin
};

/// What a plan, or an execution, says of the rod of a problem; contacts with obstacles that the problem has not are
/// left out.
Rest rest_of(const Task& problem, const Plan& plan);

/// Where a rod rests under these moments: on point contacts, or along an obstacle, on the points that press.
Rest rest_of(const Task& problem, const std::vector<double>& moments, const State& state);

/// The shape of a rest for a mode, with its contacts as far as it has them.
StartShape shape_of(const Rest& rest, const Mode& mode);

}  // namespace tendril
