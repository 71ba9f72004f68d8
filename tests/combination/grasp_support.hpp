#pragma once

#include <vector>

#include "support.hpp"
#include "tendril/execute.hpp"

/// Grasps of the scene "grasp_60mm" with other objects and limits, and what becomes of them when they are carried out.
namespace tendril::combination {

/// `diameter`: m; `force_limit`: N, of each contact.
Scene grasp_of_diameter(double diameter, double force_limit, const std::vector<std::string>& overrides = {});

/// The objects of the paper's Fig. 4: 15 to 75 mm, in m.
std::vector<double> diameters();

/// N, of all contacts of a finger.
double contact_force(const Plan& plan);

/// Executed with the object where the plan has it, but moved by `moved` (m), from the plan's own shape.
Execution carried_out(const Scene& scene, const Plan& plan, const std::vector<double>& moments, Vec2 moved = {});

/// The best plan that a finger comes to rest at within `allowed` (m): a plan near a fold may be certified and yet lead
/// elsewhere. Judged by verify(), which fills its `model_error`.
Plan confirmed(const Scene& made, double allowed);

}  // namespace tendril::combination
