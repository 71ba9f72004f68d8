#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "scene/keys.hpp"
#include "tendril/estimate_sequence.hpp"
#include "tendril/scene.hpp"

namespace tendril::app {

/// No shape may have more points, and no sequence of frames more in all: the time limit of a scene is meant for fewer.
inline constexpr std::size_t most_measured_points = 10'000, most_sequence_points = 200'000;

/// A length as written.
struct MeasuredLength {
  double value = 0.0;
  bool plain = true;  ///< without a unit: in pixels where the scene says how long one is, else in m

  double in_metres(const std::optional<double>& pixel) const { return plain && pixel ? value * *pixel : value; }
};

/// [measurement] as written, before the rod's length is known.
struct MeasurementDraft {
  std::vector<std::vector<MeasuredLength>> rows;  ///< s, x, y or x, y each
  std::string file;
  std::vector<std::string> files;  ///< instead, one after the other
  std::optional<double> scale;     ///< m, of a pixel
  std::array<MeasuredLength, 2> origin{};
  bool y_down = false;
  std::optional<double> noise, force_rate, place_rate;
  std::vector<double> moments;

  /// One of them, or all.
  std::vector<std::string> all_files() const { return file.empty() ? files : std::vector{file}; }
};

/// Keys of [measurement].
Table<MeasurementDraft> measurement_table();

/// Reads the file if there is one, and gives every point its arc length; of a sequence, its first frame. What is not
/// read is told in Scene::left_out. Throws InputError with the place, also where a scene of another kind has a
/// measurement.
MeasurementSpec finish_measurement(const Context& context, const MeasurementDraft& draft, Scene& scene);

/// All frames of the files of `scene`, which is that of the document; nothing: it has a single shape. Throws InputError
/// where read_scene() does.
std::optional<SequenceSpec> read_sequence(const Document& document, const Units& units, const Scene& scene);

}  // namespace tendril::app
