#pragma once

#include <string_view>

#include "tendril/export.hpp"

namespace tendril {

/// Physical dimension of a number: powers of length and force (a moment is length * force, a curvature 1/length).
/// `unit` is the SI unit that a plain number is taken to be in; empty: a pure number.
struct Dimension {
  int length = 0;              ///< power of length
  int force = 0;               ///< power of force
  std::string_view unit = "";  ///< of a plain number
};

/// Those that options and scenes use.
namespace dimension {
inline constexpr Dimension none{0, 0, ""};            ///< a pure number
inline constexpr Dimension angle{0, 0, "rad"};        ///< rad
inline constexpr Dimension length{1, 0, "m"};         ///< m
inline constexpr Dimension curvature{-1, 0, "1/m"};   ///< 1/m
inline constexpr Dimension force{0, 1, "N"};          ///< N
inline constexpr Dimension moment{1, 1, "N m"};       ///< N m
inline constexpr Dimension stiffness{2, 1, "N m^2"};  ///< N m^2
inline constexpr Dimension pressure{-2, 1, "Pa"};     ///< Pa
}  // namespace dimension

/// The units of a dimensionless program: lengths in L, forces in EI0/L^2 (docs/model.md section 1).
struct TENDRIL_API Scale {
  double length = 1.0;     ///< L, m
  double stiffness = 1.0;  ///< EI0, bending stiffness of the first segment, N m^2

  /// Unit of forces, EI0/L^2, N.
  double force() const { return stiffness / (length * length); }
  /// Unit of moments, EI0/L, N m.
  double moment() const { return stiffness / length; }
  /// Size of the unit of `d` in SI.
  double unit(const Dimension& d) const;
  /// SI -> dimensionless, rounded to 12 significant digits so that equal scenes in other units give equal programs.
  double to_dimensionless(double si, const Dimension& d) const;
  /// Dimensionless -> SI, not rounded.
  double to_si(double value, const Dimension& d) const { return value * unit(d); }
};

/// `value` rounded to 12 significant decimal digits. Infinities and zero pass.
TENDRIL_API double round_to_12_digits(double value);

}  // namespace tendril
