#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "tendril/geometry.hpp"

namespace tendril::support {

/// A closed line of 4 to 12 corners, seldom convex, around `center`, no farther from it than `size`; counterclockwise.
inline std::vector<Vec2> random_outline(std::mt19937& random, Vec2 center, double size) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const int corners = 4 + static_cast<int>(9.0 * unit(random));
  std::vector<Vec2> line;
  line.reserve(static_cast<std::size_t>(corners));
  for (int i = 0; i < corners; ++i) {
    const double angle = 2.0 * std::numbers::pi * (i + 0.8 * unit(random)) / corners;
    const double radius = size * (0.2 + 0.8 * unit(random));
    line.push_back(center + radius * Vec2{std::cos(angle), std::sin(angle)});
  }
  return line;
}

}  // namespace tendril::support
