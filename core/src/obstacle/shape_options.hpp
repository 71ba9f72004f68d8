#pragma once

#include <string>

#include "tendril/obstacle.hpp"
#include "tendril/options.hpp"

/// The shapes that core brings along, and what their options have in common.
namespace tendril {

Component<Obstacle> circle_component();
Component<Obstacle> wall_component();
Component<Obstacle> capsule_component();
TENDRIL_API Component<Obstacle> polygon_component();
TENDRIL_API Component<Obstacle> channel_component();

OptionSpec point_option(std::string name, std::string description);
/// At least `least` points.
OptionSpec points_option(std::string name, int least, std::string description);
OptionSpec positive_length_option(std::string name, std::string description);
/// Throws an OptionError that says what a shape's option was found to be.
[[noreturn]] void refuse_option(const std::string& shape, const std::string& option, const std::string& found,
                                const std::string& expected);
Vec2 point_of(const Options& options, std::string_view name);

}  // namespace tendril
