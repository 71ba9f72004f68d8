#pragma once

#include <vector>

#include "rod/outline.hpp"
#include "tendril/obstacle.hpp"

namespace tendril {

/// Where a shape comes nearer to an obstacle than beside.
struct Valley {
  double distance = 0.0;    ///< of the body, units of L
  double arc_length = 0.0;  ///< units of L
};

/// The valleys between two arc lengths, the deepest first; the ends count.
std::vector<Valley> valleys(const std::vector<OutlinePoint>& line, const Obstacle& obstacle, double from, double to);

}  // namespace tendril
