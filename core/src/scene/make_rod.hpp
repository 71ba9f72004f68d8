#pragma once

#include <vector>

#include "program/pose_program.hpp"
#include "rod/rod.hpp"
#include "tendril/obstacle.hpp"
#include "tendril/scale.hpp"
#include "tendril/scene.hpp"

namespace tendril {

/// The rod of a valid scene in units of `scale`.
TENDRIL_API Rod make_rod(const Scene& scene, const Scale& scale);

/// Refuses a base that stands still in an obstacle, or outside of the room that channels keep, if it stands in none.
/// `obstacles`: of the scene, dimensionless. Throws SceneError.
void require_free_base(const Scene& scene, const Rod& rod, const std::vector<const Obstacle*>& obstacles,
                       const Scale& scale);

/// Makes moves of all numbers that place the rod's base; those that are none yet have no limits.
void let_base_move(Rod& rod);

/// Of a rod that is drawn in so far (units of L) what lies before the last fixed knot there is hidden. Throws
/// SceneError where all of it would be, or all of a tendon that is told its length.
void hide_inside_port(Rod& rod, double drawn_in, const Scale& scale);

/// The same rod for each stretch between fixed knots that its port may be in, each drawn in between limits of its own,
/// from the outmost on; of one that is not drawn in itself.
std::vector<Rod> port_windows(const Rod& rod);

/// A port that moves towards the end of a stretch ends so far from it (units of L), and goes on behind it.
inline constexpr double before_knot = 4.0 * knot_clearance;

}  // namespace tendril
