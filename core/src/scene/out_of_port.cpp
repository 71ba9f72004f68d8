#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "tendril/error.hpp"
#include "tendril/numbers.hpp"
#include "tendril/scene.hpp"

namespace tendril {
namespace {

/// A polynomial of x, `start` and `more` its coefficients, as one of the rest of [0,1] behind `from`.
void cut(double& start, std::vector<double>& more, double from) {
  if (more.empty()) return;
  // Taylor's shift by Horner's rule; each power is then stretched to what is left.
  std::vector<double> c{start};
  c.insert(c.end(), more.begin(), more.end());
  for (std::size_t done = 0; done + 1 < c.size(); ++done) {
    for (std::size_t i = c.size() - 1; i > done; --i) c[i - 1] += from * c[i];
  }
  double power = 1.0;
  for (double& coefficient : c) {
    coefficient *= power;
    power *= 1.0 - from;
  }
  start = c.front();
  more.assign(c.begin() + 1, c.end());
}

void cut(SegmentSpec& s, double inside) {
  const double from = inside / s.length;
  const double before = s.bending_stiffness;
  cut(s.bending_stiffness, s.more_bending_stiffness, from);
  cut(s.linear_density, s.more_linear_density, from);
  cut(s.rest_curvature, s.more_rest_curvature, from);
  cut(s.thickness, s.more_thickness, from);
  cut(s.axial_stiffness, s.more_axial_stiffness, from);
  s.length -= inside;
  // These go with the stiffness.
  s.torsional_stiffness *= s.bending_stiffness / before;
  s.out_of_plane_stiffness *= s.bending_stiffness / before;
}

/// A tendon's points from arc length 0 on; its limits belong to its largest offset.
void cut(ActuatorSpec& a, double inside) {
  const double whole = a.kind == ActuatorKind::tendon ? a.largest_offset() : 1.0;
  for (OffsetPoint& p : a.offset) p.arc_length -= inside;
  while (a.offset.size() > 1 && a.offset[1].arc_length <= 0.0) a.offset.erase(a.offset.begin());
  if (a.offset.size() > 1 && a.offset[0].arc_length < 0.0) {
    OffsetPoint& first = a.offset[0];
    const double share = -first.arc_length / (a.offset[1].arc_length - first.arc_length);
    first = {0.0, first.offset + share * (a.offset[1].offset - first.offset)};
  }
  if (a.kind != ActuatorKind::tendon) return;
  const double rest = a.largest_offset() / whole;
  a.moment_per_pressure *= rest;
  for (double& c : a.more_moment_per_pressure) c *= rest;
  a.minimum *= rest;
  a.maximum *= rest;
  if (rest < 0.0) std::swap(a.minimum, a.maximum);
}

}  // namespace

RodSpec out_of_port(const RodSpec& rod, double length) {
  const double whole = rod.length();
  // A part in 1e9 is the rounding of unit conversions, not a mistake.
  if (!(length > 0.0 && length <= whole * (1.0 + 1e-9))) {
    throw SceneError("rod.insertion", "the rod is " + shown(whole) + " m long, but " + shown(length) +
                                          " m of it are to be out of its port, expected more than 0 and at most all");
  }
  const double inside = whole - length;
  RodSpec out = rod;
  if (!(inside > whole * 1e-9)) return out;
  double left = inside;
  while (out.segments.size() > 1 && out.segments.front().length <= left + whole * 1e-9) {
    left = std::max(0.0, left - out.segments.front().length);
    out.segments.erase(out.segments.begin());
  }
  cut(out.segments.front(), left);
  for (std::size_t i = 0; i < out.actuators.size(); ++i) {
    ActuatorSpec& a = out.actuators[i];
    if (!(a.to > inside)) {
      throw SceneError("rod.actuator[" + std::to_string(i) + "]",
                       "the actuator ends at " + shown(a.to) + " m, inside the port that " + shown(inside) +
                           " m of the rod are drawn into: nothing of it is left");
    }
    cut(a, inside);
    a.from = std::max(0.0, a.from - inside);
    a.to -= inside;
  }
  std::erase_if(out.loads, [inside](const RodLoadSpec& l) { return l.to <= inside; });
  for (RodLoadSpec& l : out.loads) {
    l.from = std::max(0.0, l.from - inside);
    l.to -= inside;
  }
  return out;
}

}  // namespace tendril
