#include "rod/profile.hpp"

#include <algorithm>

namespace tendril {

double ProfilePart::at(double s, int derivative) const {
  double value = 0.0;
  for (int i = static_cast<int>(coefficients.size()) - 1; i >= derivative; --i) {
    double factor = 1.0;
    for (int k = 0; k < derivative; ++k) factor *= i - k;
    value = value * (s - from) + factor * coefficients[static_cast<std::size_t>(i)];
  }
  return value;
}

bool ProfilePart::constant() const {
  return std::all_of(coefficients.begin() + 1, coefficients.end(), [](double c) { return c == 0.0; });
}

}  // namespace tendril
