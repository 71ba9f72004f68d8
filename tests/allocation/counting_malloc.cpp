#include "counting_malloc.hpp"

#include <malloc.h>

#include <atomic>
#include <cerrno>
#include <cstddef>

namespace {

std::atomic<long> count{0};
std::atomic<bool> watching{false};
std::atomic<long> live{0};
std::atomic<long> peak{0};

void* born(void* block) {
  count.fetch_add(1, std::memory_order_relaxed);
  if (block != nullptr && watching.load(std::memory_order_relaxed)) {
    const auto size = static_cast<long>(malloc_usable_size(block));
    const long now = live.fetch_add(size, std::memory_order_relaxed) + size;
    long most = peak.load(std::memory_order_relaxed);
    while (now > most && !peak.compare_exchange_weak(most, now, std::memory_order_relaxed)) {
    }
  }
  return block;
}

void gone(void* block) {
  if (block != nullptr && watching.load(std::memory_order_relaxed)) {
    live.fetch_sub(static_cast<long>(malloc_usable_size(block)), std::memory_order_relaxed);
  }
}

}  // namespace

// The C library's own entry points under other names. The definitions below take precedence for the whole process.
extern "C" {
void* __libc_malloc(std::size_t);                 // NOLINT: glibc's name
void* __libc_calloc(std::size_t, std::size_t);    // NOLINT: glibc's name
void* __libc_realloc(void*, std::size_t);         // NOLINT: glibc's name
void* __libc_memalign(std::size_t, std::size_t);  // NOLINT: glibc's name
void __libc_free(void*);                          // NOLINT: glibc's name

#define TENDRIL_TAKES_PRECEDENCE __attribute__((visibility("default")))

TENDRIL_TAKES_PRECEDENCE void* malloc(std::size_t size) { return born(__libc_malloc(size)); }

TENDRIL_TAKES_PRECEDENCE void* calloc(std::size_t n, std::size_t size) { return born(__libc_calloc(n, size)); }

TENDRIL_TAKES_PRECEDENCE void* realloc(void* old, std::size_t size) {
  gone(old);
  return born(__libc_realloc(old, size));
}

TENDRIL_TAKES_PRECEDENCE void* memalign(std::size_t alignment, std::size_t size) {
  return born(__libc_memalign(alignment, size));
}

TENDRIL_TAKES_PRECEDENCE void* aligned_alloc(std::size_t alignment, std::size_t size) {
  return born(__libc_memalign(alignment, size));
}

TENDRIL_TAKES_PRECEDENCE int posix_memalign(void** block, std::size_t alignment, std::size_t size) {
  *block = born(__libc_memalign(alignment, size));
  return *block != nullptr || size == 0 ? 0 : ENOMEM;
}

TENDRIL_TAKES_PRECEDENCE void free(void* block) {
  gone(block);
  __libc_free(block);
}
}

namespace tendril::test {

long allocations() { return count.load(std::memory_order_relaxed); }

void watch_heap() {
  live = 0;
  peak = 0;
  watching = true;
}

long heap_peak() {
  watching = false;
  return peak.load();
}

}  // namespace tendril::test
