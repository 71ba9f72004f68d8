#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tendril/plugins/registry.hpp"

namespace tendril::app {

/// A component as lists and reference pages show it.
struct Listed {
  ComponentKind kind{};
  std::string name;
  std::string file;     ///< empty: built in
  std::string problem;  ///< empty: loadable
  std::string description;
  OptionSchema options;
};

/// The shapes that core brings along, then everything in the registry's catalog, each opened in a process of its own
/// first.
std::vector<Listed> listed_components(plugins::Registry& registry);

/// "whole number > 0 <= 12", "text (a, b)": what an option may be.
std::string option_range(const OptionSpec& spec);
/// What an option is if nothing is said; empty: absent.
std::string option_default(const OptionSpec& spec);

}  // namespace tendril::app
