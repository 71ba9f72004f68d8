#pragma once

#include <functional>
#include <vector>

#include "rod/profile.hpp"
#include "tendril/export.hpp"
#include "tendril/geometry.hpp"
#include "tendril/numbers.hpp"

namespace tendril {

/// The rod of a scene, dimensionless (model.md section 1): length 1, EI at the base 1.
struct TENDRIL_API Rod {
  /// A property at a place, and its derivatives by the arc length.
  struct Jet {
    double value = 0.0, slope = 0.0, bend = 0.0, jerk = 0.0;
  };
  /// A stretch whose properties are polynomials of the arc length, most often constants.
  struct TENDRIL_API Segment {
    double from = 0.0;            ///< arc length, units of L
    double to = 1.0;              ///< arc length, units of L
    double stiffness = 1.0;       ///< EI / EI0 where it begins
    double weight = 0.0;          ///< rho |g| L^3 / EI0 there
    double rest_curvature = 0.0;  ///< kappa0 L there
    double radius = 0.0;          ///< of the body there, units of L
    double torsion = 0.0;         ///< GJ / EI all along it; 0: not known
    double across = 1.0;          ///< stiffness out of the plane / EI all along it
    double axial = 0.0;           ///< EA L^2 / EI0 there; only asked for where the rod stretches
    /// How they change from there on: coefficients of x, x^2, ..., x the share of the segment's length. Empty: not.
    std::vector<double> more_stiffness{}, more_weight{}, more_rest_curvature{}, more_radius{}, more_axial{};

    bool bends_evenly() const { return more_stiffness.empty() && more_rest_curvature.empty(); }
    bool weighs_evenly() const { return more_weight.empty(); }
    Jet stiffness_at(double s) const { return at(s, stiffness, more_stiffness); }
    Jet weight_at(double s) const { return at(s, weight, more_weight); }
    Jet rest_curvature_at(double s) const { return at(s, rest_curvature, more_rest_curvature); }
    Jet axial_at(double s) const { return at(s, axial, more_axial); }
    /// It is nowhere thicker than that.
    double most_radius() const;
    Jet radius_at(double s) const { return at(s, radius, more_radius); }
    double weight_up_to(double s) const { return up_to(s, weight, more_weight); }  ///< from where it begins
    double whole_weight() const { return weight_up_to(to); }
    /// Bounds of the radius and of the size of its derivatives; exact where it is linear.
    Jet radius_bounds() const;
    /// int kappa0 ds: by how much the unloaded segment turns.
    double rest_turn() const { return up_to(to, rest_curvature, more_rest_curvature); }
    /// int p ds / EI over what it has in common with [low, high]: the turn by a unit of moment there. `profile`: p,
    /// without it 1.
    double compliance(double low, double high, const ProfilePart* profile = nullptr) const;
    /// The moment that turns it as a constant curvature would, without other loads.
    double holding_moment(double low, double high, double curvature) const;

   private:
    Jet at(double s, double start, const std::vector<double>& more) const;
    double up_to(double s, double start, const std::vector<double>& more) const;
  };
  /// A moment between two arc lengths, with its limits: u p(s).
  struct TENDRIL_API Actuator {
    double from = 0.0;           ///< arc length, units of L
    double to = 1.0;             ///< arc length, units of L
    double minimum = -infinity;  ///< of u, units of EI0/L
    double maximum = infinity;   ///< of u, units of EI0/L
    double thrust = 0.0;         ///< axial force along its span by a unit of u, times L; positive: it stretches
    /// Instead of thrust times u, units of EI0/L^2, and its derivatives by u; empty: it is that.
    std::function<Jet(double)> pull{};
    std::vector<ProfilePart> profile{};  ///< p from `from` to `to`, in order, without gaps; empty: 1
    /// Of a tendon: its largest one, units of L. Its tension is u over it, and it is shorter by it times the work of a
    /// unit of u. 0: this is none.
    double offset = 0.0;
    bool by_length = false;  ///< a tendon that is told its length, not its tension
    /// Limits of what it then is shorter by, over the size of its offset.
    double least_shortening = -infinity, most_shortening = infinity;
    /// Sign of u under tension.
    double side() const { return offset < 0.0 ? -1.0 : 1.0; }
    /// Whether limits of the shortening are rows of a program.
    bool limits_length() const {
      return by_length && !fixed_at_zero() && (least_shortening > -infinity || most_shortening < infinity);
    }
    /// The part of the profile that holds arc length s between `from` and `to`; null: there is none, p is 1.
    const ProfilePart* part_at(double s) const;
    /// p(s); 0 outside.
    double at(double s) const;
    /// The turn of a segment by a unit of u.
    double compliance(const Segment& segment) const;
    /// Whether p is not the same all over one of its parts.
    bool varies() const;
    /// Whether it can do nothing.
    bool fixed_at_zero() const { return minimum == 0.0 && maximum == 0.0; }
  };
  /// A dead load between two arc lengths, or at one of them where these are equal.
  struct Load {
    double from = 0.0;    ///< arc length, units of L
    double to = 0.0;      ///< arc length, units of L
    Vec2 force{};         ///< times L^2 / EI0; between two arc lengths per length, times L^3 / EI0
    double weight = 0.0;  ///< at one arc length: mass |g| L^2 / EI0
    bool at_point() const { return from == to; }
  };
  /// How the rod may be moved as a whole, by one number between limits.
  struct Move {
    enum class Kind {
      shift,  ///< of the base along `along`, units of L
      turn,   ///< the base's angle, rad
      draw    ///< arc length at the port: the rod before it is drawn in, straight and without effect
    };
    Kind kind = Kind::shift;
    Vec2 along{};
    double minimum = 0.0, maximum = 0.0;
    double start = 0.0;  ///< where searches begin; of a base that is shifted 0, of one that turns `base_angle`
  };
  std::vector<Segment> segments{Segment{}};  ///< in order from the base on, without gaps
  std::vector<Actuator> actuators{};         ///< as in the scene
  Vec2 base{};                               ///< where it is clamped, units of L; shifts count from here
  double base_angle = 0.0;                   ///< against the x axis, rad
  std::vector<Move> moves{};                 ///< at most one turn, and last at most one draw
  Vec2 gravity{};                            ///< unit vector, or zero: no gravity
  double payload = 0.0;                      ///< mass |g| L^2 / EI0
  Vec2 tip_force{};                          ///< dead force, times L^2 / EI0
  std::vector<Load> loads{};                 ///< along the rod
  bool guided = false;                       ///< it cannot leave its plane
  int hidden = 0;                            ///< stretches between fixed knots, the first ones, that are in its port
  int stretch_order = 0;                     ///< Legendre coefficients of the stretch per piece; 0: it does not stretch
  /// As many of them as there are functions of the angle.
  static constexpr int stretch_as_fine = -1;

  bool stretches() const { return stretch_order != 0; }
  /// Whether gravity does anything: it has a direction, and the rod or the tip has mass.
  bool has_gravity() const;
  /// Whether a dead force acts on the tip.
  bool has_tip_force() const { return tip_force.x != 0.0 || tip_force.y != 0.0; }
  /// Whether dead forces act along it.
  bool has_dead_loads() const;
  /// All that pulls at it: its weight, what hangs on it, and dead forces.
  Vec2 whole_load() const;
  /// Whether its torsion is known all along.
  bool has_torsion() const;
  /// Whether it has a body around its backbone.
  bool is_thick() const;
  /// It is nowhere thicker than that.
  double most_radius() const;
  Jet radius_at(double s) const { return segment_at(s).radius_at(s); }
  /// It can be drawn into its port: its first knot moves.
  bool draws() const { return !moves.empty() && moves.back().kind == Move::Kind::draw; }
  /// Its base can be moved.
  bool base_moves() const { return moves.size() > (draws() ? 1U : 0U); }
  /// Where searches begin with what it is moved by.
  std::vector<double> starts() const;
  /// Where they have the port.
  double port() const { return draws() ? moves.back().start : 0.0; }
  /// Ends of segments, actuators, parts of their profiles and loads, ascending, 0 and 1 included: the knots that do not
  /// move. Of one that is drawn in behind some of them those from the last of these on.
  std::vector<double> fixed_knots() const;
  /// The segment that holds arc length s: the later one at a joint, the last one beyond the end.
  const Segment& segment_at(double s) const;
};

/// Two fixed knots closer than this are one (units of L): below it pieces would be all rounding.
inline constexpr double knot_merge_distance = 1e-9;

}  // namespace tendril
