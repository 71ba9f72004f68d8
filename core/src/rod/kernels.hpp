#pragma once

#include "tendril/export.hpp"

// Not part of what is installed; exported for its tests.
namespace tendril::kernels {

/// out[0..n) += sum_g z[g * stride] * columns[g * leading + i] over `count` columns: the one loop in which evaluations
/// spend their time. It runs over blocks of a constant size, so that sums stay in registers, and is compiled once more
/// for wider vector units, chosen when the library is loaded.
TENDRIL_API void add_weighted_columns(int n, int leading, int count, const double* columns, const double* z, int stride,
                                      double* out);

}  // namespace tendril::kernels
