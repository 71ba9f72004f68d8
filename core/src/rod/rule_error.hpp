#pragma once

#include <array>
#include <vector>

#include "rod/backbone.hpp"

namespace tendril {

/// How far the rule of a chain can be off, proven without a second rule. Over a piece the tangent is the exponential of
/// i times the angle, a polynomial: it is analytic, and its size in an ellipse about the piece follows from the
/// coordinates. What Gauss's rule leaves of its integrals and what interpolation at the nodes leaves of itself fall
/// with the size of the ellipse (Trefethen, Approximation Theory and Approximation Practice, theorems 8.2 and 19.3).
class TENDRIL_API RuleError {
 public:
  /// For backbones of this chain.
  explicit RuleError(const Chain& chain);
  /// Whether bounds are known at all: a smooth polynomial basis, and sections that are the same all along a piece.
  bool known() const { return known_; }
  /// Bounds over all pieces of a moved backbone.
  struct Bound {
    double integral = 0.0;  ///< of the tangent, by dsigma, also times the weight beyond and two functions of the basis
    double tangent = 0.0;   ///< of the tangent that is interpolated at the nodes
  };
  Bound of(const Backbone& backbone) const;

 private:
  /// An ellipse with the ends of a piece as foci.
  struct Ellipse {
    std::vector<double> bend;  ///< bound of each function's imaginary part there
    double integral = 0.0;     ///< of Bound, where the tangent's size in the ellipse is 1
    double tangent = 0.0;      ///< likewise
  };
  static constexpr std::array<double, 8> sizes{1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0};  ///< sum of the half axes

  bool known_ = false;
  int functions_ = 0;
  std::vector<Ellipse> ellipses_;
};

}  // namespace tendril
