#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tendril/obstacle.hpp"
#include "tendril/plan.hpp"
#include "tendril/scene.hpp"

namespace tendril::bench {

/// The equilibrium of the exact rod, dimensionless.
struct ExactState {
  bool found = false;
  std::string why{};  ///< it was not found
  Vec2 tip{};
  /// Of the plan's contacts that press, in its order.
  std::vector<double> arc_lengths, forces;
};

/// The state that `plan` stands for, by a second method that shares nothing with the first: the strong form of the
/// equations as a boundary-value problem, under the plan's own moments, with those contacts closed that press in it.
/// What lies between both is the error of the plan's model alone. Newton starts from the shape, contacts and forces of
/// `start`, normally the plan itself. A contact is taken to stay on the part of its obstacle (a side, a rounded corner)
/// on which the plan has it. `obstacles`: dimensionless, one per obstacle of the scene.
ExactState exact_state(const Scene& scene, const std::vector<std::unique_ptr<Obstacle>>& obstacles, const Plan& plan,
                       const Plan& start);

/// How far apart both are, of what is worst: tips and arc lengths in L, forces relative to the larger of 1 (EI/L^2)
/// and their size.
double distance(const Scene& scene, const Plan& plan, const ExactState& exact);

}  // namespace tendril::bench
