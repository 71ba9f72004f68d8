#pragma once

#include <span>
#include <string>

#include "estimate/estimate_fit.hpp"
#include "rod/rod.hpp"

namespace tendril {

/// What about points does not go with the rod and its moments, in words that follow "; ", for a fit that explains
/// little. Empty: nothing catches the eye.
std::string misfit_hint(const Rod& rod, const MeasuredShape& measured, std::span<const double> moments,
                        bool equal_spacing, double length);

/// Axes that points are often seen in by mistake, and a vector as these have it.
struct OtherAxes {
  const char* name;
  Vec2 (*seen)(Vec2);
};
inline constexpr OtherAxes other_axes[] = {{"x and y are swapped",
                                            [](Vec2 p) {
                                              return Vec2{p.y, p.x};
                                            }},
                                           {"y points the other way",
                                            [](Vec2 p) {
                                              return Vec2{p.x, -p.y};
                                            }},
                                           {"x points the other way", [](Vec2 p) {
                                              return Vec2{-p.x, p.y};
                                            }}};

}  // namespace tendril
