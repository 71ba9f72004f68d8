#include "dual.hpp"

#include <pybind11/operators.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "tendril/hyper_dual.hpp"

namespace py = pybind11;

namespace tendril::python {

namespace {

std::size_t packed(int i, int k) {
  const auto row = static_cast<std::size_t>(std::max(i, k));
  return row * (row + 1) / 2 + static_cast<std::size_t>(std::min(i, k));
}

Dual operator+(Dual a, const Dual& b) { return a += b; }
Dual operator-(Dual a) { return a *= -1.0; }
Dual operator-(const Dual& a, const Dual& b) { return a + -b; }
Dual inverse(const Dual& x) {
  const double r = 1.0 / x.value();
  return x.chain(r, -r * r, 2.0 * r * r * r);
}
Dual operator/(const Dual& a, const Dual& b) { return a * inverse(b); }

/// A function of one number by core's own derivatives of it.
template <class F>
Dual apply(const Dual& x, F f) {
  const HyperDual y = f(HyperDual(x.value(), 1.0, 1.0, 0.0));
  return x.chain(y.v, y.a, y.ab);
}

Dual exp(const Dual& x) {
  return apply(x, [](const HyperDual& v) { return tendril::exp(v); });
}
Dual log(const Dual& x) {
  return apply(x, [](const HyperDual& v) { return tendril::log(v); });
}
Dual sqrt(const Dual& x) {
  return apply(x, [](const HyperDual& v) { return tendril::sqrt(v); });
}
Dual power(const Dual& x, double exponent) {
  // Of a whole number every base has a power, and the first two derivatives of the square are no 0/0 at 0.
  if (exponent == 2.0) return x * x;
  if (exponent == 1.0) return x;
  if (exponent == 0.0) return x.chain(1.0, 0.0, 0.0);
  return apply(x, [exponent](const HyperDual& v) { return tendril::pow(v, exponent); });
}
Dual power(const Dual& base, const Dual& exponent) { return exp(exponent * log(base)); }

/// atan2(y, x) = atan of their ratio, continued: its rates are those of whichever ratio is finite.
Dual arctan2(const Dual& y, const Dual& x) {
  const bool steep = std::abs(y.value()) > std::abs(x.value());
  const Dual ratio = steep ? x / y : y / x;
  Dual angle = apply(ratio, [](const HyperDual& v) { return tendril::atan(v); });
  if (steep) angle *= -1.0;
  return angle += Dual(std::atan2(y.value(), x.value()) - angle.value());
}

template <class F>
void function(py::class_<Dual>& type, const char* name, F f) {
  type.def(name, [f](const Dual& x) { return apply(x, f); });
}

/// The operators with numbers on either side. Integers and numpy's scalars come as double.
void add_arithmetic(py::class_<Dual>& type) {
  const auto both = [&type](const char* name, const char* turned, auto f) {
    type.def(
        name, [f](const Dual& a, const Dual& b) { return f(a, b); }, py::is_operator());
    type.def(
        name, [f](const Dual& a, double b) { return f(a, Dual(b)); }, py::is_operator());
    type.def(
        turned, [f](const Dual& b, double a) { return f(Dual(a), b); }, py::is_operator());
  };
  both("__add__", "__radd__", [](const Dual& a, const Dual& b) { return a + b; });
  both("__sub__", "__rsub__", [](const Dual& a, const Dual& b) { return a - b; });
  both("__mul__", "__rmul__", [](const Dual& a, const Dual& b) { return a * b; });
  both("__truediv__", "__rtruediv__", [](const Dual& a, const Dual& b) { return a / b; });
  type.def(
      "__pow__", [](const Dual& a, double b) { return power(a, b); }, py::is_operator());
  type.def(
      "__pow__", [](const Dual& a, const Dual& b) { return power(a, b); }, py::is_operator());
  type.def(
      "__rpow__", [](const Dual& b, double a) { return power(Dual(a), b); }, py::is_operator());
  type.def("__neg__", [](const Dual& a) { return -a; });
  type.def("__pos__", [](const Dual& a) { return a; });
  type.def("__abs__", [](const Dual& a) { return a.value() < 0.0 ? -a : a; });
  type.def("__bool__", [](const Dual& a) { return a.value() != 0.0; });
  // Comparison is by value: branches follow the point.
  const auto compared = [&type](const char* name, auto f) {
    type.def(
        name, [f](const Dual& a, const Dual& b) { return f(a.value(), b.value()); }, py::is_operator());
    type.def(
        name, [f](const Dual& a, double b) { return f(a.value(), b); }, py::is_operator());
  };
  compared("__lt__", [](double a, double b) { return a < b; });
  compared("__le__", [](double a, double b) { return a <= b; });
  compared("__gt__", [](double a, double b) { return a > b; });
  compared("__ge__", [](double a, double b) { return a >= b; });
  compared("__eq__", [](double a, double b) { return a == b; });
  compared("__ne__", [](double a, double b) { return a != b; });
  type.attr("__hash__") = py::none();
}

}  // namespace

Dual::Dual(double value, int count, int index)
    : value_(value),
      slopes_(static_cast<std::size_t>(count), 0.0),
      bends_(static_cast<std::size_t>(count) * (static_cast<std::size_t>(count) + 1) / 2, 0.0) {
  slopes_[static_cast<std::size_t>(index)] = 1.0;
}

double Dual::bend(int i, int k) const { return bends_.empty() ? 0.0 : bends_[packed(i, k)]; }

Dual Dual::chain(double f, double d1, double d2) const {
  Dual y(*this);
  y.value_ = f;
  std::size_t at = 0;
  for (std::size_t i = 0; i < slopes_.size(); ++i) {
    for (std::size_t k = 0; k <= i; ++k, ++at) y.bends_[at] = d1 * bends_[at] + d2 * slopes_[i] * slopes_[k];
    y.slopes_[i] = d1 * slopes_[i];
  }
  return y;
}

void Dual::meet(const Dual& other) const {
  if (slopes_.size() == other.slopes_.size() || slopes_.empty() || other.slopes_.empty()) return;
  throw py::value_error("two quantities with derivatives come from different evaluations; keep none of them");
}

Dual& Dual::operator+=(const Dual& other) {
  meet(other);
  value_ += other.value_;
  if (other.slopes_.empty()) return *this;
  if (slopes_.empty()) {
    slopes_ = other.slopes_;
    bends_ = other.bends_;
    return *this;
  }
  for (std::size_t i = 0; i < slopes_.size(); ++i) slopes_[i] += other.slopes_[i];
  for (std::size_t i = 0; i < bends_.size(); ++i) bends_[i] += other.bends_[i];
  return *this;
}

Dual& Dual::operator*=(double factor) {
  value_ *= factor;
  for (double& slope : slopes_) slope *= factor;
  for (double& bend : bends_) bend *= factor;
  return *this;
}

Dual operator*(const Dual& a, const Dual& b) {
  a.meet(b);
  if (a.slopes_.empty()) return Dual(b) *= a.value_;
  if (b.slopes_.empty()) return Dual(a) *= b.value_;
  Dual y(a);
  y.value_ = a.value_ * b.value_;
  std::size_t at = 0;
  for (std::size_t i = 0; i < a.slopes_.size(); ++i) {
    y.slopes_[i] = a.value_ * b.slopes_[i] + b.value_ * a.slopes_[i];
    for (std::size_t k = 0; k <= i; ++k, ++at) {
      y.bends_[at] =
          a.value_ * b.bends_[at] + b.value_ * a.bends_[at] + a.slopes_[i] * b.slopes_[k] + a.slopes_[k] * b.slopes_[i];
    }
  }
  return y;
}

void add_dual(py::module_& module) {
  py::class_<Dual> type(module, "Dual");
  type.def_property_readonly("value", &Dual::value);
  add_arithmetic(type);
  // numpy's functions call methods of these names.
  function(type, "sin", [](const HyperDual& x) { return tendril::sin(x); });
  function(type, "cos", [](const HyperDual& x) { return tendril::cos(x); });
  function(type, "tan", [](const HyperDual& x) { return tendril::tan(x); });
  function(type, "arctan", [](const HyperDual& x) { return tendril::atan(x); });
  function(type, "tanh", [](const HyperDual& x) { return tendril::tanh(x); });
  function(type, "sinh", [](const HyperDual& x) { return 0.5 * (tendril::exp(x) - tendril::exp(-x)); });
  function(type, "cosh", [](const HyperDual& x) { return 0.5 * (tendril::exp(x) + tendril::exp(-x)); });
  type.def("exp", &exp).def("log", &log).def("sqrt", &sqrt);
  type.def("arctan2", &arctan2);
  type.def("arctan2", [](const Dual& y, double x) { return arctan2(y, Dual(x)); });
  type.def("hypot", [](const Dual& a, const Dual& b) { return sqrt(a * a + b * b); });
  type.def("hypot", [](const Dual& a, double b) { return sqrt(a * a + Dual(b * b)); });
  type.def("conjugate", [](const Dual& x) { return x; });  // numpy's vdot and norm ask for it
  type.def("__float__", [](const Dual&) -> double {
    throw py::type_error(
        "a quantity with derivatives is no plain number; use numpy's functions (numpy.sin) instead of "
        "math's, and keep float() away from it");
  });
  type.def("__repr__", [](const Dual& x) { return py::str("Dual({})").format(x.value()); });
}

}  // namespace tendril::python
