#pragma once

namespace tendril::test {

/// Calls of malloc, calloc and realloc in this process so far; Eigen and operator new both end there.
long allocations();

/// From now on the bytes that live on the heap are followed, until heap_peak() is asked for.
void watch_heap();
/// The most bytes that lived at once since watch_heap(), beyond those that lived then. Ends watching.
long heap_peak();

}  // namespace tendril::test
