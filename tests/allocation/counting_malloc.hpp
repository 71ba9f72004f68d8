#pragma once

namespace tendril::test {

/// Calls of malloc, calloc and realloc in this process so far; Eigen and operator new both end there.
long allocations();

}  // namespace tendril::test
