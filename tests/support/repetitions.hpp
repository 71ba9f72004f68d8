#pragma once

#include <algorithm>
#include <cstdlib>

/// How often something random is repeated: as often as TENDRIL_REPETITIONS says, by default as often as a quick test
/// can.
inline int repetitions(int quick) {
  const char* asked = std::getenv("TENDRIL_REPETITIONS");
  return asked == nullptr ? quick : std::max(2, std::atoi(asked));
}
