#pragma once

#include "search/task.hpp"
#include "tendril/grasp.hpp"

namespace tendril {

/// The upper finger in the palm's frame, with gravity and loads turned into it and the obstacles named that its program
/// respects: object, other finger (where it is the mirror image), palm.
Scene finger_in_palm_frame(const Scene& scene);

/// What a search asks about an object between two fingers.
std::unique_ptr<const Grip> pinched_object();

/// What the object carries in the palm's frame, dimensionless.
Vec2 load_along(const Scene& scene, const Scale& scale);

/// Obstacles, palm and limits of a finger. Throws SceneError where the scene asks for what one mirrored finger cannot
/// do.
void set_up_grasp(Task& data);

/// The lower finger of a problem whose upper one has been set up, terms included; both get the range of palm distances
/// that is left by either. Throws SceneError where the scene asks for what two fingers cannot do yet.
void add_lower_finger(Task& upper, const Scene& scene);

/// What a pair of ways of touching is called.
std::string pair_name(const Mode& above, const Mode& below);

/// The programs of a grasp of both fingers, one for each pair of ways of touching.
Description describe_both_fingers(const Task& upper, Description common);

/// Plans both fingers.
Plan plan_both_fingers(Task& upper, const PlanControl& control);

/// Why two fingers whose parts reach so far (m) cannot hold the object by pressing from opposite sides; empty: nothing
/// is known.
std::string pair_obstruction(const Task& upper, double upper_reach, double lower_reach);

/// How many starts grasp_start() knows of, for each way of being in contact.
inline constexpr int grasp_starts = 5;

/// A start of a grasp with one contact: the finger in equilibrium at its largest force, without weight, pressed
/// straight away from the axis at one of several places. How well it meets the base depends on the limits of the
/// moments.
StartShape grasp_start(const Task& data, const Mode& mode, int index);

/// What a plan says of its own finger.
FingerPlan finger_state(const Plan& plan);
/// Makes it the plan's own finger.
void set_finger(Plan& plan, FingerPlan finger);

/// Brings contacts and backbone of a finger's program, whose frame is fixed to the object, into the world of the
/// finger's scene. `distance`: of the palm, m.
void finger_to_world(const GripperSpec& gripper, double distance, Plan& plan);

/// What small errors do to one finger of a grasp: the equilibrium system (rows of equilibrium, gap and closest point in
/// coordinates, places and forces) differentiated at x. Force on the object along the axis and across it, away from the
/// axis; SI units.
struct FingerResponse {
  double axial_stiffness = 0.0;       ///< N/m
  double lateral_stiffness = 0.0;     ///< N/m
  std::vector<Vec2> force_by_moment;  ///< N, for 1 % of each actuator's moment
};
/// `program` is moved to x.
FingerResponse finger_response(PoseProgram& program, ConstVectorRef x, const Scale& scale);

/// Adds a finger that answers so and has these contacts to the quality of its grasp. `max_force`: of its contacts, N.
void add_finger(GraspQuality& quality, FingerName name, const FingerResponse& response,
                const std::vector<PlannedContact>& contacts, double max_force);

}  // namespace tendril
