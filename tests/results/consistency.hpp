#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "findings.hpp"
#include "tendril/scene.hpp"

namespace tendril::results {

using Json = nlohmann::json;

/// What a result of the command says that does not follow from its other numbers and from the scene: plans of a pose
/// and of a grasp, executions, trajectories and estimates. Formulas and geometry are written down here once more;
/// nothing of core computes anything. Empty: the result agrees with itself.
std::vector<std::string> inconsistencies(const Json& result, const Scene& scene);

/// A rod in a result, and what the scene says of it.
struct ShownRod {
  std::string name;  ///< of the finger; empty: the only one
  RodSpec rod;
  Vec2 base{};              ///< m, in the world
  double base_angle = 0.0;  ///< rad
};
/// The rods of which a result shows the shape: one, or both fingers where they were planned apart.
std::vector<ShownRod> shown_rods(const Json& result, const Scene& scene);
/// "backbone" and "tip" of a state. `certified`: it is not one on the way to something else.
void check_shape(const Json& state, const ShownRod& shown, bool certified, Findings& found);
/// "contacts" against the backbone that is beside them and against the scene's obstacles, or the object of a grasp.
/// `certified`: gaps and forces keep to what the certificate promises.
void check_contacts(const Json& state, const ShownRod& shown, const Scene& scene, const Json& result, bool certified,
                    Findings& found);
void check_grasp(const Json& result, const Scene& scene, Findings& found);
void check_estimate(const Json& result, const Scene& scene, Findings& found);

inline Vec2 pair_of(const Json& json) { return {json.at(0).get<double>(), json.at(1).get<double>()}; }

/// EI/L^2 of the first segment, N: what forces are compared with.
double force_unit(const RodSpec& rod);

}  // namespace tendril::results
