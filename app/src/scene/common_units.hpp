#pragma once

#include <array>
#include <string_view>

namespace tendril::app {

/// A unit as scenes mostly write it, of the dimension with this SI unit, and its size there, to the last bit what
/// UDUNITS makes of it. Reading its database takes longer than planning a pose: a scene with no other units spares
/// that.
struct CommonUnit {
  std::string_view dimension, unit;
  double size;
};

inline constexpr std::array<CommonUnit, 31> common_units{{{"m", "m", 1.0},
                                                          {"m", "mm", 1e-3},
                                                          {"m", "cm", 1e-2},
                                                          {"m", "um", 1e-6},
                                                          {"rad", "rad", 1.0},
                                                          {"rad", "deg", 0.017453292519943295},
                                                          {"1/m", "1/m", 1.0},
                                                          {"1/m", "1/mm", 1e3},
                                                          {"N", "N", 1.0},
                                                          {"N", "mN", 1e-3},
                                                          {"N m", "N m", 1.0},
                                                          {"N m", "N mm", 1e-3},
                                                          {"N m", "mN m", 1e-3},
                                                          {"N m^2", "N m^2", 1.0},
                                                          {"N m^2", "N mm^2", 1e-6},
                                                          {"m/s^2", "m/s^2", 1.0},
                                                          {"kg/m", "kg/m", 1.0},
                                                          {"kg/m", "g/m", 1e-3},
                                                          {"kg/m^3", "kg/m^3", 1.0},
                                                          {"N/m", "N/m", 1.0},
                                                          {"kg", "kg", 1.0},
                                                          {"kg", "g", 1e-3},
                                                          {"s", "s", 1.0},
                                                          {"s", "ms", 1e-3},
                                                          {"Pa", "Pa", 1.0},
                                                          {"Pa", "kPa", 1e3},
                                                          {"Pa", "MPa", 1e6},
                                                          {"Pa", "GPa", 1e9},
                                                          {"Pa", "bar", 1e5},
                                                          {"N m/Pa", "N m/Pa", 1.0},
                                                          {"N m/Pa", "N mm/kPa", 1e-6}}};

}  // namespace tendril::app
