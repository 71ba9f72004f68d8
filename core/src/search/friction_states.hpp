#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tendril/plan.hpp"

/// The states that friction allows a plan: which of them are looked at.
namespace tendril {

/// Every corner of the cones of so many contacts is followed to: corners double with every one.
inline constexpr Eigen::Index most_rubbing = 5;

/// Every sign of these numbers; `limits`: at most most_rubbing.
std::vector<Eigen::VectorXd> corners(const Eigen::VectorXd& limits);

/// A certified state of a plan.
struct SeenState {
  FrictionRange range{};
  std::vector<BackbonePoint> shape{};  ///< of a finger; of other rods nobody asks
  Eigen::VectorXd point{};             ///< of the program that it was found in, less its ratios; empty: in none
};

/// What was found of the states within the cones.
struct FrictionStates {
  std::vector<SeenState> states{};  ///< without friction, then at corners
  Eigen::VectorXd lost{};           ///< a corner that is not reached; empty: all that were asked for are
  std::string note{};               ///< where not every corner was asked for
};

/// The certified state at tangential ratios; nothing: there is none.
using StateAt = std::function<std::optional<SeenState>(const Eigen::VectorXd& ratios)>;

/// The state without friction, and those at the corners of the cones, up to `limits` either way. Half-way to each there
/// has to be one, too: it is asked for but where the way bends so little that the states at its ends tell it. Of more
/// contacts than most_rubbing each is about to slip alone, either way, and then all are as these states point to: for
/// every number of a state the corners at which it is largest and smallest if the effects of contacts add up. `halves`:
/// whether states half-way are asked for.
TENDRIL_API FrictionStates follow_states(const Eigen::VectorXd& limits, const StateAt& state, bool halves);

}  // namespace tendril
