#pragma once

#include <memory>
#include <string>

#include "tendril/coordinate_model.hpp"
#include "tendril/objective_term.hpp"
#include "tendril/obstacle.hpp"

namespace tendril::plugins {

/// What a plugin has made, behind a guard that names the plugin: an exception that leaves it in use becomes a
/// PluginError, and so do answers that no component of its kind may give (sizes, numbers that are not finite, a normal
/// that is no unit vector). `where` is for messages: kind, name and file. Solvers need none: Solver::solve() does the
/// same for them.
std::unique_ptr<CoordinateModel> guarded(std::unique_ptr<CoordinateModel> made, std::string where);
std::unique_ptr<ObjectiveTerm> guarded(std::unique_ptr<ObjectiveTerm> made, std::string where);
std::unique_ptr<Obstacle> guarded(std::unique_ptr<Obstacle> made, std::string where);

}  // namespace tendril::plugins
