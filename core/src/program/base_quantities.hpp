#pragma once

#include <vector>

#include "objective/term_set.hpp"
#include "obstacle/surface.hpp"
#include "program/pose_program.hpp"
#include "rod/places.hpp"

namespace tendril {

class TipDeviations;

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// The few numbers through which terms and rows of contacts see a program's point: positions, angles and curvatures of
/// places, the bending energy, and single variables. Behind them stand the virtual displacements of contacts, which
/// second derivatives alone need. Whoever has second derivatives adds outer ones to `gradient` and `hessian`; these are
/// pulled back once.
class BaseQuantities {
 public:
  /// Makes the places that terms read. `contact_places`: one per contact.
  BaseQuantities(const PoseProgramSpec& spec, const PoseProgram::Layout& layout,
                 const std::vector<int>& moment_variables, std::vector<int> contact_places, Places& places);
  ~BaseQuantities();

  TermSet terms;
  BaseIndex index;
  BaseValues values;
  Eigen::VectorXd gradient;  ///< of  sigma f + multipliers . c, by the quantities
  Eigen::MatrixXd hessian;   ///< likewise, and by displacements

  void move(ConstVectorRef x, const std::vector<PoseProgram::ContactState>& contacts);
  /// Rows of all quantities at the point that `places` was differentiated at.
  void differentiate();
  /// Derivatives of quantity b, or of a displacement, by all variables.
  auto row(int b) const { return rows_.row(row_number(b)); }

  /// Gradient, gradient of the rest, Jacobian of the residuals.
  void differentiate_terms(Eigen::VectorXd& gradient, Eigen::VectorXd& rest, Eigen::MatrixXd& jacobian);

  /// The tangential force of a contact that sticks; -1: it does not.
  int shear(int contact) const { return shears_[static_cast<std::size_t>(contact)]; }
  /// Number in `hessian` of the first of two coordinates of a contact's virtual displacement.
  int displacement(int contact) const { return index.count + 2 * contact; }
  /// Begins with the terms times sigma.
  void start_second(double sigma);
  /// Rows of the displacements that `places` made last.
  void displace();
  /// What the gradient amounts to on places.
  void add_pushes(Forces& forces) const;
  void add_symmetric(int a, int b, double value) {
    hessian(a, b) += value;
    hessian(b, a) += value;
  }
  /// Second derivatives by the position of a point.
  void add(const BaseIndex::Point& p, const Symmetric2& of_position) {
    hessian(p.x, p.x) += of_position.xx;
    hessian(p.y, p.y) += of_position.yy;
    add_symmetric(p.x, p.y, of_position.xy);
  }
  double energy_slope() const { return index.energy >= 0 ? gradient[index.energy] : 0.0; }
  /// Adds what deviations of the tip bend themselves, times the gradient by them.
  void add_deviations_second(Eigen::MatrixXd& out) const;
  /// As PoseProgram::set_branch().
  void set_branch(int contact, Branch branch);
  /// Adds the outer second derivatives to those by all variables.
  void pull_back(Eigen::MatrixXd& out);

 private:
  int row_number(int b) const { return b < dense_ ? b : b - index.count + dense_; }
  bool is_variable(int b) const { return b >= dense_ && b < index.count; }
  int variable(int b) const { return variables_[static_cast<std::size_t>(b - dense_)]; }
  RowPart part(int b) { return {rows_.row(row_number(b)).data(), rows_.row(row_number(b)).data() + first_move_}; }

  Places& places_;
  std::unique_ptr<TipDeviations> deviations_;  ///< where a term reads them
  int first_move_ = 0;
  std::vector<int> contact_places_, sample_places_;
  int tip_place_ = -1;
  int dense_ = 0;               ///< quantities with a row: the first ones
  std::vector<int> variables_;  ///< of the quantities behind them
  std::vector<int> shears_;     ///< one per contact
  RowMatrix rows_;              ///< quantities with a row, displacements
  Eigen::VectorXd term_gradient_, term_rest_, pulled_;
  Eigen::MatrixXd term_jacobian_;
};

}  // namespace tendril
