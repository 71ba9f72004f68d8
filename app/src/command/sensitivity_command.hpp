#pragma once

#include <string>
#include <vector>

#include "tendril/app/session.hpp"
#include "tendril/files/scene_file.hpp"

namespace tendril::app {

struct SensitivityArguments {
  SceneArguments scene;
  std::vector<std::string> keys;  ///< none: all numbers of the scene
  files::Inputs moments{};        ///< that are carried out instead of a plan's; without text: none
  bool held = false;              ///< what the rod does under held moments, instead of another plan
  bool json = false;
};

/// Plans, and tells how the plan follows the numbers of its scene. Exit code 0: it has derivatives, 1: it has none.
int run_sensitivity(const SensitivityArguments& arguments);

}  // namespace tendril::app
