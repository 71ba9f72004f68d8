#pragma once

#include <vector>

#include "tendril/geometry.hpp"

namespace tendril::app {

/// A closed line, its first corner not repeated: counterclockwise around a body, clockwise around a hole in one.
using Outline = std::vector<Vec2>;

/// Twice the area inside, > 0 if it runs counterclockwise.
double twice_area(const Outline& line);

/// Whether a side of one outline crosses one of the other; to touch is not to cross.
bool cross_each_other(const Outline& a, const Outline& b);

/// The same bodies with fewer corners: each contains the one that was given, and reaches beyond it by no more than
/// `tolerance`. Outlines that do not cross themselves or each other do not afterwards.
std::vector<Outline> simplified(const std::vector<Outline>& lines, double tolerance);

}  // namespace tendril::app
