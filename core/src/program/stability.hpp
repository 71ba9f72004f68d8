#pragma once

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <vector>

#include "program/motion.hpp"
#include "program/pose_program.hpp"

namespace tendril {

/// Stability of the equilibria of one pose program (model.md section 7): the second variation at frozen knots, its
/// smallest eigenvalue against the bending energy, and how that changes with the plan. Nothing allocates after the
/// first evaluation with one number of pressing contacts. What a contact that sticks leaves free does not slide,
/// either. Where contacts slip, which push otherwise than along their normals, there is no energy: the margin is the
/// smallest real part of the eigenvalues of a pencil that is not symmetric (model.md section 11), and has no gradient
/// here. Taut tendons that are held by their length (model.md section 10) leave free only what does not lengthen them.
class Stability {
 public:
  /// For programs on the chain of `program`, with its variables.
  explicit Stability(const PoseProgram& program);

  /// Contacts inside the rod that lean on its end slide no farther: disturbed to that side they are contacts at the
  /// tip.
  void hold_ends(bool hold) { ends_hold_ = hold; }
  /// Whether contact k inside the rod leans on its end at the point computed last: its arc length is at the bound that
  /// keeps it knot_clearance away, or no farther from that than the bound is from the end.
  static bool leans_on_end(const PoseProgram& program, int contact);

  /// H before projection at x: coordinates() squared.
  void second_variation(PoseProgram& program, ConstVectorRef x, Eigen::MatrixXd& h);
  /// The margin mu at x. Infinity where contacts leave nothing free, minus infinity where H is not finite.
  double margin(PoseProgram& program, ConstVectorRef x);
  /// Of the last margin: taut tendons whose length is held.
  int held_lengths() const { return static_cast<int>(taut_.size()); }
  /// The margin, and d mu / dx: variable_count() entries, exact where the smallest eigenvalue is simple.
  double margin(PoseProgram& program, ConstVectorRef x, VectorRef gradient);
  /// How the last margin changes beside that, at a point that is held, where the program is another one. `rates`: with
  /// `slope` at multipliers(); its `energy` of energy().
  double rate(const ProgramRates& rates) const;
  /// Of the program's rows, from the last margin with its gradient; 0: it has none.
  const Eigen::VectorXd& multipliers() const { return multipliers_; }
  /// Twice the elastic energy that the last margin's eigenvector has in a program; 1 in its own.
  double energy(const PoseProgram& program) const;

 private:
  /// h in coordinates in which the bending energy is the unit matrix.
  void scale_to_energy(const PoseProgram& program, Eigen::MatrixXd& h);
  /// A row by the coordinates in these.
  void scale_to_energy(const PoseProgram& program, const Eigen::VectorXd& row, Eigen::Ref<Eigen::VectorXd> out) const;
  double smallest_eigenvalue_of(const Eigen::MatrixXd& h);  ///< symmetric
  double slipping_margin(PoseProgram& program, ConstVectorRef x, const Eigen::MatrixXd& h);
  void find_held(PoseProgram& program, ConstVectorRef x);
  /// The rows of what is held, in coordinates in which the bending energy is the unit matrix.
  void fill_held(PoseProgram& program, ConstVectorRef x);
  /// Takes out a tendon whose row is made of the others': nothing more is held by it.
  bool drop_dependent();
  Eigen::Index held_count() const {
    return static_cast<Eigen::Index>(touching_.size() + sticking_.size() + taut_.size());
  }
  void find_eigenvector(double eigenvalue);
  void find_direction(const PoseProgram& program);
  void find_multipliers();
  void sum_gradient(PoseProgram& program, ConstVectorRef x, double eigenvalue, VectorRef gradient);

  bool ends_hold_ = false;
  std::vector<int> touching_;
  std::vector<int> sticking_;  ///< variables of tangential forces inside of their cones
  std::vector<int> taut_;      ///< moment variables
  Eigen::MatrixXd hessian_, block_, normals_, free_, shifted_;
  Eigen::MatrixXd pushed_, share_;             ///< where contacts that slip push, and what the test space has of it
  Eigen::VectorXd turning_;                    ///< a row of a contact, by the coordinates
  Eigen::VectorXd reflection_;                 ///< of Householder
  Eigen::VectorXd vector_, next_, direction_;  ///< eigenvector: reduced, and in coordinates
  Eigen::VectorXd holding_;                    ///< multipliers of the rows that contacts hold
  Eigen::VectorXd multipliers_, convexity_;
  Eigen::VectorXd by_convexity_;  ///< rate of the margin by d_ss of each contact
  double eigenvalue_ = 0.0;
  Eigen::HouseholderQR<Eigen::MatrixXd> qr_;
  Eigen::Tridiagonalization<Eigen::MatrixXd> tridiagonal_{2};
  Eigen::VectorXd diagonal_, beside_;  ///< of the tridiagonal matrix
  Eigen::PartialPivLU<Eigen::MatrixXd> lu_;
  Eigen::EigenSolver<Eigen::MatrixXd> eigenvalues_;
};

}  // namespace tendril
