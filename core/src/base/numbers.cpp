#include "tendril/numbers.hpp"

#include <charconv>

namespace tendril {

namespace {

std::string formatted(double value, std::chars_format format, int precision) {
  char text[64];
  // Adding 0 takes the sign from a zero: nobody means -0.
  return {text, std::to_chars(text, text + sizeof text, value + 0.0, format, precision).ptr};
}

}  // namespace

std::string shown(double value, int digits) { return formatted(value, std::chars_format::general, digits); }

std::string shown_with_exponent(double value, int digits) {
  return formatted(value, std::chars_format::scientific, digits - 1);
}

}  // namespace tendril
