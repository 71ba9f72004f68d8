#pragma once

#include <array>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

/// The elastica as a boundary-value problem: an exact second method to judge the library by. It integrates the strong
/// form of the equilibrium equations with Taylor series and closes it by multiple shooting, so it shares neither code,
/// nor discretization, nor the energy form with the library. Any consistent units; EI = L = 1 is meant as the usual
/// scale.
namespace tendril::support {

struct Point {
  double x = 0.0;
  double y = 0.0;
};

/// A stretch of the rod with constant properties.
struct RodSection {
  double length = 1.0;
  double stiffness = 1.0;
  double density = 0.0;  ///< mass per length
  double rest_curvature = 0.0;
};

/// An actuator's moment acts over the arc lengths [from, to].
struct MomentSpan {
  double from = 0.0;
  double to = 1.0;
};

struct RodBvp {
  std::vector<RodSection> sections{RodSection{}};
  std::vector<MomentSpan> actuators{MomentSpan{}};
  Point gravity{};       ///< force per mass
  Point tip_force{};     ///< dead
  double payload = 0.0;  ///< mass at the tip
  Point base{};
  double base_angle = 0.0;
  double length() const;
};

/// Frictionless contact with a circle, or with a straight wall through `center` if `wall_normal` (a unit vector) is not
/// zero. Inside the rod the tangent is perpendicular to the normal; at the tip the force follows the obstacle's normal.
struct BvpContact {
  Point center{};
  double radius = 0.0;
  bool at_tip = false;
  Point wall_normal{};
};

/// Where Newton starts. Arc lengths and forces: one per contact, near the solution; each arc length in the stretch
/// between section and actuator ends where the solution has it (a tip contact's is ignored).
struct BvpGuess {
  double curvature = 0.0;               ///< of a circular arc, used if `angle` is empty
  std::function<double(double)> angle;  ///< absolute backbone angle at an arc length
  std::vector<double> arc_lengths;
  std::vector<double> forces;
};

struct BvpOptions {
  int intervals = 16;        ///< shooting intervals per rod length, at least
  double tolerance = 1e-11;  ///< largest scaled Newton step accepted; one more step follows
  int max_iterations = 80;
};

/// The rod at one arc length. `moment` and `force` are those of everything beyond it, without the actuators.
struct BvpState {
  double x = 0.0;
  double y = 0.0;
  double angle = 0.0;
  double curvature = 0.0;
  double moment = 0.0;
  Point force{};
};

/// A solution, with a dense output.
struct BvpSolution {
  double tip_x = 0.0;
  double tip_y = 0.0;
  double tip_angle = 0.0;
  std::vector<double> arc_lengths;  ///< per contact
  std::vector<double> forces;  ///< per contact, along the outward normal; negative if the contact would have to pull
  std::vector<double> moments;
  double moment_rate = 0.0;  ///< d moment / d tip angle of the free actuator; solve_tip_angle only
  int iterations = 0;

  /// `s` in [0, L]. At a kink of the curvature the value beyond it is given.
  BvpState at(double s) const;
  /// This solution as the start of another one.
  BvpGuess guess() const;

  /// One shooting interval: begin and length in arc length, section properties, state at its begin.
  struct Interval {
    double begin = 0.0;
    double length = 0.0;
    double stiffness = 1.0;
    double free_curvature = 0.0;  ///< curvature without the moment of what lies beyond
    Point weight{};               ///< per length
    std::array<double, 6> state{};
  };
  std::vector<Interval> intervals;
};

/// Newton did not converge, or the question makes no sense.
class BvpError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The equilibrium at given moments (one per actuator) with the given contacts closed. Relative accuracy about 1e-13.
BvpSolution solve(const RodBvp& rod, const std::vector<double>& moments, const std::vector<BvpContact>& contacts = {},
                  const BvpGuess& guess = {}, const BvpOptions& options = {});

/// The equilibrium with a given tip angle; the moment of actuator `free_actuator` is unknown (its entry in `moments` is
/// the guess). `moment_rate` is 0 at a fold of the moment and at buckling, so both can be found as roots.
BvpSolution solve_tip_angle(const RodBvp& rod, const std::vector<double>& moments, std::size_t free_actuator,
                            double tip_angle, const std::vector<BvpContact>& contacts = {}, const BvpGuess& guess = {},
                            const BvpOptions& options = {});

/// `solve` at `last` reached in steps from `first`, where the guess must suffice: for forces that are far from the
/// guess. A step that fails is halved; throws when steps get shorter than 1e-4 of the way.
BvpSolution follow(const RodBvp& rod, const std::vector<double>& first, const std::vector<double>& last,
                   const std::vector<BvpContact>& contacts = {}, const BvpGuess& guess = {},
                   const BvpOptions& options = {});

}  // namespace tendril::support
