#pragma once

#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "components.hpp"
#include "tendril/files/scene_file.hpp"

namespace tendril::python {

/// (key, value, whether the value is text, how messages name the setting)
using SettingTuple = std::tuple<std::string, std::string, bool, std::string>;

/// What a Scene of the package is made of.
inline files::SceneSource source_of(const std::string& file, const std::string& text,
                                    const std::vector<SettingTuple>& settings,
                                    const std::vector<std::string>& plugin_directories,
                                    const std::vector<PythonComponent>& components = {}) {
  files::SceneSource source{
      file, text, {}, {plugin_directories.begin(), plugin_directories.end()}, together(components)};
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
