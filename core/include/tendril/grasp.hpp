#pragma once

#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "tendril/obstacle.hpp"
#include "tendril/plan.hpp"
#include "tendril/scene.hpp"

namespace tendril {

/// Two fingers that hold a round object (docs/model.md section 6, "grasp"). Mirrored fingers: one, the upper one, is
/// planned in the palm's frame: origin at the palm's middle, x along the axis of symmetry. Otherwise both are, the
/// lower one as the upper one of its mirror image.

/// The two fingers.
enum class FingerName { upper, lower };
TENDRIL_API std::string_view to_string(FingerName finger);  ///< The word that results use.

/// Whether both fingers are planned: the scene says so, has fingers that differ, or gravity acts across the axis.
TENDRIL_API bool plans_both_fingers(const Scene& scene);

/// One finger of a scene that plans both, as the upper finger of a scene of its own. For the lower one that scene is
/// the mirror image at the axis, gravity included. (A dead force at the tip is given for the upper finger, and mirrored
/// for the lower one.)
TENDRIL_API Scene finger_of(const Scene& scene, FingerName finger);

/// What a plan of both fingers says of one, as a plan for finger_of().
TENDRIL_API Plan plan_of_finger(const Scene& scene, const Plan& plan, FingerName finger);

/// The lower finger of a plan or execution for finger_of(), in the world.
TENDRIL_API FingerPlan lower_in_world(const Scene& scene, const Plan& plan);

/// The upper finger as a rod of its own in the world, with the object as obstacle, and the axis, where it stands for
/// the other finger: what `execute` needs. The palm itself is left out.
TENDRIL_API Scene finger_in_world(const Scene& scene);

/// The obstacles of finger_in_world(), dimensionless, in its order. `palm_distance`: m.
TENDRIL_API std::vector<std::unique_ptr<Obstacle>> obstacles_of_finger(const Scene& scene, double palm_distance);

/// What the contacts of an upper finger (in the world, the object's are those with index 0) and of its mirror image do
/// to the object.
TENDRIL_API GraspPlan grasp_of(const Scene& scene, double palm_distance, const std::vector<PlannedContact>& contacts);

/// What the contacts of both fingers (in the world) do to the object.
TENDRIL_API GraspPlan grasp_of(const Scene& scene, double palm_distance, const std::vector<PlannedContact>& upper,
                               const std::vector<PlannedContact>& lower);

/// How an object may be lifted by contacts that hold it, as GraspHold has them.
struct GraspLift {
  double acceleration = 0.0;     ///< m/s^2, the largest against gravity; infinity: any
  double heaviest_turned = 0.0;  ///< kg, the heaviest object that is held whichever way it is turned with the gripper
};
/// Of a grasp whose object weighs something and is held with forces that have limits; none of others.
TENDRIL_API std::optional<GraspLift> lift_of(const Scene& scene, const GraspPlan& grasp);

/// What the object of a grasp carries in the world, N: its weight, and the dead force that the scene gives.
TENDRIL_API Vec2 object_load(const Scene& scene);

/// A point of the palm's frame in the world, m.
TENDRIL_API Vec2 palm_to_world(const GripperSpec& gripper, Vec2 point);

/// The mirror image of a world point at the axis of symmetry, m.
TENDRIL_API Vec2 mirrored(const GripperSpec& gripper, Vec2 point);

}  // namespace tendril
