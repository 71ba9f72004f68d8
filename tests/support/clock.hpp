#pragma once

#include <chrono>

namespace tendril::support {

/// Whatever reads std::chrono::steady_clock in this process finds it so much later from now on, so that a test of a
/// time limit neither waits nor depends on how fast the machine is. For programs that link tendril-test-clock.
void advance_clock(std::chrono::seconds by);

}  // namespace tendril::support
