#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scene/keys.hpp"
#include "tendril/scene.hpp"

namespace tendril::app {

/// No measurement may have more points: the time limit of a scene is meant for fewer.
inline constexpr std::size_t most_measured_points = 10'000;

/// [measurement] as written, before the rod's length is known.
struct MeasurementDraft {
  std::vector<std::vector<double>> rows;  ///< s, x, y or x, y each, m
  std::string file;
  std::optional<double> noise;
  std::vector<double> moments;
};

/// Keys of [measurement].
Table<MeasurementDraft> measurement_table();

/// Reads the file if there is one, and gives every point its arc length. Throws InputError with the place, also where a
/// scene of another kind has a measurement.
MeasurementSpec finish_measurement(const Context& context, const MeasurementDraft& draft, const Scene& scene);

}  // namespace tendril::app
