#include "mpcc_formula.hpp"

namespace tendril::conformance {

namespace {

struct Bard1 : Sizes<5, 1, 3> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    const T& y = x[1];
    out.rest = (x[0] - 5.0) * (x[0] - 5.0) + (2.0 * y + 1.0) * (2.0 * y + 1.0);
    out.rows[0] = 2.0 * (y - 1.0) - 1.5 * x[0] + x[2] - 0.5 * x[3] + x[4];
    out.rows[1] = 3.0 * x[0] - y - 3.0;
    out.rows[2] = x[2];
    out.rows[3] = 4.0 - x[0] + 0.5 * y;
    out.rows[4] = x[3];
    out.rows[5] = 7.0 - x[0] - y;
    out.rows[6] = x[4];
  }
  void bounds(Bounds b) const { b.lower.head(2).setZero(); }
};

struct Desilva : Sizes<6, 2, 2> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = 0.0;
    for (std::size_t i = 0; i < 2; ++i) {
      const T& y = x[2 + i];
      const T& l = x[4 + i];
      out.rest += x[i] * x[i] - 2.0 * x[i] + y * y;
      out.rows[i] = 2.0 * (y - x[i]) + 2.0 * (y - 1.0) * l;
      out.rows[2 + 2 * i] = 0.25 - (y - 1.0) * (y - 1.0);
      out.rows[3 + 2 * i] = l;
    }
  }
  void bounds(Bounds b) const {
    b.lower.head(2).setZero();
    b.upper.head(2).setConstant(2.0);
  }
};

struct Df1 : Sizes<2, 1, 1> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = (x[0] - 1.0 - x[1]) * (x[0] - 1.0 - x[1]);
    out.rows[0] = (x[0] - 1.0) * (x[0] - 1.0) + (x[1] - 1.0) * (x[1] - 1.0) - 3.0;
    out.rows[1] = x[1] - x[0] * x[0] + 1.0;
    out.rows[2] = x[1];
  }
  void bounds(Bounds b) const {
    b.row_lower[0] = -infinity;
    b.lower[0] = -1.0;
    b.upper[0] = 2.0;
  }
};

struct Gauvin : Sizes<3, 0, 2> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = x[0] * x[0] + (x[1] - 10.0) * (x[1] - 10.0);
    out.rows[0] = 4.0 * (x[0] + 2.0 * x[1] - 30.0) + x[2];
    out.rows[1] = x[1];
    out.rows[2] = 20.0 - x[0] - x[1];
    out.rows[3] = x[2];
  }
  void bounds(Bounds b) const {
    b.lower[0] = 0.0;
    b.upper[0] = 15.0;
  }
};

struct Jr1 : Sizes<2, 0, 1> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = (x[0] - 1.0) * (x[0] - 1.0) + x[1] * x[1];
    out.rows[0] = x[1];
    out.rows[1] = x[1] - x[0];
  }
};

struct Jr2 : Sizes<2, 0, 1> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = (x[1] - 1.0) * (x[1] - 1.0) + x[0] * x[0];
    out.rows[0] = x[1];
    out.rows[1] = x[1] - x[0];
  }
};

struct Kth1 : Sizes<2, 0, 1> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = x[0] + x[1];
    out.rows[0] = x[0];
    out.rows[1] = x[1];
  }
};

struct Kth2 : Sizes<2, 0, 1> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = x[0] + (1.0 - x[1]) * (1.0 - x[1]);
    out.rows[0] = x[0];
    out.rows[1] = x[1];
  }
};

struct Kth3 : Sizes<2, 0, 1> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = 0.5 * (x[0] - 1.0) * (x[0] - 1.0) + (x[1] - 1.0) * (x[1] - 1.0);
    out.rows[0] = x[0];
    out.rows[1] = x[1];
  }
};

struct Nash1 : Sizes<6, 2, 2> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    const T* y = x + 2;
    const T* l = x + 4;
    out.rest = 0.5 * ((x[0] - y[0]) * (x[0] - y[0]) + (x[1] - y[1]) * (x[1] - y[1]));
    out.rows[0] = 2.0 * y[0] + 8.0 / 3.0 * y[1] - 34.0 + l[0];
    out.rows[1] = 1.25 * y[0] + 2.0 * y[1] - 24.25 + l[1];
    out.rows[2] = 15.0 - x[1] - y[0];
    out.rows[3] = l[0];
    out.rows[4] = 15.0 - x[0] - y[1];
    out.rows[5] = l[1];
  }
  void bounds(Bounds b) const {
    b.lower.head(2).setZero();
    b.upper.head(2).setConstant(10.0);
  }
};

struct Outrata31 : Sizes<5, 2, 2> {
  template <class T>
  void operator()(const T* v, Values<T>& out) const {
    const T& x = v[0];
    const T* z = v + 1;
    out.rest = 0.5 * ((z[0] - 3.0) * (z[0] - 3.0) + (z[1] - 4.0) * (z[1] - 4.0));
    out.rows[0] = (1.0 + 0.2 * x) * z[0] - (3.0 + 1.333 * x) - 0.333 * z[2] + 2.0 * z[0] * z[3];
    out.rows[1] = (1.0 + 0.1 * x) * z[1] - x + z[2] + 2.0 * z[1] * z[3];
    out.rows[2] = 0.333 * z[0] - z[1] + 1.0 - 0.1 * x;
    out.rows[3] = z[2];
    out.rows[4] = 9.0 + 0.1 * x - z[0] * z[0] - z[1] * z[1];
    out.rows[5] = z[3];
  }
  void bounds(Bounds b) const {
    b.lower[0] = 0.0;
    b.upper[0] = 10.0;
  }
};

struct Ralph2 : Sizes<2, 0, 1> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = x[0] * x[0] + x[1] * x[1] - 4.0 * x[0] * x[1];
    out.rows[0] = x[0];
    out.rows[1] = x[1];
  }
};

struct Scholtes3 : Sizes<2, 0, 1> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = 0.5 * ((x[0] - 1.0) * (x[0] - 1.0) + (x[1] - 1.0) * (x[1] - 1.0));
    out.rows[0] = x[0];
    out.rows[1] = x[1];
  }
};

struct Stackelberg1 : Sizes<2, 0, 1> {
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = 0.5 * x[0] * x[0] + 0.5 * x[0] * x[1] - 95.0 * x[0];
    out.rows[0] = 2.0 * x[1] + 0.5 * x[0] - 100.0;
    out.rows[1] = x[1];
  }
  void bounds(Bounds b) const {
    b.lower[0] = 0.0;
    b.upper[0] = 200.0;
  }
};

}  // namespace

const std::vector<KnownMpcc>& macmpec() {
  static const std::vector<KnownMpcc> all{
      mpcc<Bard1>("bard1", "bilevel program, three pairs", {0.0, 0.0, 0.0, 0.0, 0.0}, 17.0),
      mpcc<Desilva>("desilva", "bilevel program, two pairs", {0.0, 0.0, 0.0, 0.0, 0.0, 0.0}, -1.0),
      mpcc<Df1>("df1", "biactive solution", {0.0, 0.0}, 0.0),
      mpcc<Gauvin>("gauvin", "two pairs", {7.0, 10.0, 5.0}, 20.0),
      mpcc<Jr1>("jr1", "one pair", {0.0, 0.0}, 0.5),
      mpcc<Jr2>("jr2", "one pair", {0.0, 0.0}, 0.5),
      mpcc<Kth1>("kth1", "biactive solution", {1.0, 1.0}, 0.0),
      mpcc<Kth2>("kth2", "one pair", {1.0, 1.0}, 0.0),
      mpcc<Kth3>("kth3", "two local minima", {1.0, 0.5}, 0.5),
      mpcc<Nash1>("nash1", "family of solutions", {5.0, 5.0, 5.0, 5.0, 0.0, 0.0}, 0.0),
      mpcc<Outrata31>("outrata31", "nonlinear equations, two pairs", {0.0, 0.0, 0.0, 0.0, 0.0}, 3.2077),
      mpcc<Ralph2>("ralph2", "biactive solution, indefinite cost", {1.0, 1.0}, 0.0),
      mpcc<Scholtes3>("scholtes3", "two equal minima", {0.5, 0.4}, 0.5),
      mpcc<Stackelberg1>("stackelberg1", "one pair, large numbers", {0.0, 50.0}, -3266.6667),
  };
  return all;
}

}  // namespace tendril::conformance
