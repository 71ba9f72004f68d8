#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "figure/outlines.hpp"
#include "result/result_object.hpp"

/// Reading what docs/drawing.md describes.
namespace tendril::app {

inline Vec2 point(const Json& json) { return {json[0], json[1]}; }

inline bool presses(const Json& contact) { return contact.value("force", 0.0) > 0.0 && contact.contains("normal"); }
inline bool slips(const Json& contact) { return presses(contact) && contact.value("tangential_force", 0.0) != 0.0; }
inline bool touches(const Json& contact) { return !contact.contains("force"); }
inline bool rubs(const Json& contact) { return presses(contact) && contact.contains("friction"); }

template <bool test(const Json&)>
bool has_contact(const Json& frame) {
  const Json& contacts = frame["contacts"];
  return std::any_of(contacts.begin(), contacts.end(), test);
}

inline bool has_target(const Json& frame) { return frame.contains("target") && frame["target"].contains("position"); }
inline bool has_direction(const Json& frame) { return has_target(frame) && frame["target"].contains("angle"); }
template <const char* key>
bool has(const Json& frame) {
  return frame.contains(key) && !frame[key].empty();
}
inline constexpr char palm_key[] = "palm", measured_key[] = "measured", tips_key[] = "tips",
                      obstacles_key[] = "obstacles", path_key[] = "path", hold_key[] = "hold";

/// Around an obstacle of a drawing.
inline std::vector<ClosedLine> lines_of(const Json& shape) {
  std::vector<ClosedLine> lines;
  lines.reserve(shape["outlines"].size());
  for (const Json& outline : shape["outlines"]) {
    ClosedLine& line = lines.emplace_back();
    line.reserve(outline.size());
    for (const Json& p : outline) line.push_back(point(p));
  }
  return lines;
}

/// Where a rod is held.
struct Clamp {
  Vec2 base{};
  double angle = 0.0;
};
inline Clamp clamp_of(const Json& rod) {
  const Json& line = rod["line"];
  const Vec2 base = point(line[0]);
  if (rod.contains("along")) return {base, rod["along"][0][1]};
  const Vec2 along = line.size() > 1 ? point(line[1]) - base : Vec2{1.0, 0.0};
  return {base, std::atan2(along.y, along.x)};
}

/// A block of the data file; with its end no name begins another one, as gnuplot looks for them.
inline std::string block_of(std::size_t index, const std::string& name) {
  return fmt::format("frame {}: {}.", index + 1, name);
}

}  // namespace tendril::app
