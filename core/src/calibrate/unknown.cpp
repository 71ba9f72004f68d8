#include "tendril/calibration_unknown.hpp"

namespace tendril {

std::string_view to_string(CalibrationUnknown unknown) {
  switch (unknown) {
    case CalibrationUnknown::stiffness:
      return "stiffness";
    case CalibrationUnknown::axial_stiffness:
      return "axial_stiffness";
    case CalibrationUnknown::modulus:
      return "modulus";
    case CalibrationUnknown::density:
      return "density";
    case CalibrationUnknown::rest_curvature:
      return "rest_curvature";
    case CalibrationUnknown::moment:
      return "moment";
    case CalibrationUnknown::force:
      return "force";
    case CalibrationUnknown::base_angle:
      return "base_angle";
    case CalibrationUnknown::base_x:
      return "base_x";
    case CalibrationUnknown::base_y:
      return "base_y";
  }
  return "?";
}

}  // namespace tendril
