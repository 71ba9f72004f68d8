#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "scene/outline.hpp"

namespace tendril::app {

/// The section of an STL body, in text or binary, with a plane across one of its axes, "x", "y" or "z", at `height`
/// along it: outlines in the other two, in the order in which they turn around the axis (x and y for "z"). All in m;
/// `unit` is the length of a unit of the file. Throws InputError.
std::vector<Outline> read_stl_section(const std::filesystem::path& path, char axis, double height, double unit);

}  // namespace tendril::app
