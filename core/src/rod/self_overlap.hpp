#pragma once

#include <optional>
#include <span>
#include <utility>

#include "tendril/backbone_point.hpp"
#include "tendril/export.hpp"
#include "tendril/geometry.hpp"

namespace tendril {

/// Where a rod crosses or covers itself first, seen from the base: both arc lengths in m, the smaller one first. A
/// planar rod cannot do that; the model does not forbid it. `backbone`: samples in order along the rod, as plans hold
/// them; between two of them the rod, and the sides of its body, are taken as straight.
TENDRIL_API std::optional<std::pair<double, double>> self_overlap(std::span<const BackbonePoint> backbone,
                                                                  const BodyRadius& radius = {});

/// Where two rods cross or touch: an arc length of each (m), the first one along `a`; none if they are apart.
TENDRIL_API std::optional<std::pair<double, double>> meeting_of(std::span<const BackbonePoint> a,
                                                                std::span<const BackbonePoint> b);

}  // namespace tendril
