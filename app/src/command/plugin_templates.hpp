#pragma once

#include <array>
#include <string_view>

#include "tendril/registrar.hpp"

namespace tendril::app {

/// The files under plugins/templates, compiled in. @name@, @kind@ and @Class@ stand for what a project fills in.
struct PluginTemplate {
  ComponentKind kind{};
  std::string_view source;
  std::string_view scene;
};
extern const std::array<PluginTemplate, 4> plugin_templates;
extern const std::string_view project_template;

}  // namespace tendril::app
