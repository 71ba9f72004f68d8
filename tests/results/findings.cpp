#include "findings.hpp"

#include <cmath>
#include <cstdio>

namespace tendril::results {

std::string Findings::where() const {
  std::string text;
  for (const std::string& place : places_) text += place + ": ";
  return text;
}

void Findings::near(const std::string& what, double value, double expected, double tolerance) {
  // Written so that what is not a number does not fit.
  if (std::abs(value - expected) <= tolerance) return;
  char numbers[120];
  std::snprintf(numbers, sizeof numbers, " is %.17g, but %.17g follows from the rest (allowed: %.1e)", value, expected,
                tolerance);
  list_.push_back(where() + what + numbers);
}

void Findings::that(bool holds, const std::string& what) {
  if (!holds) list_.push_back(where() + what);
}

}  // namespace tendril::results
