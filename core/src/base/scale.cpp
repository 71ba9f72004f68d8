#include "tendril/scale.hpp"

#include <charconv>
#include <cmath>

namespace tendril {

double Scale::unit(const Dimension& d) const { return std::pow(length, d.length) * std::pow(force(), d.force); }

double Scale::to_dimensionless(double si, const Dimension& d) const { return round_to_12_digits(si / unit(d)); }

double round_to_12_digits(double value) {
  if (value == 0.0 || !std::isfinite(value)) return value;
  // Through decimal text and back: the same 12 digits then always give the same number, which no formula with powers of
  // ten achieves. Neither direction depends on the locale.
  char text[32];
  const auto written = std::to_chars(text, text + sizeof text, value, std::chars_format::scientific, 11);
  double rounded = value;
  std::from_chars(text, written.ptr, rounded);
  return rounded;
}

}  // namespace tendril
