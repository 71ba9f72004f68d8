#pragma once

#include <cmath>
#include <cstdint>
#include <optional>

namespace tendril {

/// What a value is as a whole number, as 6.0 is 6; none with a fraction, or beyond 1e15.
inline std::optional<std::int64_t> whole_number(double value) {
  constexpr double most = 1e15;  // every whole number up to it is a double
  if (!(std::abs(value) <= most) || value != std::round(value)) return std::nullopt;
  return static_cast<std::int64_t>(value);
}

}  // namespace tendril
