#include "counting_malloc.hpp"

#include <atomic>
#include <cstddef>

namespace {

std::atomic<long> count{0};

}  // namespace

// The C library's own entry points under other names. The definitions below take precedence for the whole process.
extern "C" {
void* __libc_malloc(std::size_t);               // NOLINT: glibc's name
void* __libc_calloc(std::size_t, std::size_t);  // NOLINT: glibc's name
void* __libc_realloc(void*, std::size_t);       // NOLINT: glibc's name

__attribute__((visibility("default"))) void* malloc(std::size_t size) {
  count.fetch_add(1, std::memory_order_relaxed);
  return __libc_malloc(size);
}

__attribute__((visibility("default"))) void* calloc(std::size_t n, std::size_t size) {
  count.fetch_add(1, std::memory_order_relaxed);
  return __libc_calloc(n, size);
}

__attribute__((visibility("default"))) void* realloc(void* old, std::size_t size) {
  count.fetch_add(1, std::memory_order_relaxed);
  return __libc_realloc(old, size);
}
}

namespace tendril::test {

long allocations() { return count.load(std::memory_order_relaxed); }

}  // namespace tendril::test
