// The one loop in which evaluations spend their time, against the plain sum, for every size of its blocks.

#include "rod/kernels.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace tendril {
namespace {

TEST(Kernels, AddWeightedColumnsOfEverySize) {
  for (int n = 1; n <= 80; ++n) {
    for (const int count : {0, 1, 2, 3, 4, 5, 7, 12}) {
      SCOPED_TRACE(std::to_string(n) + " rows, " + std::to_string(count) + " columns");
      const int leading = n + 3;
      const int stride = 2;
      std::vector<double> columns(static_cast<std::size_t>(leading * count) + 1);
      std::vector<double> z(static_cast<std::size_t>(stride * count) + 1);
      // Whole numbers, so that every sum is exact in any order.
      for (std::size_t i = 0; i < columns.size(); ++i) columns[i] = static_cast<double>(i * 7 % 23) - 11.0;
      for (std::size_t i = 0; i < z.size(); ++i) z[i] = static_cast<double>(i * 5 % 13) - 6.0;
      // One entry more, which must stay.
      std::vector<double> out(static_cast<std::size_t>(n) + 1);
      for (std::size_t i = 0; i < out.size(); ++i) out[i] = static_cast<double>(i);
      std::vector<double> expected = out;
      for (int g = 0; g < count; ++g) {
        for (int i = 0; i < n; ++i) {
          expected[static_cast<std::size_t>(i)] +=
              z[static_cast<std::size_t>(g * stride)] * columns[static_cast<std::size_t>(g * leading + i)];
        }
      }
      kernels::add_weighted_columns(n, leading, count, columns.data(), z.data(), stride, out.data());
      EXPECT_EQ(out, expected);
    }
  }
}

}  // namespace
}  // namespace tendril
