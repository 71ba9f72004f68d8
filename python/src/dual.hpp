#pragma once

#include <pybind11/pybind11.h>

#include <vector>

namespace tendril::python {

/// A number with its first and second derivatives by the quantities that a term reads: plain arithmetic on it, and
/// numpy's functions, give exact derivatives. One evaluation in Python tells them all, so that core's many pairs of
/// directions cost one call.
class Dual {
 public:
  /// A constant: no derivatives, of as many variables as whatever it meets.
  explicit Dual(double value = 0.0) : value_(value) {}
  /// Variable `index` of `count`.
  Dual(double value, int count, int index);

  double value() const { return value_; }
  /// By variable i; by variables i and k. Zero for a constant.
  double slope(int i) const { return slopes_.empty() ? 0.0 : slopes_[static_cast<std::size_t>(i)]; }
  double bend(int i, int k) const;

  /// f of it, with f, f' and f'' at its value.
  Dual chain(double f, double d1, double d2) const;
  Dual& operator+=(const Dual& other);
  Dual& operator*=(double factor);
  friend Dual operator*(const Dual& a, const Dual& b);

 private:
  /// Refuses a number of another evaluation.
  void meet(const Dual& other) const;

  double value_;
  std::vector<double> slopes_, bends_;  // bends: packed, k <= i
};

/// Adds the class, called "Dual" in Python, and what numpy asks of it.
void add_dual(pybind11::module_& module);

}  // namespace tendril::python
