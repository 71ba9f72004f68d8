#pragma once

#include <optional>
#include <vector>

#include "scene/calibration_reader.hpp"
#include "scene/keys.hpp"
#include "scene/measurement_reader.hpp"
#include "scene/obstacle_reader.hpp"
#include "scene/rod_reader.hpp"
#include "tendril/app/study.hpp"
#include "tendril/scene.hpp"

namespace tendril::app {

/// What a scene plans with if it names no plugin; core itself knows none.
inline constexpr const char* default_coordinates = "legendre";
inline constexpr const char* default_solver = "nlopt";

/// [trajectory] as written.
struct TrajectoryDraft {
  std::vector<Vec2> positions;
  std::vector<double> angles;
  std::string file;
  std::vector<ObstaclePlaces> obstacles;
};

/// [[correlation]] as written; error_bars() reads it.
struct CorrelationDraft {
  std::vector<std::string> between;
  double value = 0.0;
};

/// What a scene says before defaults that depend on other keys are filled in.
struct SceneDraft {
  Scene scene;
  RodDraft rod;
  std::vector<ObstacleDraft> obstacles;
  std::vector<CorrelationDraft> correlations;
  std::vector<FingerDraft> fingers;
  MeasurementDraft measurement;
  TrajectoryDraft trajectory;
  std::string start_file;
  std::optional<StudySpec> study;
  std::optional<CalibrationDraft> calibration;
};

/// The keys of a scene, tables and all; made once.
const Table<SceneDraft>& scene_table();

}  // namespace tendril::app
