#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "scene/outline.hpp"

namespace tendril::app {

/// A cubic Bezier curve.
using Cubic = std::array<Vec2, 4>;

/// A way that ends where it began: it is closed by a straight line if need be.
using CurvedLine = std::vector<Cubic>;

Cubic straight(Vec2 from, Vec2 to);

/// Adds a part of an ellipse around `center` with the half axes `first` and `second`, which need not be square, between
/// two angles; as curves that differ from it by less than 1e-8 of its size.
void add_arc(CurvedLine& line, Vec2 center, Vec2 first, Vec2 second, double from, double to);

/// Twice the area inside, > 0 if it runs counterclockwise.
double twice_area(const CurvedLine& line);

/// The other way round.
CurvedLine reversed(const CurvedLine& line);

/// Straight sides around what lies to the left of the line, which they contain and leave by no more than `tolerance`.
Outline flattened(const CurvedLine& line, double tolerance);

/// The lines of an SVG path: "M 0 0 L 10 0 ...". Throws Error that says which character is wrong.
std::vector<CurvedLine> lines_of_path(std::string_view data);

}  // namespace tendril::app
