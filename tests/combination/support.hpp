#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tendril/plugins/components.hpp"
#include "tendril/problem.hpp"

/// Scenes become plans here without the command: read as a user writes them, their components made from whatever is on
/// the plugin path.
namespace tendril::combination {

/// Looks for plugins, also in each `--plugin-dir DIRECTORY` of `arguments`, and reads which solvers everything is
/// combined with from each `--solver NAME`. Both are taken out. Before InitGoogleTest.
void find_plugins(std::vector<std::string>& arguments);

/// The plugins of this run. A registry of its own opens nothing but what it is asked for.
plugins::Registry& registry();
plugins::Registry fresh_registry();
/// Those that the arguments name, or else all that are found.
std::vector<std::string> solvers_to_combine();

/// The scene `scenes/<name>.toml`; `overrides` as the command takes them, "rod.actuator.0.limit=0". Its time limit is
/// raised to two minutes, so that a busy machine or a sanitizer changes no verdict.
Scene scene(const std::string& name, const std::vector<std::string>& overrides = {});
/// The same for text.
Scene scene_from_text(const std::string& text, const std::vector<std::string>& overrides = {});

Problem problem(const Scene& scene, plugins::Registry& from = registry());
Plan plan(const Scene& scene, const PlanControl& control = {});
/// The same with another solver than the scene names.
Plan plan_with(Scene scene, const std::string& solver);

/// Whether the plan is solved and certified; else what it says of itself.
testing::AssertionResult certified(const Plan& plan);

}  // namespace tendril::combination
