#include "rod/kernels.hpp"

#include <cstdlib>

namespace tendril::kernels {
namespace {

/// Four doubles that need not be aligned; two registers where the processor has only narrow ones.
using Four = double __attribute__((vector_size(32), aligned(8)));

[[gnu::always_inline]] inline void add_scaled(Four& to, double weight, const double* p) {
  to += weight * *reinterpret_cast<const Four*>(p);
}

/// n columns, 4 (vectors - 1) < n <= 4 vectors, n >= 4. The last vector overlaps the one before it, and only its own
/// entries count. Several chains of sums: one alone would wait for its own last addition.
template <int vectors, int chains>
[[gnu::always_inline]] inline void block(int n, int leading, int count, const double* columns, const double* z,
                                         int stride, double* out) {
  Four sum[chains][vectors] = {};
  const int last = n - 4;
  const auto add = [&](Four(&to)[vectors], int g) __attribute__((always_inline)) {
    const double weight = z[g * stride];
    const double* column = columns + g * leading;
#pragma GCC unroll 8
    for (int v = 0; v + 1 < vectors; ++v) add_scaled(to[v], weight, column + 4 * v);
    add_scaled(to[vectors - 1], weight, column + last);
  };
  int g = 0;
  for (; g + chains <= count; g += chains) {
#pragma GCC unroll 8
    for (int k = 0; k < chains; ++k) add(sum[k], g + k);
  }
  for (; g < count; ++g) add(sum[0], g);
#pragma GCC unroll 8
  for (int v = 0; v < vectors; ++v) {
    Four total = sum[0][v];
#pragma GCC unroll 8
    for (int k = 1; k < chains; ++k) total += sum[k][v];
    const int from = v + 1 < vectors ? 4 * v : last;
#pragma GCC unroll 4
    for (int i = 0; i < 4; ++i) {
      if (from + i >= 4 * v) out[from + i] += total[i];
    }
  }
}

[[gnu::always_inline]] inline void all_blocks(int n, int leading, int count, const double* columns, const double* z,
                                              int stride, double* out) {
  while (n >= 28) {
    block<6, 1>(24, leading, count, columns, z, stride, out);
    n -= 24;
    columns += 24;
    out += 24;
  }
  switch ((n + 3) / 4) {
    case 0:
      break;
    case 1:
      if (n == 4) {
        block<1, 4>(n, leading, count, columns, z, stride, out);
        break;
      }
      for (int i = 0; i < n; ++i) {
        double sum = 0.0;
        for (int g = 0; g < count; ++g) sum += z[g * stride] * columns[g * leading + i];
        out[i] += sum;
      }
      break;
    case 2:
      block<2, 4>(n, leading, count, columns, z, stride, out);
      break;
    case 3:
      block<3, 2>(n, leading, count, columns, z, stride, out);
      break;
    case 4:
      block<4, 2>(n, leading, count, columns, z, stride, out);
      break;
    case 5:
      block<5, 1>(n, leading, count, columns, z, stride, out);
      break;
    case 6:
      block<6, 1>(n, leading, count, columns, z, stride, out);
      break;
    default:
      block<7, 1>(n, leading, count, columns, z, stride, out);
      break;
  }
}

/// The same for processors without wide units, in a form that the compiler maps to narrow ones.
template <int n>
[[gnu::always_inline]] inline void narrow_block(int leading, int count, const double* columns, const double* z,
                                                int stride, double* out) {
  double sum[n] = {};
  for (int g = 0; g < count; ++g) {
    const double weight = z[g * stride];
    const double* column = columns + g * leading;
    for (int i = 0; i < n; ++i) sum[i] += weight * column[i];
  }
  for (int i = 0; i < n; ++i) out[i] += sum[i];
}

void portable(int n, int leading, int count, const double* columns, const double* z, int stride, double* out) {
  for (; n >= 12; n -= 12, columns += 12, out += 12) narrow_block<12>(leading, count, columns, z, stride, out);
  for (; n >= 6; n -= 6, columns += 6, out += 6) narrow_block<6>(leading, count, columns, z, stride, out);
  for (; n >= 2; n -= 2, columns += 2, out += 2) narrow_block<2>(leading, count, columns, z, stride, out);
  if (n == 1) narrow_block<1>(leading, count, columns, z, stride, out);
}

using Kernel = void (*)(int, int, int, const double*, const double*, int, double*);

#if defined(__x86_64__)
__attribute__((target("avx2,fma"))) void wide(int n, int leading, int count, const double* columns, const double* z,
                                              int stride, double* out) {
  all_blocks(n, leading, count, columns, z, stride, out);
}
#endif

Kernel choose() {
#if defined(__x86_64__)
  // TENDRIL_PORTABLE=1 shows what the wider units bring, and makes results equal on all processors.
  if (std::getenv("TENDRIL_PORTABLE") == nullptr && __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
    return wide;
  }
#endif
  return portable;
}

const Kernel kernel = choose();

}  // namespace

void add_weighted_columns(int n, int leading, int count, const double* columns, const double* z, int stride,
                          double* out) {
  kernel(n, leading, count, columns, z, stride, out);
}

}  // namespace tendril::kernels
