#pragma once

#include <Eigen/LU>
#include <vector>

#include "program/pose_program.hpp"

namespace tendril {

/// Equations F = 0 that decide some variables of a pose program, the unknowns, by all others (model.md section 3): as
/// many of its rows. Nothing allocates after construction but what is returned.
class Equations {
 public:
  /// The program is borrowed.
  Equations(PoseProgram& program, std::vector<int> rows, std::vector<int> unknowns);
  /// A rod with touching contacts: equilibrium, closest points and gaps decide coordinates, arc lengths and forces.
  /// What is separated has a place, but no force.
  /// The shortenings of taut tendons (actuators that are held by their length) decide their moments, and what may not
  /// slide tangential forces.
  static Equations of_contacts(PoseProgram& program, const std::vector<int>& taut = {});
  /// Equilibrium alone, for the coordinates.
  static Equations of_equilibrium(PoseProgram& program);
  /// The same rod and contacts without what does not decide its shape: terms, clearances, and rows that hold a plan
  /// back. Variables and the rows of equilibrium and contact stay where they are.
  static PoseProgramSpec alone(PoseProgramSpec spec);

  int size() const { return static_cast<int>(rows_.size()); }
  int row(int i) const { return rows_[static_cast<std::size_t>(i)]; }
  int unknown(int i) const { return unknowns_[static_cast<std::size_t>(i)]; }

  /// Moves to a point of the program. False: something there is no number.
  bool evaluate(ConstVectorRef x);
  /// Likewise, without the Jacobian.
  const Eigen::VectorXd& residual_at(ConstVectorRef x);
  const Eigen::VectorXd& residual() const { return residual_; }
  /// By the unknowns.
  const Eigen::MatrixXd& jacobian() const { return jacobian_; }

  ///@{
  /// Of the Jacobian at the point moved to last.
  const Eigen::PartialPivLU<Eigen::MatrixXd>& factor();
  const Eigen::PartialPivLU<Eigen::MatrixXd>& factors() const { return factors_; }
  int sign() const;  ///< of its determinant, after factor()
  ///@}
  /// How the unknowns follow other variables there (implicit function theorem), after factor(): unknowns x variables.
  void find_rates(ConstVectorRef x, const std::vector<int>& variables, Eigen::MatrixXd& out);

 private:
  PoseProgram& program_;
  std::vector<int> rows_, unknowns_;
  Eigen::VectorXd residual_;
  Eigen::MatrixXd jacobian_, right_;
  Eigen::PartialPivLU<Eigen::MatrixXd> factors_;
};

}  // namespace tendril
