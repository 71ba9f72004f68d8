#pragma once

#include <span>
#include <vector>

#include "tendril/geometry.hpp"

namespace tendril {

/// Spreads points along the closed line through `corners`: every corner if there is room for all, the rest evenly in
/// between. No corner: every point is at infinity.
void spread_outline(const std::vector<Vec2>& corners, std::span<Vec2> points);

}  // namespace tendril
