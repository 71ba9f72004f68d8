#pragma once

#include <memory>
#include <vector>

#include "tendril/obstacle.hpp"
#include "tendril/plan.hpp"
#include "tendril/scene.hpp"

namespace tendril {

/// Two mirrored fingers that hold a round object (model.md section 6, "grasp"). One finger, the upper one, is planned
/// in the palm's frame: origin at the palm's middle, x along the axis of symmetry.

/// The upper finger as a rod of its own in the world, with the object and the axis, which stands for the other finger,
/// as obstacles: what `execute` needs. The palm itself is left out.
TENDRIL_API Scene finger_in_world(const Scene& scene);

/// The obstacles of finger_in_world(), dimensionless, in its order. `palm_distance`: m.
TENDRIL_API std::vector<std::unique_ptr<Obstacle>> obstacles_of_finger(const Scene& scene, double palm_distance);

/// What the contacts of an upper finger (in the world, the object's are those with index 0) do to the object.
TENDRIL_API GraspPlan grasp_of(const Scene& scene, double palm_distance, const std::vector<PlannedContact>& contacts);

/// A point of the palm's frame in the world, m.
TENDRIL_API Vec2 palm_to_world(const GripperSpec& gripper, Vec2 point);

/// The mirror image of a world point at the axis of symmetry, m.
TENDRIL_API Vec2 mirrored(const GripperSpec& gripper, Vec2 point);

}  // namespace tendril
