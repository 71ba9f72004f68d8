#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scene/keys.hpp"
#include "scene/outline.hpp"
#include "tendril/scene.hpp"

namespace tendril::app {

/// [obstacle.file] as written.
struct OutlineFileDraft {
  std::string name;
  std::string id;
  std::optional<double> unit;  ///< m
  std::string plane;
  std::optional<double> height;     ///< m
  std::optional<double> tolerance;  ///< m
  Vec2 position{};                  ///< m, of the file's origin
  double angle = 0.0;               ///< rad, of its first axis
};

/// [[obstacle]] as written.
struct ObstacleDraft {
  ObstacleSpec spec;
  std::optional<OutlineFileDraft> file;
};

/// Keys of [[obstacle]].
Table<ObstacleDraft> obstacle_table();

/// Names those that have none by their number.
void name_obstacles(std::vector<ObstacleSpec>& obstacles);

/// Names those that have none, and reads files: their points become options of the shape. What is not read is told in
/// Scene::left_out. Throws InputError with the place.
std::vector<ObstacleSpec> finish_obstacles(const Context& context, std::vector<ObstacleDraft> drafts, Scene& scene);

}  // namespace tendril::app
