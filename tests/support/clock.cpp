#include "support/clock.hpp"

#include <time.h>

#include <atomic>

namespace {

std::atomic<std::chrono::nanoseconds::rep> advanced{0};

}  // namespace

// The program's own definition comes before that of the C++ library, for the libraries that it loads, too.
__attribute__((visibility("default"))) std::chrono::steady_clock::time_point std::chrono::steady_clock::now() noexcept {
  timespec time{};
  ::clock_gettime(CLOCK_MONOTONIC, &time);
  return time_point(seconds(time.tv_sec) + nanoseconds(time.tv_nsec + advanced.load()));
}

namespace tendril::support {

void advance_clock(std::chrono::seconds by) { advanced += std::chrono::nanoseconds(by).count(); }

}  // namespace tendril::support
