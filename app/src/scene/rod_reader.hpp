#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scene/keys.hpp"
#include "scene/section_reader.hpp"
#include "tendril/scene.hpp"

namespace tendril::app {

/// [[rod.actuator]] as written, before the rod's length is known.
struct ActuatorDraft {
  std::optional<double> from, to;
  std::optional<double> limit, minimum, maximum, smallest_pressure, largest_pressure;  ///< of what its kind is told
  double moment_per_pressure = 0.0;
  ActuatorKind kind = ActuatorKind::moment;
  std::vector<double> offset{};      ///< at both ends, or one for all
  std::vector<Vec2> offset_table{};  ///< (arc length, offset)
  SourcePosition position{};
};

/// [rod] as written.
struct RodDraft : SectionDraft {
  std::vector<SectionDraft> segments;
  std::vector<LoadDraft> loads;
  std::vector<ActuatorDraft> actuators;
  Vec2 base_position{};
  double base_angle = 0.0;
};

/// What one finger of a grasp states; the rest is that of [rod], [contact] and [gripper].
struct FingerDraft : RodDraft {
  std::optional<double> angle, min_force, max_force;
};

/// Keys of [rod] and of [[finger]].
Table<RodDraft> rod_table();
Table<FingerDraft> finger_table();

/// The rod that is described at `table`. Throws InputError with the place where its values contradict each other.
RodSpec finish_rod(const Context& context, const std::string& table, const RodDraft& draft);

/// The fingers; what one does not state is taken from `rod` and from what has been read of the scene.
std::vector<FingerSpec> finish_fingers(const Context& context, const RodDraft& rod,
                                       const std::vector<FingerDraft>& drafts, const Scene& scene);

}  // namespace tendril::app
