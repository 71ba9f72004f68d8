#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "scene/curves.hpp"

namespace tendril::app {

/// What an SVG draws.
struct Drawing {
  std::vector<CurvedLine> lines;    ///< m, y up: bodies counterclockwise, holes in them clockwise
  std::vector<std::string> unread;  ///< what else it holds, in words
};

/// Reads paths, polygons, rectangles, circles and ellipses with their transforms. `id`: of one of them, or of a group
/// of them; empty: all. `unit`: the length of a unit of its coordinates, in m; absent: what its width says. Throws
/// InputError with line and column.
Drawing read_svg(const std::filesystem::path& path, const std::string& id, const std::optional<double>& unit);

}  // namespace tendril::app
