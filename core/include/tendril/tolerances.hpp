#pragma once

/// Every number that a verdict stands on (docs/model.md section 7). Dimensionless: lengths in L, forces in EI/L^2,
/// moments in EI/L.
namespace tendril::tolerance {

inline constexpr double equilibrium = 1e-9;  ///< residual of the equilibrium rows
inline constexpr double balance = 1e-9;  ///< net force on the object of a grasp (of mirrored fingers: of one of them)
inline constexpr double bounds = 1e-9;   ///< moments, forces, arc lengths beyond their limits
inline constexpr double penetration = 1e-9;      ///< certified depth
inline constexpr double complementarity = 1e-9;  ///< min(gap, force)
inline constexpr double closest_point = 1e-8;    ///< tangent . normal
inline constexpr double friction = 1e-9;      ///< tangential contact force off its cone, or off the edge where it slips
inline constexpr double stationarity = 1e-6;  ///< gradient of the Lagrangian of the tightened program
inline constexpr double stability = 1e-6;     ///< least margin
/// A rod whose margin out of its plane is below minus this buckles out of it. A rod that buckled under thrust alone may
/// turn about its axis: 0 but for rounding.
inline constexpr double out_of_plane = 1e-6;
/// Least d_ss of a contact with force (docs/model.md section 7). A rod that lies straight along a flat side has 0 and
/// some 1e-14 of rounding, which is no point contact either.
inline constexpr double convexity = 1e-9;
/// The margin that a plan keeps where its objective falls up to the limit of stability. It falls as the root of the
/// distance of a load to that limit: with 1e-3 a load may still grow by some 1e-6 of EI/L, and what the equilibrium
/// leaves (1e-9) moves the shape by 1e-6 L.
inline constexpr double held_margin = 1e-3;
/// The d_ss that a contact keeps where its plan would lie along the obstacle: far enough from tolerance::convexity to
/// be told from rounding, and near enough to lying that it costs a millionth of the curvature.
inline constexpr double held_convexity = 1e-6;
inline constexpr double quadrature = 1e-10;  ///< change of a row when the rule is doubled; more means more nodes
inline constexpr double force = 1e-9;        ///< a contact with less force does not hold the rod
/// Tip of a plan against tip of its execution. What a coarse basis leaves out stays below it (three arcs per rod: up to
/// 3e-2 on the braced arm); another equilibrium branch lies beyond it. A plan that loses or gains a contact is refused
/// whatever the distance.
inline constexpr double model_error = 5e-2;
/// Local moment balance of an execution: its fine basis has to resolve the rod.
inline constexpr double moment_balance = 1e-9;

/// The clearance bound is bisected until it is this sharp: a tenth of what is asked for.
inline constexpr double clearance_sharpness = 1e-10;
/// A contact's complementarity counts as decided below this (docs/model.md section 4).
inline constexpr double branch_decided = 1e-6;

}  // namespace tendril::tolerance
