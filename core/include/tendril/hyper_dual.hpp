#pragma once

#include <cmath>

namespace tendril {

/// A number with two directions: value, derivative along a, derivative along b, mixed second derivative. With it a
/// formula written once gives exact first and second derivatives.
struct HyperDual {
  double v = 0.0;   ///< value
  double a = 0.0;   ///< derivative along a
  double b = 0.0;   ///< derivative along b
  double ab = 0.0;  ///< mixed second derivative

  constexpr HyperDual() = default;
  /// A constant: no derivatives.
  constexpr HyperDual(double value) : v(value) {}  // NOLINT(google-explicit-constructor): constants mix freely
  /// All four parts.
  constexpr HyperDual(double value, double along_a, double along_b, double mixed)
      : v(value), a(along_a), b(along_b), ab(mixed) {}

  ///@{
  /// The rules of differentiation, for all four parts.
  constexpr HyperDual& operator+=(const HyperDual& o) {
    return *this = HyperDual(v + o.v, a + o.a, b + o.b, ab + o.ab);
  }
  constexpr HyperDual& operator-=(const HyperDual& o) {
    return *this = HyperDual(v - o.v, a - o.a, b - o.b, ab - o.ab);
  }
  constexpr HyperDual& operator*=(const HyperDual& o) {
    return *this = HyperDual(v * o.v, v * o.a + a * o.v, v * o.b + b * o.v, v * o.ab + a * o.b + b * o.a + ab * o.v);
  }
  constexpr HyperDual& operator/=(const HyperDual& o) {
    return *this *= o.chain(1.0 / o.v, -1.0 / (o.v * o.v), 2.0 / (o.v * o.v * o.v));
  }
  ///@}

  /// f(x) from f, f' and f'' at v.
  constexpr HyperDual chain(double f, double d1, double d2) const { return {f, d1 * a, d1 * b, d1 * ab + d2 * a * b}; }
};

///@{
/// The rules of differentiation, for all four parts.
constexpr HyperDual operator+(HyperDual x, const HyperDual& y) { return x += y; }
constexpr HyperDual operator-(HyperDual x, const HyperDual& y) { return x -= y; }
constexpr HyperDual operator*(HyperDual x, const HyperDual& y) { return x *= y; }
constexpr HyperDual operator/(HyperDual x, const HyperDual& y) { return x /= y; }
constexpr HyperDual operator-(const HyperDual& x) { return {-x.v, -x.a, -x.b, -x.ab}; }
constexpr HyperDual operator+(const HyperDual& x) { return x; }
///@}
/// Comparison is by value: branches follow the point, not the direction.
/// Comparison is by value: branches follow the point, not the direction.
///@{
/// Of the values alone.
constexpr bool operator<(const HyperDual& x, const HyperDual& y) { return x.v < y.v; }
constexpr bool operator>(const HyperDual& x, const HyperDual& y) { return x.v > y.v; }
constexpr bool operator<=(const HyperDual& x, const HyperDual& y) { return x.v <= y.v; }
constexpr bool operator>=(const HyperDual& x, const HyperDual& y) { return x.v >= y.v; }
///@}

// One formula serves plain numbers too, also inside this namespace.
using std::abs;
using std::atan;
using std::atan2;
using std::cos;
using std::exp;
using std::hypot;
using std::log;
using std::pow;
using std::sin;
using std::sqrt;
using std::tan;
using std::tanh;

///@{
/// The function of the same name of the standard library with exact derivatives. Where it has none they are
/// not finite; of abs at 0 they are those of the right side.
inline HyperDual sqrt(const HyperDual& x) {
  const double r = std::sqrt(x.v);
  return x.chain(r, 0.5 / r, -0.25 / (r * x.v));
}
inline HyperDual exp(const HyperDual& x) {
  const double e = std::exp(x.v);
  return x.chain(e, e, e);
}
inline HyperDual log(const HyperDual& x) { return x.chain(std::log(x.v), 1.0 / x.v, -1.0 / (x.v * x.v)); }
inline HyperDual sin(const HyperDual& x) {
  const double s = std::sin(x.v);
  return x.chain(s, std::cos(x.v), -s);
}
inline HyperDual cos(const HyperDual& x) {
  const double c = std::cos(x.v);
  return x.chain(c, -std::sin(x.v), -c);
}
inline HyperDual tan(const HyperDual& x) {
  const double t = std::tan(x.v);
  const double d = 1.0 + t * t;
  return x.chain(t, d, 2.0 * t * d);
}
inline HyperDual atan(const HyperDual& x) {
  const double d = 1.0 / (1.0 + x.v * x.v);
  return x.chain(std::atan(x.v), d, -2.0 * x.v * d * d);
}
inline HyperDual tanh(const HyperDual& x) {
  const double t = std::tanh(x.v);
  const double d = 1.0 - t * t;
  return x.chain(t, d, -2.0 * t * d);
}
inline HyperDual abs(const HyperDual& x) { return x.v < 0.0 ? -x : x; }
inline HyperDual pow(const HyperDual& x, double p) {
  return x.chain(std::pow(x.v, p), p * std::pow(x.v, p - 1.0), p * (p - 1.0) * std::pow(x.v, p - 2.0));
}
inline HyperDual atan2(const HyperDual& y, const HyperDual& x) {
  // The gradient (x, -y)/(x^2 + y^2) is that of atan(y/x) on every branch.
  const double r2 = x.v * x.v + y.v * y.v;
  const double gy = x.v / r2;
  const double gx = -y.v / r2;
  const double hxy = (y.v * y.v - x.v * x.v) / (r2 * r2);
  const double hyy = -2.0 * x.v * y.v / (r2 * r2);
  const double hxx = -hyy;
  return {std::atan2(y.v, x.v), gy * y.a + gx * x.a, gy * y.b + gx * x.b,
          gy * y.ab + gx * x.ab + hyy * y.a * y.b + hxx * x.a * x.b + hxy * (y.a * x.b + x.a * y.b)};
}
inline HyperDual hypot(const HyperDual& x, const HyperDual& y) { return sqrt(x * x + y * y); }
///@}

}  // namespace tendril
