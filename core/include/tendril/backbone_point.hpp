#pragma once

#include <array>

namespace tendril {

/// s (m), x, y (m), angle (rad), curvature (1/m).
using BackbonePoint = std::array<double, 5>;

}  // namespace tendril
