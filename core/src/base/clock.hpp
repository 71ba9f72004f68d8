#pragma once

#include <chrono>

namespace tendril {

/// Seconds of a clock that never goes back, since a beginning of its own.
inline double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace tendril
