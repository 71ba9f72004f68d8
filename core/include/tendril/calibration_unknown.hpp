#pragma once

#include <string_view>

#include "tendril/export.hpp"

namespace tendril {

/// A kind of number that a calibration can find.
enum class CalibrationUnknown {
  stiffness,        ///< factor on the bending stiffness of a segment, or of all
  axial_stiffness,  ///< factor on the axial stiffness, likewise
  modulus,          ///< factor on both, likewise
  density,          ///< factor on the linear density of all segments
  rest_curvature,   ///< of a segment, 1/m
  moment,           ///< moment of an actuator per power of what it is told, N m per SI unit of the input to that power
  force,            ///< likewise its axial force, beside that of a tendon
  base_angle,       ///< rad
  base_x,           ///< m
  base_y            ///< m
};
TENDRIL_API std::string_view to_string(CalibrationUnknown unknown);  ///< The word that scenes use.

/// Whether it is a factor on what the scene says.
constexpr bool is_factor(CalibrationUnknown unknown) {
  return unknown == CalibrationUnknown::stiffness || unknown == CalibrationUnknown::axial_stiffness ||
         unknown == CalibrationUnknown::modulus || unknown == CalibrationUnknown::density;
}
/// Whether it is a law: a polynomial of what an actuator is told.
constexpr bool is_law(CalibrationUnknown unknown) {
  return unknown == CalibrationUnknown::moment || unknown == CalibrationUnknown::force;
}
/// Whether it is a coordinate of the base.
constexpr bool is_base(CalibrationUnknown unknown) {
  return unknown == CalibrationUnknown::base_angle || unknown == CalibrationUnknown::base_x ||
         unknown == CalibrationUnknown::base_y;
}

}  // namespace tendril
