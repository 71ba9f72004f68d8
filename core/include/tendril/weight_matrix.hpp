#pragma once

#include <span>
#include <string_view>

#include "tendril/export.hpp"
#include "tendril/objective_term.hpp"
#include "tendril/options.hpp"

namespace tendril {

/// A root W of a weight matrix Q, W^T W = Q, so that the quadratic form x^T Q x is the sum of squares |W x|^2.
///
/// `table` is what an option of type matrix gives: a square matrix, the diagonal expanded to one, or a single number,
/// which stands for a multiple of the identity of any size. `name` is the option's name, for messages. Returns size x
/// size. Throws Error if the table has another size, is not symmetric, or is not positive semidefinite; the message
/// names a negative eigenvalue. A diagonal gives its square roots exactly. (No Eigen matrix, since the result crosses
/// the plugin boundary.)
TENDRIL_API NumberTable weight_root(const NumberTable& table, int size, std::string_view name);

/// Adds |W x|^2 to a term, one residual for each row of W. x has as many entries as W has columns.
template <class T>
void add_weighted(const NumberTable& root, std::span<const T> x, Contribution<T>& out) {
  for (int row = 0; row < root.rows; ++row) {
    T residual{};
    for (int column = 0; column < root.columns; ++column) {
      residual += root(row, column) * x[static_cast<std::size_t>(column)];
    }
    out.residual(residual);
  }
}

}  // namespace tendril
