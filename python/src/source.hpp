#pragma once

#include <pybind11/stl.h>

#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "components.hpp"
#include "tendril/files/scene_file.hpp"

namespace tendril::python {

/// (key, value, whether the value is text, how messages name the setting)
using SettingTuple = std::tuple<std::string, std::string, bool, std::string>;

/// What a Scene of the package is made of: (file, text, settings, plugin directories, components)
using SceneTuple = std::tuple<std::string, std::string, std::vector<SettingTuple>, std::vector<std::string>,
                              std::vector<PythonComponent>>;

inline files::SceneSource source_of(const SceneTuple& scene) {
  const auto& [file, text, settings, directories, components] = scene;
  files::SceneSource source{file, text, {}, {directories.begin(), directories.end()}, together(components)};
  source.settings.reserve(settings.size());
  for (const auto& [key, value, is_text, shown] : settings) source.settings.push_back({key, value, is_text, shown});
  return source;
}

/// An earlier result as JSON, or none.
inline std::optional<files::ResultText> result_of(const std::optional<std::string>& json, const char* name) {
  if (!json) return std::nullopt;
  return files::ResultText{*json, name};
}

}  // namespace tendril::python
