// Programs in which something sticks or slips by Coulomb's law. The force along a surface has a part in either
// direction; with l, what a contact slips at, and v, the velocity, or the displacement from rest:
//     0 <= f1 _|_ l + v >= 0,   0 <= f2 _|_ l - v >= 0,   0 <= l _|_ mu N - f1 - f2 >= 0
// (D. Stewart, J. Trinkle, An implicit time-stepping scheme for rigid body dynamics with inelastic collisions and
// Coulomb friction, Int. J. Numer. Meth. Eng. 39, 1996). All answers are closed forms.
#include <array>
#include <cmath>

#include "mpcc_formula.hpp"

namespace tendril::conformance {

namespace {

/// The three pairs of a contact, G and H in turn, from row `first` on.
template <class T>
void slide(Values<T>& out, std::size_t first, const T* f1_f2_l, const T& velocity, const T& most) {
  const T& f1 = f1_f2_l[0];
  const T& f2 = f1_f2_l[1];
  const T& l = f1_f2_l[2];
  const std::array<T, 6> rows{f1, l + velocity, f2, l - velocity, l, most - f1 - f2};
  std::copy(rows.begin(), rows.end(), out.rows.begin() + static_cast<std::ptrdiff_t>(first));
}

/// The steepest slope on which a block stays: angle, velocity after a step from rest, contact.
struct Slope : Sizes<5, 2, 3> {
  static constexpr double mu = 0.3;
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    using std::cos;
    using std::sin;
    out.rest = -x[0];
    out.rows[0] = sin(x[0]) + x[2] - x[3] - x[1];
    out.rows[1] = x[1];
    slide<T>(out, 2, x + 2, x[1], mu * cos(x[0]));
  }
  void bounds(Bounds b) const {
    b.lower[0] = 0.0;
    b.upper[0] = 1.5;
  }
};

/// The least force that drags a block at unit velocity, and its direction: force, angle, contact. The direction is the
/// angle of friction (C. Coulomb, Theorie des machines simples, 1785).
struct Drag : Sizes<5, 1, 3> {
  static constexpr double mu = 0.5;
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    using std::cos;
    using std::sin;
    out.rest = x[0];
    out.rows[0] = x[0] * cos(x[1]) + x[2] - x[3];
    slide<T>(out, 1, x + 2, T(1.0), mu * (1.0 - x[0] * sin(x[1])));
  }
  void bounds(Bounds b) const {
    b.lower[0] = 0.0;
    b.upper[0] = 1.0;
    b.lower[1] = 0.0;
    b.upper[1] = 1.5;
  }
};

/// A disc is thrown without spin: the shortest time after which it rolls: time, velocity, that of its rim, contact.
struct Disc : Sizes<6, 3, 3> {
  static constexpr double mu = 0.2;
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    const T force = x[3] - x[4];
    out.rest = x[0];
    out.rows[0] = 1.0 + x[0] * force - x[1];
    out.rows[1] = -2.0 * x[0] * force - x[2];
    out.rows[2] = x[1] - x[2];
    slide<T>(out, 3, x + 3, x[1] - x[2], T(mu));
  }
  void bounds(Bounds b) const {
    b.lower[0] = 0.0;
    b.upper[0] = 10.0;
  }
};

/// The end of a rod slides on a floor and is pressed on it the more, the more friction there is (P. Painleve 1895;
/// P. Loetstedt, Coulomb friction in two-dimensional rigid body systems, ZAMM 61, 1981): the least friction at which it
/// is pressed with four times its weight: coefficient, force.
struct PainleveRod : Sizes<2, 0, 1> {
  static constexpr double angle = 1.0471975511965976;  // 60 deg
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = x[0];
    out.rows[0] = x[1];
    out.rows[1] = (1.0 + 3.0 * std::cos(angle) * (std::cos(angle) - x[0] * std::sin(angle))) * x[1] - 1.0;
  }
  void bounds(Bounds b) const {
    b.lower << 0.0, 4.0;
    b.upper << 1.3, 100.0;
  }
};

/// Two springs that are coupled hold a point against a surface (A. Klarbring, Examples of non-uniqueness and
/// non-existence of solutions to quasistatic contact problems with friction, Ing. Archiv 60, 1990): the least force
/// along it that moves the point by 0.1: force, displacement along and into the surface, contact, normal force.
struct Springs : Sizes<7, 2, 4> {
  static constexpr double mu = 0.3;
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = x[0];
    out.rows[0] = 2.0 * x[1] + x[2] - x[0] - x[3] + x[4];
    out.rows[1] = x[1] + 2.0 * x[2] - 1.0 + x[6];
    slide<T>(out, 2, x + 3, x[1], mu * x[6]);
    out.rows[8] = x[6];
    out.rows[9] = -x[2];
  }
  void bounds(Bounds b) const { b.lower[1] = 0.1; }
};

/// Two fingers hold a weight between them (A. Al-Fahed, G. Stavroulakis, P. Panagiotopoulos, Hard and soft fingered
/// robot grippers, ZAMM 71, 1991): how hard they have to press at least: force, velocity after a step, both contacts.
struct Gripper : Sizes<8, 2, 6> {
  static constexpr double mu = 0.4;
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = x[0];
    out.rows[0] = x[2] - x[3] + x[5] - x[6] - 1.0 - x[1];
    out.rows[1] = x[1];
    slide<T>(out, 2, x + 2, x[1], mu * x[0]);
    slide<T>(out, 8, x + 5, x[1], mu * x[0]);
  }
  void bounds(Bounds b) const { b.lower[0] = 0.0; }
};

/// A rope over three pegs, each of which turns it by 0.6 rad: what a unit of tension holds at most (L. Euler, Remarques
/// sur l'effet du frottement dans l'equilibre, 1762): tensions behind each peg, contacts.
struct Rope : Sizes<12, 3, 9> {
  static constexpr double mu = 0.3;
  static constexpr double half = 0.3;
  template <class T>
  void operator()(const T* x, Values<T>& out) const {
    out.rest = -x[2];
    T before = T(1.0);
    for (std::size_t k = 0; k < 3; ++k) {
      const T* contact = x + 3 + 3 * k;
      out.rows[k] = (x[k] - before) * std::cos(half) + contact[0] - contact[1];
      slide<T>(out, 3 + 6 * k, contact, T(0.0), mu * std::sin(half) * (x[k] + before));
      before = x[k];
    }
  }
  void bounds(Bounds b) const { b.lower.head(3).setZero(); }
  /// By how much one peg raises the tension.
  static double ratio() {
    const double across = mu * std::sin(half);
    return (std::cos(half) + across) / (std::cos(half) - across);
  }
};

}  // namespace

const std::vector<KnownMpcc>& friction() {
  static const std::vector<KnownMpcc> all{
      mpcc<Slope>("slope", "sticks at the edge of its cone", {0.1, 0.0, 0.0, 0.1, 0.0}, -std::atan(Slope::mu)),
      mpcc<Drag>("drag", "slips", {0.5, 0.2, 0.0, 0.4, 1.0}, std::sin(std::atan(Drag::mu))),
      mpcc<Disc>("disc", "stops slipping", {1.0, 0.8, 0.4, 0.0, 0.2, 0.4}, 1.0 / (3.0 * Disc::mu)),
      mpcc<PainleveRod>("painleve rod", "matrix that friction makes indefinite", {0.5, 5.0}, 2.0 / std::sqrt(3.0)),
      mpcc<Springs>("springs", "contact and friction together", {0.5, 0.1, 0.0, 0.0, 0.3, 0.1, 0.9}, 0.47),
      mpcc<Gripper>("gripper", "family of solutions", {2.0, 0.0, 0.5, 0.0, 0.0, 0.5, 0.0, 0.0},
                    1.0 / (2.0 * Gripper::mu)),
      mpcc<Rope>("rope", "nine pairs", {1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0},
                 -std::pow(Rope::ratio(), 3)),
  };
  return all;
}

}  // namespace tendril::conformance
