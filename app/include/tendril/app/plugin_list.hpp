#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace tendril::app {

/// Everything on the search path, each plugin opened in a process of its own first, as a table or as a JSON document.
std::string plugin_list(const std::vector<std::filesystem::path>& plugin_directories, bool json);

}  // namespace tendril::app
