#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tendril/numbers.hpp"

namespace tendril {

/// Quality of a plan, judged without asking the solver (docs/model.md section 7). Everything dimensionless; each number
/// is the size of a defect except stability (a margin) and d_ss.
struct Certificate {
  double equilibrium = infinity;      ///< largest residual of the equilibrium rows
  double bounds = infinity;           ///< largest excess over a limit of a variable
  double penetration = infinity;      ///< certified depth: the true one is not larger
  double complementarity = infinity;  ///< largest min(g, f)
  double closest_point = infinity;    ///< largest tangent . normal at a contact
  double balance = infinity;          ///< force along a grasp's axis that one finger leaves; 0 where none is asked for
  double stationarity = infinity;     ///< gradient of the Lagrangian of the tightened program
  std::string stationarity_kind = "none";  ///< "S", "M", "C" or "none"
  double moment_balance = infinity;        ///< strong form: a direct measure of model error
  double stability = -infinity;            ///< margin mu
  /// Taut tendons that are held by their length, which no disturbance of that margin changes; 0: all tensions are held.
  int held_lengths = 0;
  /// Margin of a rod that may leave its plane (model.md section 12); none: its torsion is not known.
  std::optional<double> out_of_plane{};
  bool guided_in_plane = false;         ///< it may not leave it, whatever that margin
  double contact_convexity = infinity;  ///< smallest d_ss of interior contacts with force; infinity: none
  double least_stretch = 1.0;           ///< 1 + eps where a rod that stretches is shortest; 1 where it is nowhere
  double quadrature = infinity;         ///< error of the rule in any row: a bound, or the change if doubled
  /// Where contacts can rub: the largest tangential force beyond its cone, or off the cone's edge where the contact
  /// slips, per 1 + normal force (EI/L^2); none: nothing rubs.
  std::optional<double> friction{};
  /// One line for each requirement that is not met; empty: certified.
  std::vector<std::string> failures{"no point was judged"};
  /// Every requirement is met.
  bool valid() const { return failures.empty(); }
};

}  // namespace tendril
