#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "scene/actuator_reader.hpp"
#include "scene/keys.hpp"
#include "scene/section_reader.hpp"
#include "tendril/scene.hpp"

namespace tendril::app {

/// [rod] as written.
struct RodDraft : SectionDraft {
  std::vector<SectionDraft> segments;
  std::vector<LoadDraft> loads;
  std::vector<ActuatorDraft> actuators;
  std::optional<Vec2> base_position;
  std::optional<double> base_angle;
  std::vector<Vec2> base_position_range;
  std::vector<double> base_angle_range;
  std::optional<LoadRange> calibrated_gravity, calibrated_tip_force;
  std::optional<double> insertion, least_insertion, most_insertion;
};

/// What one finger of a grasp states; the rest is that of [rod], [contact] and [gripper].
struct FingerDraft : RodDraft {
  std::optional<double> angle, min_force, max_force;
  std::optional<std::pair<double, double>> angle_range;
};

/// The ends of a range; two entries are asked for where the place in the file is known.
inline std::pair<double, double> two_of(const std::vector<double>& v) {
  return {v.front(), v.size() == 2 ? v.back() : std::nan("")};
}

/// Keys of [rod] and of [[finger]].
Table<RodDraft> rod_table();
Table<FingerDraft> finger_table();

/// The rod that is described at `table`. Throws InputError with the place where its values contradict each other.
RodSpec finish_rod(const Context& context, const std::string& table, const RodDraft& draft);

/// The fingers; what one does not state is taken from `rod` and from what has been read of the scene.
std::vector<FingerSpec> finish_fingers(const Context& context, const RodDraft& rod,
                                       const std::vector<FingerDraft>& drafts, const Scene& scene);

}  // namespace tendril::app
