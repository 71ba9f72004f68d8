#pragma once

#include <algorithm>
#include <cmath>

namespace tendril::kit {

/// A derivative by differences, and how far off it may be.
struct Difference {
  double value = 0.0;
  double error = 0.0;
};

/// df/dt at t from the four neighbours at h and 2h. The error is what halving the step changes, which bounds the
/// truncation of a smooth function, and the rounding of values that are accurate to 1e-14 of their size.
template <class F>
Difference difference(F&& f, double t, double h) {
  double size = 0.0;
  const auto at = [&](double shift) {
    const double value = f(t + shift);
    size = std::max(size, std::abs(value));
    return value;
  };
  const auto fourth_order = [&](double step) {
    return (8.0 * (at(step) - at(-step)) - (at(2.0 * step) - at(-2.0 * step))) / (12.0 * step);
  };
  const double coarse = fourth_order(h);
  const double fine = fourth_order(0.5 * h);
  return {fine, std::abs(fine - coarse) + 1e-14 * size / h};
}

/// Whether a stated derivative is the one of the differences. Differences whose own error is large decide nothing, but
/// those of a smooth function are good to 1e-8 of its size, which is added for functions that are not evaluated to the
/// last digit.
inline bool agrees(double stated, const Difference& found, double size) {
  return std::abs(stated - found.value) <= 2.0 * found.error + 1e-8 * std::max(size, std::abs(found.value));
}

}  // namespace tendril::kit
