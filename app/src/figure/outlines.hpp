#pragma once

#include <vector>

#include "figure/box.hpp"
#include "tendril/obstacle.hpp"

namespace tendril::app {

using ClosedLine = std::vector<Vec2>;

/// Lines around an obstacle; what lies within an odd number of them is its body. What lies far outside of the box
/// from `low` to `high` is cut off; none: nothing of the shape is there. Dimensionless like the obstacle.
std::vector<ClosedLine> outlines_of(const Obstacle& obstacle, Vec2 low, Vec2 high);

/// The part of what a closed line encloses that lies within a box; empty: there is none.
ClosedLine cut_off(const Box& box, ClosedLine line);

ClosedLine circle_outline(Vec2 center, double radius);

/// One line along all of `outlines`, with ways there and back between them: it can be filled where holes are unknown.
ClosedLine joined(const std::vector<ClosedLine>& outlines);

}  // namespace tendril::app
