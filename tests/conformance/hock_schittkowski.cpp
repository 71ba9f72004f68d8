#include <algorithm>
#include <cmath>

#include "known_problems.hpp"

namespace tendril::conformance {

namespace {

template <int n, int m, int r = 0>
struct Extent {
  int variables = n;
  int rows = m;
  int residuals = r;
  void bounds(Bounds) const {}
};

/// All rows are c >= 0, as the collection writes its inequalities.
void inequalities(Bounds b, Eigen::Index first = 0) {
  for (Eigen::Index i = first; i < b.row_upper.size(); ++i) b.row_upper[i] = infinity;
}

struct Hs1 : Extent<2, 0, 2> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.residuals[0] = 10.0 * (x[1] - x[0] * x[0]);
    out.residuals[1] = 1.0 - x[0];
  }
  void bounds(Bounds b) const { b.lower[1] = -1.5; }
};

struct Hs3 : Extent<2, 0> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = x[1] + 1e-5 * (x[1] - x[0]) * (x[1] - x[0]);
  }
  void bounds(Bounds b) const { b.lower[1] = 0.0; }
};

struct Hs4 : Extent<2, 0> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = pow(x[0] + 1.0, 3.0) / 3.0 + x[1];
  }
  void bounds(Bounds b) const { b.lower << 1.0, 0.0; }
};

struct Hs5 : Extent<2, 0> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    using std::sin;
    out.rest = sin(x[0] + x[1]) + (x[0] - x[1]) * (x[0] - x[1]) - 1.5 * x[0] + 2.5 * x[1] + 1.0;
  }
  void bounds(Bounds b) const {
    b.lower << -1.5, -3.0;
    b.upper << 4.0, 3.0;
  }
};

struct Hs6 : Extent<2, 1, 1> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.residuals[0] = 1.0 - x[0];
    out.rows[0] = 10.0 * (x[1] - x[0] * x[0]);
  }
};

struct Hs7 : Extent<2, 1> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    using std::log;
    const T s = 1.0 + x[0] * x[0];
    out.rest = log(s) - x[1];
    out.rows[0] = s * s + x[1] * x[1] - 4.0;
  }
};

struct Hs8 : Extent<2, 2> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = -1.0;
    out.rows[0] = x[0] * x[0] + x[1] * x[1] - 25.0;
    out.rows[1] = x[0] * x[1] - 9.0;
  }
};

struct Hs9 : Extent<2, 1> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    using std::cos;
    using std::sin;
    out.rest = sin(M_PI / 12.0 * x[0]) * cos(M_PI / 16.0 * x[1]);
    out.rows[0] = 4.0 * x[0] - 3.0 * x[1];
  }
};

struct Hs10 : Extent<2, 1> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = x[0] - x[1];
    out.rows[0] = -3.0 * x[0] * x[0] + 2.0 * x[0] * x[1] - x[1] * x[1] + 1.0;
  }
  void bounds(Bounds b) const { inequalities(b); }
};

struct Hs11 : Extent<2, 1> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = (x[0] - 5.0) * (x[0] - 5.0) + x[1] * x[1] - 25.0;
    out.rows[0] = x[1] - x[0] * x[0];
  }
  void bounds(Bounds b) const { inequalities(b); }
};

struct Hs12 : Extent<2, 1> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = 0.5 * x[0] * x[0] + x[1] * x[1] - x[0] * x[1] - 7.0 * x[0] - 7.0 * x[1];
    out.rows[0] = 25.0 - 4.0 * x[0] * x[0] - x[1] * x[1];
  }
  void bounds(Bounds b) const { inequalities(b); }
};

struct Hs14 : Extent<2, 2, 2> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.residuals[0] = x[0] - 2.0;
    out.residuals[1] = x[1] - 1.0;
    out.rows[0] = x[0] - 2.0 * x[1] + 1.0;
    out.rows[1] = 1.0 - 0.25 * x[0] * x[0] - x[1] * x[1];
  }
  void bounds(Bounds b) const { inequalities(b, 1); }
};

struct Hs21 : Extent<2, 1, 2> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.residuals[0] = 0.1 * x[0];
    out.residuals[1] = x[1];
    out.rest = -100.0;
    out.rows[0] = 10.0 * x[0] - x[1] - 10.0;
  }
  void bounds(Bounds b) const {
    inequalities(b);
    b.lower << 2.0, -50.0;
    b.upper << 50.0, 50.0;
  }
};

struct Hs22 : Extent<2, 2, 2> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.residuals[0] = x[0] - 2.0;
    out.residuals[1] = x[1] - 1.0;
    out.rows[0] = 2.0 - x[0] - x[1];
    out.rows[1] = x[1] - x[0] * x[0];
  }
  void bounds(Bounds b) const { inequalities(b); }
};

struct Hs24 : Extent<2, 3> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    const double root = std::sqrt(3.0);
    out.rest = ((x[0] - 3.0) * (x[0] - 3.0) - 9.0) * x[1] * x[1] * x[1] / (27.0 * root);
    out.rows[0] = x[0] / root - x[1];
    out.rows[1] = x[0] + root * x[1];
    out.rows[2] = 6.0 - x[0] - root * x[1];
  }
  void bounds(Bounds b) const {
    inequalities(b);
    b.lower.setZero();
  }
};

struct Hs28 : Extent<3, 1, 2> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.residuals[0] = x[0] + x[1];
    out.residuals[1] = x[1] + x[2];
    out.rows[0] = x[0] + 2.0 * x[1] + 3.0 * x[2] - 1.0;
  }
};

struct Hs29 : Extent<3, 1> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = -1.0 * x[0] * x[1] * x[2];
    out.rows[0] = 48.0 - x[0] * x[0] - 2.0 * x[1] * x[1] - 4.0 * x[2] * x[2];
  }
  void bounds(Bounds b) const { inequalities(b); }
};

struct Hs30 : Extent<3, 1, 3> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    for (std::size_t i = 0; i < 3; ++i) out.residuals[i] = x[i];
    out.rows[0] = x[0] * x[0] + x[1] * x[1] - 1.0;
  }
  void bounds(Bounds b) const {
    inequalities(b);
    b.lower << 1.0, -10.0, -10.0;
    b.upper.setConstant(10.0);
  }
};

struct Hs35 : Extent<3, 1> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = 9.0 - 8.0 * x[0] - 6.0 * x[1] - 4.0 * x[2] + 2.0 * x[0] * x[0] + 2.0 * x[1] * x[1] + x[2] * x[2] +
               2.0 * x[0] * x[1] + 2.0 * x[0] * x[2];
    out.rows[0] = 3.0 - x[0] - x[1] - 2.0 * x[2];
  }
  void bounds(Bounds b) const {
    inequalities(b);
    b.lower.setZero();
  }
};

struct Hs36 : Extent<3, 1> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = -1.0 * x[0] * x[1] * x[2];
    out.rows[0] = 72.0 - x[0] - 2.0 * x[1] - 2.0 * x[2];
  }
  void bounds(Bounds b) const {
    inequalities(b);
    b.lower.setZero();
    b.upper << 20.0, 11.0, 42.0;
  }
};

/// The two inequalities of the collection are the two sides of one row.
struct Hs37 : Extent<3, 1> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = -1.0 * x[0] * x[1] * x[2];
    out.rows[0] = x[0] + 2.0 * x[1] + 2.0 * x[2];
  }
  void bounds(Bounds b) const {
    b.row_upper[0] = 72.0;
    b.lower.setZero();
    b.upper.setConstant(42.0);
  }
};

struct Hs38 : Extent<4, 0, 6> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.residuals[0] = 10.0 * (x[1] - x[0] * x[0]);
    out.residuals[1] = 1.0 - x[0];
    out.residuals[2] = std::sqrt(90.0) * (x[3] - x[2] * x[2]);
    out.residuals[3] = 1.0 - x[2];
    // 10.1 (a^2 + b^2) + 19.8 a b = 9.9 (a + b)^2 + 0.2 a^2 + 0.2 b^2
    const T a = x[1] - 1.0;
    const T b = x[3] - 1.0;
    out.residuals[4] = std::sqrt(9.9) * (a + b);
    out.residuals[5] = std::sqrt(0.2) * a;
    out.rest = 0.2 * b * b;
  }
  void bounds(Bounds b) const {
    b.lower.setConstant(-10.0);
    b.upper.setConstant(10.0);
  }
};

struct Hs39 : Extent<4, 2> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = -1.0 * x[0];
    out.rows[0] = x[1] - x[0] * x[0] * x[0] - x[2] * x[2];
    out.rows[1] = x[0] * x[0] - x[1] - x[3] * x[3];
  }
};

struct Hs40 : Extent<4, 3> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = -1.0 * x[0] * x[1] * x[2] * x[3];
    out.rows[0] = x[0] * x[0] * x[0] + x[1] * x[1] - 1.0;
    out.rows[1] = x[0] * x[0] * x[3] - x[2];
    out.rows[2] = x[3] * x[3] - x[1];
  }
};

struct Hs42 : Extent<4, 2, 4> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    for (std::size_t i = 0; i < 4; ++i) out.residuals[i] = x[i] - static_cast<double>(i + 1);
    out.rows[0] = x[0] - 2.0;
    out.rows[1] = x[2] * x[2] + x[3] * x[3] - 2.0;
  }
};

struct Hs43 : Extent<4, 3> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    const T a = x[0] * x[0];
    const T b = x[1] * x[1];
    const T c = x[2] * x[2];
    const T d = x[3] * x[3];
    out.rest = a + b + 2.0 * c + d - 5.0 * x[0] - 5.0 * x[1] - 21.0 * x[2] + 7.0 * x[3];
    out.rows[0] = 8.0 - a - b - c - d - x[0] + x[1] - x[2] + x[3];
    out.rows[1] = 10.0 - a - 2.0 * b - c - 2.0 * d + x[0] + x[3];
    out.rows[2] = 5.0 - 2.0 * a - b - c - 2.0 * x[0] + x[1] + x[3];
  }
  void bounds(Bounds b) const { inequalities(b); }
};

struct Hs48 : Extent<5, 2, 3> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.residuals[0] = x[0] - 1.0;
    out.residuals[1] = x[1] - x[2];
    out.residuals[2] = x[3] - x[4];
    out.rows[0] = x[0] + x[1] + x[2] + x[3] + x[4] - 5.0;
    out.rows[1] = x[2] - 2.0 * (x[3] + x[4]) + 3.0;
  }
};

struct Hs51 : Extent<5, 3, 4> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.residuals[0] = x[0] - x[1];
    out.residuals[1] = x[1] + x[2] - 2.0;
    out.residuals[2] = x[3] - 1.0;
    out.residuals[3] = x[4] - 1.0;
    out.rows[0] = x[0] + 3.0 * x[1] - 4.0;
    out.rows[1] = x[2] + x[3] - 2.0 * x[4];
    out.rows[2] = x[1] - x[4];
  }
};

struct Hs71 : Extent<4, 2> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = x[0] * x[3] * (x[0] + x[1] + x[2]) + x[2];
    out.rows[0] = x[0] * x[1] * x[2] * x[3] - 25.0;
    out.rows[1] = x[0] * x[0] + x[1] * x[1] + x[2] * x[2] + x[3] * x[3] - 40.0;
  }
  void bounds(Bounds b) const {
    b.row_upper[0] = infinity;
    b.lower.setConstant(1.0);
    b.upper.setConstant(5.0);
  }
};

struct Hs76 : Extent<4, 3> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = x[0] * x[0] + 0.5 * x[1] * x[1] + x[2] * x[2] + 0.5 * x[3] * x[3] - x[0] * x[2] + x[2] * x[3] - x[0] -
               3.0 * x[1] + x[2] - x[3];
    out.rows[0] = 5.0 - x[0] - 2.0 * x[1] - x[2] - x[3];
    out.rows[1] = 4.0 - 3.0 * x[0] - x[1] - 2.0 * x[2] + x[3];
    out.rows[2] = x[1] + 4.0 * x[2] - 1.5;
  }
  void bounds(Bounds b) const {
    inequalities(b);
    b.lower.setZero();
  }
};

struct Hs100 : Extent<7, 4> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    const auto squared = [](const T& v) { return v * v; };
    out.rest = squared(x[0] - 10.0) + 5.0 * squared(x[1] - 12.0) + squared(squared(x[2])) + 3.0 * squared(x[3] - 11.0) +
               10.0 * squared(x[4] * x[4] * x[4]) + 7.0 * squared(x[5]) + squared(squared(x[6])) - 4.0 * x[5] * x[6] -
               10.0 * x[5] - 8.0 * x[6];
    out.rows[0] = 127.0 - 2.0 * squared(x[0]) - 3.0 * squared(squared(x[1])) - x[2] - 4.0 * squared(x[3]) - 5.0 * x[4];
    out.rows[1] = 282.0 - 7.0 * x[0] - 3.0 * x[1] - 10.0 * squared(x[2]) - x[3] + x[4];
    out.rows[2] = 196.0 - 23.0 * x[0] - squared(x[1]) - 6.0 * squared(x[5]) + 8.0 * x[6];
    out.rows[3] =
        -4.0 * squared(x[0]) - squared(x[1]) + 3.0 * x[0] * x[1] - 2.0 * squared(x[2]) - 5.0 * x[5] + 11.0 * x[6];
  }
  void bounds(Bounds b) const { inequalities(b); }
};

struct Hs113 : Extent<10, 8> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    const auto squared = [](const T& v) { return v * v; };
    out.rest = squared(x[0]) + squared(x[1]) + x[0] * x[1] - 14.0 * x[0] - 16.0 * x[1] + squared(x[2] - 10.0) +
               4.0 * squared(x[3] - 5.0) + squared(x[4] - 3.0) + 2.0 * squared(x[5] - 1.0) + 5.0 * squared(x[6]) +
               7.0 * squared(x[7] - 11.0) + 2.0 * squared(x[8] - 10.0) + squared(x[9] - 7.0) + 45.0;
    out.rows[0] = 105.0 - 4.0 * x[0] - 5.0 * x[1] + 3.0 * x[6] - 9.0 * x[7];
    out.rows[1] = -10.0 * x[0] + 8.0 * x[1] + 17.0 * x[6] - 2.0 * x[7];
    out.rows[2] = 8.0 * x[0] - 2.0 * x[1] - 5.0 * x[8] + 2.0 * x[9] + 12.0;
    out.rows[3] = -3.0 * squared(x[0] - 2.0) - 4.0 * squared(x[1] - 3.0) - 2.0 * squared(x[2]) + 7.0 * x[3] + 120.0;
    out.rows[4] = -5.0 * squared(x[0]) - 8.0 * x[1] - squared(x[2] - 6.0) + 2.0 * x[3] + 40.0;
    out.rows[5] = -0.5 * squared(x[0] - 8.0) - 2.0 * squared(x[1] - 4.0) - 3.0 * squared(x[4]) + x[5] + 30.0;
    out.rows[6] = -1.0 * squared(x[0]) - 2.0 * squared(x[1] - 2.0) + 2.0 * x[0] * x[1] - 14.0 * x[4] + 6.0 * x[5];
    out.rows[7] = 3.0 * x[0] - 6.0 * x[1] - 12.0 * squared(x[8] - 8.0) + 7.0 * x[9];
  }
  void bounds(Bounds b) const { inequalities(b); }
};

template <class Formula>
KnownProblem problem(std::string name, std::string features, std::initializer_list<double> start, double optimum,
                     std::initializer_list<double> solution = {}) {
  KnownProblem p;
  p.name = std::move(name);
  p.features = std::move(features);
  p.make = [] { return std::make_unique<FormulaProgram<Formula>>(); };
  p.start = vector(start);
  p.optimum = optimum;
  p.solution = vector(solution);
  return p;
}

}  // namespace

const std::vector<KnownProblem>& hock_schittkowski() {
  static const std::vector<KnownProblem> all{
      problem<Hs1>("hs001", "curved valley, idle bound", {-2.0, 1.0}, 0.0, {1.0, 1.0}),
      problem<Hs3>("hs003", "active bound, flat along it", {10.0, 1.0}, 0.0),
      problem<Hs4>("hs004", "both bounds active", {1.125, 0.125}, 8.0 / 3.0, {1.0, 0.0}),
      problem<Hs5>("hs005", "bounds, idle at the minimum", {0.0, 0.0}, -std::sqrt(3.0) / 2.0 - M_PI / 3.0,
                   {0.5 - M_PI / 3.0, -0.5 - M_PI / 3.0}),
      problem<Hs6>("hs006", "equality, infeasible start", {-1.2, 1.0}, 0.0, {1.0, 1.0}),
      problem<Hs7>("hs007", "equality, infeasible start", {2.0, 2.0}, -std::sqrt(3.0), {0.0, std::sqrt(3.0)}),
      problem<Hs8>("hs008", "as many equations as variables, constant cost", {2.0, 1.0}, -1.0),
      problem<Hs9>("hs009", "linear equality, periodic cost", {0.0, 0.0}, -0.5),
      problem<Hs10>("hs010", "inequality, infeasible start", {-10.0, 10.0}, -1.0, {0.0, 1.0}),
      problem<Hs11>("hs011", "inequality, infeasible start", {4.9, 0.1}, -8.498464223),
      problem<Hs12>("hs012", "inequality", {0.0, 0.0}, -30.0, {2.0, 3.0}),
      problem<Hs14>("hs014", "equality and inequality, infeasible start", {2.0, 2.0}, 9.0 - 2.875 * std::sqrt(7.0),
                    {(std::sqrt(7.0) - 1.0) / 2.0, (std::sqrt(7.0) + 1.0) / 4.0}),
      problem<Hs21>("hs021", "start outside the bounds", {-1.0, -1.0}, -99.96, {2.0, 0.0}),
      problem<Hs22>("hs022", "two active inequalities", {2.0, 2.0}, 1.0, {1.0, 1.0}),
      problem<Hs24>("hs024", "inequalities and bounds", {1.0, 0.5}, -1.0, {3.0, std::sqrt(3.0)}),
      problem<Hs28>("hs028", "linear equality", {-4.0, 1.0, 1.0}, 0.0, {0.5, -0.5, 0.5}),
      problem<Hs29>("hs029", "inequality", {1.0, 1.0, 1.0}, -16.0 * std::sqrt(2.0)),
      problem<Hs30>("hs030", "dependent active row and bound", {1.0, 1.0, 1.0}, 1.0, {1.0, 0.0, 0.0}),
      problem<Hs35>("hs035", "convex quadratic", {0.5, 0.5, 0.5}, 1.0 / 9.0, {4.0 / 3.0, 7.0 / 9.0, 4.0 / 9.0}),
      problem<Hs36>("hs036", "bounds on both sides", {10.0, 10.0, 10.0}, -3300.0, {20.0, 11.0, 15.0}),
      problem<Hs37>("hs037", "row with two sides", {10.0, 10.0, 10.0}, -3456.0, {24.0, 12.0, 12.0}),
      problem<Hs38>("hs038", "four variables, curved valley", {-3.0, -1.0, -3.0, -1.0}, 0.0, {1.0, 1.0, 1.0, 1.0}),
      problem<Hs39>("hs039", "linear cost, curved equalities", {2.0, 2.0, 2.0, 2.0}, -1.0, {1.0, 1.0, 0.0, 0.0}),
      problem<Hs40>("hs040", "three equalities", {0.8, 0.8, 0.8, 0.8}, -0.25),
      problem<Hs42>("hs042", "two equalities, infeasible start", {1.0, 1.0, 1.0, 1.0}, 28.0 - 10.0 * std::sqrt(2.0),
                    {2.0, 2.0, 0.6 * std::sqrt(2.0), 0.8 * std::sqrt(2.0)}),
      problem<Hs43>("hs043", "Rosen and Suzuki", {0.0, 0.0, 0.0, 0.0}, -44.0, {0.0, 1.0, 2.0, -1.0}),
      problem<Hs48>("hs048", "linear equalities", {3.0, 5.0, -3.0, 2.0, -2.0}, 0.0, {1.0, 1.0, 1.0, 1.0, 1.0}),
      problem<Hs51>("hs051", "linear equalities", {2.5, 0.5, 2.0, -1.0, 0.5}, 0.0, {1.0, 1.0, 1.0, 1.0, 1.0}),
      problem<Hs71>("hs071", "equality, inequality, bounds", {1.0, 5.0, 5.0, 1.0}, 17.0140173,
                    {1.0, 4.7429994, 3.8211503, 1.3794082}),
      problem<Hs76>("hs076", "quadratic, degenerate bounds", {0.5, 0.5, 0.5, 0.5}, -4.681818181),
      problem<Hs100>("hs100", "seven variables", {1.0, 2.0, 0.0, 4.0, 0.0, 1.0, 1.0}, 680.6300573),
      problem<Hs113>("hs113", "ten variables, six active rows", {2.0, 3.0, 5.0, 5.0, 1.0, 2.0, 7.0, 3.0, 6.0, 10.0},
                     24.3062091),
  };
  return all;
}

namespace {

std::string shown(double value) { return tendril::shown(value, 3); }

}  // namespace

std::string KnownProblem::check(const OptimalityReport& report) const {
  std::string wrong;
  const auto expect = [&](bool holds, const std::string& what) {
    if (!holds) wrong += (wrong.empty() ? "" : "; ") + what;
  };
  expect(report.status == SolveStatus::converged,
         "ended as " + std::string(to_string(report.status)) + " (" + report.native_status + ") " + report.message +
             ", infeasibility " + shown(report.infeasibility) + ", stationarity " + shown(report.stationarity));
  // A hundred times the tolerance asked for: backends scale it by the size of rows or multipliers.
  expect(report.infeasibility <= 1e-7, "infeasibility " + shown(report.infeasibility));
  const double scale = std::max(1.0, std::abs(optimum));
  // Quadratic around the minimum, so a cost right to 1e-12 still lets the gradient be 1e-6 of its size.
  expect(report.stationarity <= 1e-5 * scale, "stationarity " + shown(report.stationarity));
  expect(std::abs(report.cost - optimum) <= cost_tolerance * scale,
         "cost " + shown(report.cost) + " instead of " + shown(optimum));
  if (solution.size() > 0) {
    const double error = (report.x - solution).lpNorm<Eigen::Infinity>();
    expect(error <= solution_tolerance * std::max(1.0, solution.lpNorm<Eigen::Infinity>()),
           "the point is " + shown(error) + " away from the known one");
  }
  return wrong;
}

}  // namespace tendril::conformance
