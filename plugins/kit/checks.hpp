#pragma once

#include "findings.hpp"
#include "tendril/coordinate_model.hpp"
#include "tendril/objective_term.hpp"
#include "tendril/obstacle.hpp"

namespace tendril::kit {

/// A local basis: begins at zero, has the derivatives that it states, does not depend on how points are asked for, has
/// independent functions, and comes near to known shapes when pieces get smaller.
void check_coordinates(const CoordinateModel& model, Findings& findings);

/// A term for a rod with `moments` actuators: derivatives of both kinds, no kinks, no allocation, equal values for both
/// scalars, nothing read that is not declared, lower bound kept.
void check_objective(const ObjectiveTerm& term, int moments, const Target& target, Findings& findings);

/// A shape: its distance is one, normal and curvatures are the distance's derivatives, the rounded core, box, outline
/// and reference point agree with it.
void check_obstacle(const Obstacle& shape, Findings& findings);

}  // namespace tendril::kit
