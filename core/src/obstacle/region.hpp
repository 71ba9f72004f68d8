#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tendril/export.hpp"
#include "tendril/geometry.hpp"

/// Bodies of the plane that closed lines bound.
namespace tendril {

/// Corners in order; the first one is not repeated at the end.
using ClosedLine = std::vector<Vec2>;

/// Twice the area inside, > 0 if it runs counterclockwise.
TENDRIL_API double twice_area(const ClosedLine& line);

/// Whether the stretches from a to b and from c to d cross, not at their ends.
inline bool cross_inside(Vec2 a, Vec2 b, Vec2 c, Vec2 d) {
  return cross(b - a, c - a) * cross(b - a, d - a) < 0.0 && cross(d - c, a - c) * cross(d - c, b - c) < 0.0;
}

/// What is wrong with a line, for a user: "found ..., expected ...".
struct LineFault {
  std::string found, expected;
};

/// Why a line bounds no body: a corner twice, sides that cross or meet, no area. Corners are counted from `first` on.
TENDRIL_API std::optional<LineFault> fault_of(const ClosedLine& line, std::size_t first = 1);

/// What lies in a body where lines overlap.
enum class Overlap {
  cut,   ///< what lies in no hole
  count  ///< what lies in more bodies than holes: a body may stand in a hole of another one
};

/// The boundary of all that lies in one of `bodies` and, as `overlap` says, in no hole, whichever way the lines run:
/// lines with the body on their left. Where bodies meet there is none, so that a body may be given in parts. Corners at
/// which nothing turns are left out. Points nearer to each other than 1e-10 of the whole size count as one.
TENDRIL_API std::vector<ClosedLine> boundary_of(const std::vector<ClosedLine>& bodies,
                                                const std::vector<ClosedLine>& holes, Overlap overlap = Overlap::cut);

}  // namespace tendril
