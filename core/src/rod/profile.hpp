#pragma once

#include <vector>

#include "tendril/export.hpp"

namespace tendril {

/// A polynomial of arc length over a part of the rod:  sum_i coefficients[i] (s - from)^i.
struct TENDRIL_API ProfilePart {
  double from = 0.0;                      ///< arc length, units of L
  double to = 1.0;                        ///< arc length, units of L
  std::vector<double> coefficients{1.0};  ///< at least one

  /// The polynomial at s, or its derivative of that order.
  double at(double s, int derivative = 0) const;
  /// Whether it is the same all over the part.
  bool constant() const;
};

}  // namespace tendril
