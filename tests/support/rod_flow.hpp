#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <complex>

#include "support/rod_bvp.hpp"

/// The strong form of the rod's equilibrium as an initial-value problem.
namespace tendril::support {

using Complex = std::complex<double>;

/// Order of the state.
enum Component : Eigen::Index { kAngle, kX, kY, kMoment, kForceX, kForceY, kStates };

template <class T>
using State = std::array<T, kStates>;

/// What the vector field depends on besides the state.
template <class T>
struct Field {
  double stiffness;
  T free_curvature;
  Point weight;
};

/// The change of the state along the rod.
template <class T>
State<T> rate(const Field<T>& f, const State<T>& z) {
  using std::cos;
  using std::sin;
  const T c = cos(z[kAngle]);
  const T s = sin(z[kAngle]);
  return {f.free_curvature + z[kMoment] / f.stiffness,
          c,
          s,
          s * z[kForceX] - c * z[kForceY],
          T(-f.weight.x),
          T(-f.weight.y)};
}

/// The state after `length`: Taylor series of fixed order, in as many steps as the decay of the series allows. T:
/// double or Complex.
template <class T>
State<T> flow(const Field<T>& f, State<T> z, double length);

}  // namespace tendril::support
