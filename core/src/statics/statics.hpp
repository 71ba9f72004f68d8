#pragma once

#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "certificate/certifier.hpp"
#include "program/equations.hpp"
#include "statics/load_path.hpp"
#include "statics/state.hpp"
#include "tendril/coordinate_model.hpp"

namespace tendril {

/// Equilibrium with a given set of closed contacts and taut tendons along a load path: a square system F(y, load) = 0
/// over y = (coordinates, arc lengths, forces, moments of taut tendons, tangential forces of contacts that stick), with
/// exact derivatives. A point is z = (y, load). What holds the rod from one side are its `holds`: the contacts, and
/// behind them the taut tendons.
class TENDRIL_API Statics {
 public:
  /// `contacts` in any order; they are sorted along the rod.
  Statics(const LoadPath& path, std::shared_ptr<const LegendreBasis> basis, std::vector<PointContact> contacts,
          int nodes, const std::vector<TautTendon>& tendons = {});

  int size() const { return equations_.size(); }  ///< of y
  int coordinates() const { return program_.layout().coordinates; }
  int contact_count() const { return program_.layout().forces; }
  const ContactSetup& contact(int k) const { return program_.spec().contacts[static_cast<std::size_t>(k)]; }
  int arc_length_index(int k) const { return contact(k).at_tip ? -1 : coordinates() + k; }
  int force_index(int k) const { return coordinates() + program_.layout().arc_lengths + k; }  ///< of a hold
  /// The tangential force of contact k, along the obstacle's turned normal; -1 where it does not stick.
  int shear_index(int k) const { return shear_indices_[static_cast<std::size_t>(k)]; }
  int hold_count() const { return contact_count() + static_cast<int>(taut_.size()); }
  /// With what a hold presses, or pulls: below 0 it would do the other.
  double hold_force(const Eigen::VectorXd& z, int k) const;
  /// How far a tendon that is held by its length is from being taut, over the size of its largest offset; infinity for
  /// one that is taut here.
  double slack(const Eigen::VectorXd& z, int actuator);
  /// The taut tendons, of one that is taut itself those before it, hold that of an actuator, too: nothing that they
  /// leave free changes its length.
  bool lengths_hold(const Eigen::VectorXd& z, int actuator);

  /// The point of a state, whose contacts are those of this system in any order, and whose tendons are its own.
  Eigen::VectorXd point(const State& state);
  State state(const Eigen::VectorXd& z);
  /// Of z or of a direction there.
  Curvature curvature(const Eigen::VectorXd& z, const Eigen::VectorXd& direction);

  struct NewtonResult {
    bool converged = false;
    int leaning = -1;     ///< contact whose arc length wants to leave its stretch, or -1
    bool upward = false;  ///< towards the tip
    double residual = infinity;
  };
  /// Newton's method on F(z) = 0 and row . z = value, from z.
  NewtonResult solve(Eigen::VectorXd& z, const Eigen::VectorXd& row, double value, double clearance = 1e-6);
  /// The same at fixed load.
  NewtonResult solve_at_load(Eigen::VectorXd& z, double load, double clearance = 1e-6);

  /// Unit tangent of the solution curve in the metric below, with a growing load. Not finite at a singular point.
  Eigen::VectorXd tangent(const Eigen::VectorXd& z);
  /// Metric row: bending energy of the coordinates, and the load. `metric(a) . b`.
  Eigen::VectorXd metric(const Eigen::VectorXd& z, const Eigen::VectorXd& a);
  double length(const Eigen::VectorXd& z, const Eigen::VectorXd& a);  ///< in it

  /// From a point near a fold to the fold itself: F = 0 and a singular dF/dy. False if there is none near.
  bool solve_fold(Eigen::VectorXd& z, Eigen::VectorXd& null_vector);
  /// The direction in which dF/dy is nearest to singular, last entry (the load) 0.
  Eigen::VectorXd weakest_direction(const Eigen::VectorXd& z);

  double margin(const Eigen::VectorXd& z);
  double moment_balance(const Eigen::VectorXd& z);
  double convexity(const Eigen::VectorXd& z, int k);
  double tip_slope(const Eigen::VectorXd& z);  ///< t.n of a tip contact; -1 without one
  /// How fast the rod's surface slides at contact k along the obstacle's turned normal, in a direction at z.
  double sliding(const Eigen::VectorXd& z, const Eigen::VectorXd& direction, int k);
  /// The contact that slides fastest with its friction instead of against it while the load grows from z, and how fast
  /// along the unit tangent; -1, and 0: none does.
  std::pair<int, double> slides_with_friction(const Eigen::VectorXd& z);
  /// Contact k held where it is at z.
  Anchor anchor(const Eigen::VectorXd& z, int k) { return at(z).anchor(k); }
  /// Contacts that stick do so from where they are at z on.
  void anchor(const Eigen::VectorXd& z);
  std::vector<Certifier::Approach> penetrations(const Eigen::VectorXd& z);
  /// Local minima below `level` of the distances between rod and obstacles.
  std::vector<Certifier::Approach> approaches(const Eigen::VectorXd& z, double level);
  Certificate certify(const Eigen::VectorXd& z);

  /// Moves the program to z; the reference stays valid until the next call.
  PoseProgram& at(const Eigen::VectorXd& z);
  const Eigen::VectorXd& variables() const { return x_; }
  /// Of an actuator, where the program was moved to.
  double moment(int actuator) const { return x_[program_.moment_variable(actuator)]; }

 private:
  /// The equations at z and their rate with the load; false: something is no number.
  bool evaluate(const Eigen::VectorXd& z);
  /// Derivatives by y and the load, without the last row.
  void fill(Eigen::MatrixXd& system) const;
  Eigen::VectorXd full(const Eigen::VectorXd& y) const;
  Certifier& certifier(const Eigen::VectorXd& z);
  /// Room of contact k's arc length downward and upward.
  std::pair<double, double> bounds(const Eigen::VectorXd& z, int k) const;

  void place(const Eigen::VectorXd& z);  ///< x_, without evaluating anything
  /// d x / d load of what is given, at fixed y.
  Eigen::VectorXd given_rates() const;
  std::span<const double> knots(const Eigen::VectorXd& z);
  void set_load(double load);  ///< of the program
  Loads loads(double load) const;

  const LoadPath& path_;
  std::shared_ptr<const LegendreBasis> basis_;
  PoseProgram program_;
  std::vector<int> taut_;           ///< actuators
  std::vector<int> shear_indices_;  ///< per contact
  std::vector<Anchor> anchors_;     ///< per contact; empty: none sticks
  Certifier certifier_;
  Equations equations_;
  double load_ = std::nan("");  ///< of the program, and of the certifier; none at first
  double certified_load_ = std::nan("");
  Eigen::VectorXd x_, rate_;
};

}  // namespace tendril
