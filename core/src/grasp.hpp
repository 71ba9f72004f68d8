#pragma once

#include "problem_data.hpp"

namespace tendril {

/// The upper finger in the palm's frame, with gravity and loads turned into it and the obstacles named that its program
/// respects: object, other finger, palm.
Scene finger_in_palm_frame(const Scene& scene);

/// Obstacles, palm and limits of a grasp. Throws SceneError where the scene asks for what one mirrored finger cannot
/// do.
void set_up_grasp(Problem::Data& data);

/// Why no contact of a finger whose part reaches up to `reach` (s/L) can hold the object; empty: nothing is known.
std::string grasp_obstruction(const Problem::Data& data, double reach);

/// How many starts grasp_start() knows of, for each way of being in contact.
inline constexpr int grasp_starts = 5;

/// A start of a grasp with one contact: the finger in equilibrium at its largest force, without weight, pressed
/// straight away from the axis at one of several places. How well it meets the base depends on the limits of the
/// moments.
StartShape grasp_start(const Problem::Data& data, const Mode& mode, int index);

/// Brings a plan of the program's frame, fixed to the object, into the world, and adds what only a grasp has.
void finish_grasp(const Problem::Data& data, PoseProgram& program, ConstVectorRef x, Plan& plan);

/// What small errors do to a grasp: the equilibrium system (rows of equilibrium, gap and closest point in coordinates,
/// places and forces) differentiated at x. `program` is moved to x.
GraspQuality grasp_quality(PoseProgram& program, ConstVectorRef x, const Scale& scale);

}  // namespace tendril
