#include <algorithm>
#include <cmath>

#include "obstacle/part.hpp"
#include "obstacle/rounded_hull.hpp"
#include "obstacle/shape_options.hpp"
#include "tendril/numbers.hpp"

namespace tendril {
namespace {

/// A corner that turns by less than this (rad) could turn the other way by rounding of the input: no convex shape then.
constexpr double least_turn = 1e-6;

/// How many vertices each outline has.
std::vector<std::size_t> sizes_of(const Options& options, std::size_t vertices) {
  if (!options.has("outlines")) return {vertices};
  std::vector<std::size_t> sizes;
  std::size_t sum = 0;
  for (const double count : options.table("outlines").values) {
    if (!(count >= 3.0) || count != std::floor(count))
      refuse_option("polygon", "outlines", shown(count), "whole numbers from 3 on");
    sizes.push_back(static_cast<std::size_t>(std::min(count, 1e9)));
    sum += sizes.back();
  }
  if (sum != vertices) {
    refuse_option("polygon", "outlines", std::to_string(sum) + " vertices together",
                  "as many as 'vertices' has, which are " + std::to_string(vertices));
  }
  return sizes;
}

std::vector<ClosedLine> lines_of(const Options& options) {
  const NumberTable& table = options.table("vertices");
  std::vector<ClosedLine> lines;
  std::size_t row = 0;
  for (const std::size_t size : sizes_of(options, static_cast<std::size_t>(table.rows))) {
    ClosedLine line;
    line.reserve(size);
    for (std::size_t i = 0; i < size; ++i) {
      const auto at = static_cast<int>(row + i);
      line.push_back({table(at, 0), table(at, 1)});
    }
    if (const std::optional<LineFault> fault = fault_of(line, row + 1)) {
      refuse_option("polygon", "vertices", fault->found, fault->expected);
    }
    row += size;
    lines.push_back(std::move(line));
  }
  return lines;
}

bool strictly_convex(const ClosedLine& line) {
  for (std::size_t i = 0; i < line.size(); ++i) {
    const Vec2 before = line[i] - line[(i + line.size() - 1) % line.size()];
    const Vec2 after = line[(i + 1) % line.size()] - line[i];
    if (!(std::atan2(cross(before, after), dot(before, after)) >= least_turn)) return false;
  }
  return true;
}

std::unique_ptr<Obstacle> make_polygon(const Options& options) {
  std::vector<ClosedLine> lines = lines_of(options);
  const double rounding = options.real("rounding");
  if (lines.size() == 1) {
    if (twice_area(lines[0]) < 0.0) std::reverse(lines[0].begin(), lines[0].end());
    if (strictly_convex(lines[0])) return std::make_unique<RoundedHull>(lines[0], rounding);
  }
  std::vector<ClosedLine> bodies;
  std::vector<ClosedLine> holes;
  for (ClosedLine& line : lines) (twice_area(line) > 0.0 ? bodies : holes).push_back(std::move(line));
  const std::vector<ClosedLine> boundary = boundary_of(bodies, holes, Overlap::count);
  if (boundary.empty()) {
    refuse_option("polygon", "vertices", "outlines that run clockwise, which are holes, and nothing around them",
                  "a body that runs counterclockwise");
  }
  return std::make_unique<Part>(boundary, rounding);
}

}  // namespace

Component<Obstacle> polygon_component() {
  OptionSpec outlines;
  outlines.name = "outlines";
  outlines.type = OptionType::list;
  outlines.description =
      "how many of the vertices belong to each outline, where the body has several: parts of it, which may touch or "
      "overlap, counterclockwise, holes clockwise";
  return {"polygon",
          "a polygon, convex or not, with holes or in parts, grown by a distance, which rounds its corners",
          {points_option("vertices", 3, "corners of the polygon, in order around it either way"), outlines,
           positive_length_option("rounding", "distance by which the polygon is grown: radius of its corners")},
          make_polygon};
}

}  // namespace tendril
