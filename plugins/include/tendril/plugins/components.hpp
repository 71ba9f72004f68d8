#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tendril/plugins/registry.hpp"
#include "tendril/problem.hpp"

namespace tendril::plugins {

/// Runs a step that belongs to the key at `path` of a scene ("objective[1]", "solver.options"). Whoever knows the file
/// adds the place to what the step throws.
using Located = std::function<void(const std::string& path, const std::function<void()>& step)>;

/// The scene's obstacles, in its order. Throws PluginError and OptionError.
std::vector<std::unique_ptr<Obstacle>> make_obstacles(Registry& registry, const Scene& scene, const Located& at = {});

/// Everything that a problem of `scene` needs, and nothing else: what the scene does not use is not opened. Throws
/// PluginError and OptionError.
Components make_components(Registry& registry, const Scene& scene, const Located& at = {});

}  // namespace tendril::plugins
