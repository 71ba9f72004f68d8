#pragma once

#include <string>

#include "tendril/registrar.hpp"

/// The shapes that core brings along, and what their options have in common.
namespace tendril {

ObstacleComponent circle_component();
ObstacleComponent wall_component();
ObstacleComponent capsule_component();
ObstacleComponent polygon_component();

OptionSpec point_option(std::string name, std::string description);
OptionSpec positive_length_option(std::string name, std::string description);
Vec2 point_of(const Options& options, std::string_view name);

}  // namespace tendril
