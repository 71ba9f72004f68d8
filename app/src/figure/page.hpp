#pragma once

#include <filesystem>
#include <string>

#include "result/result_object.hpp"
#include "tendril/plugins/registry.hpp"

namespace tendril::app {

/// A page that shows a drawing: one file with everything in it, which asks for nothing from anywhere.
std::string drawing_page(const Json& drawing);

/// Writes the page that shows a result. `name` is the result's, for messages. Throws InputError where it shows nothing.
void write_page(const std::filesystem::path& file, const Json& result, const std::string& name,
                plugins::Registry& registry);

}  // namespace tendril::app
