#pragma once

#include <vector>

#include "rod/rod.hpp"
#include "tendril/obstacle.hpp"
#include "tendril/scale.hpp"
#include "tendril/scene.hpp"

namespace tendril {

/// The rod of a valid scene in units of `scale`.
/// Throws SceneError where something else than the rod itself changes along what may be drawn in.
TENDRIL_API Rod make_rod(const Scene& scene, const Scale& scale);

/// Refuses a base that stands still in an obstacle, or outside of the room that channels keep, if it stands in none.
/// `obstacles`: of the scene, dimensionless. Throws SceneError.
void require_free_base(const Scene& scene, const Rod& rod, const std::vector<const Obstacle*>& obstacles,
                       const Scale& scale);

/// Makes moves of all numbers that place the rod's base; those that are none yet have no limits.
void let_base_move(Rod& rod);

/// Refuses a port that so much of the rod (units of L) is drawn into, if that is all of it or beyond a fixed knot.
/// Throws SceneError.
void require_out_of_port(const Rod& rod, double drawn_in, const Scale& scale);

}  // namespace tendril
