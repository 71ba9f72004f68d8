#pragma once

#include <memory>

#include "tendril/obstacle.hpp"
#include "tendril/options.hpp"

namespace tendril {

/// The option that obstacles of all shapes have beside those of their own: the point that they are turned about.
TENDRIL_API const OptionSpec& pivot_option();

/// moved(), but turned about `pivot` (L), which is where the shape has it before it is shifted.
TENDRIL_API std::unique_ptr<Obstacle> moved_about(std::unique_ptr<Obstacle> obstacle, Vec2 pivot, Vec2 shift,
                                                  double turn);

/// What an obstacle is turned about, where it is: its pivot, or its reference point if none was given.
TENDRIL_API Vec2 pivot_of(const Obstacle& obstacle);

}  // namespace tendril
