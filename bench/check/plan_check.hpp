#pragma once

#include <string>
#include <vector>

#include "tendril/plan.hpp"
#include "tendril/scene.hpp"

namespace tendril::bench {

/// What a plan's own numbers say, computed from the scene and the plan alone by formulas of its own: moments of
/// everything beyond a point instead of an energy's gradient, positions by cumulative quadrature, distances by geometry
/// written down here, the second variation by differences of the equilibrium with contacts that follow. Nothing of it
/// calls the program, the certificate or the obstacles that made the plan. Dimensionless.
struct PlanCheck {
  double equilibrium = infinity;     ///< largest residual
  double penetration = infinity;     ///< largest depth found along the rod
  double contact = infinity;         ///< largest min(gap, force) or gap of a contact that presses
  double closest_point = infinity;   ///< largest tangent . normal, one-sided at the tip
  double limits = infinity;          ///< moments, forces, cones and contacts that the scene does not allow
  double shape = infinity;           ///< backbone and tip of the plan against the shape of its coordinates
  double margin = -infinity;         ///< of stability
  std::vector<std::string> defects;  ///< what makes the plan a false one; empty: confirmed
};

/// Checks a plan of a pose in coordinates pcc, psc or legendre with circles, walls, capsules and polygons whose options
/// are numbers or text with units. Throws Error for anything else.
PlanCheck check_plan(const Scene& scene, const Plan& plan);

}  // namespace tendril::bench
