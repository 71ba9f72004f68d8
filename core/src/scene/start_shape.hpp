#pragma once

#include <functional>

#include "rod/rod.hpp"
#include "tendril/scene.hpp"

namespace tendril {

/// Curvature (times L) along the rod of a start that the scene gives by points, smoothed; empty: it gives none. Throws
/// SceneError where the points say nothing.
std::function<double(double)> start_curvature(const Scene& scene, const Scale& scale, const Rod& rod);

}  // namespace tendril
