#pragma once

#include <vector>

#include "tendril/nonlinear_program.hpp"

namespace tendril {

/// c_row(x) >= 0, x_variable >= 0, one of them zero.
struct ComplementaryPair {
  int row = 0;       ///< of the base program
  int variable = 0;  ///< of the base program
};

/// A program with complementarity, treated so that an ordinary solver can take it (model.md section 4). With g the row
/// and f the variable of a pair:
///
///     penalty             cost + parameter * g f
///     slack               rows g f - lambda = 0, variables lambda >= 0 behind the others, cost + parameter * lambda
///     scholtes            rows g f <= parameter
///     fischer_burmeister  rows g + f - sqrt(g^2 + f^2 + 2 parameter) = 0
///
/// The pair's own bounds stay. Variables of the base program come first, its rows too.
class TENDRIL_API ComplementarityProgram : public NonlinearProgram {
 public:
  /// `base` is borrowed and must outlive this.
  ComplementarityProgram(NonlinearProgram& base, std::vector<ComplementaryPair> pairs, Treatment treatment,
                         double parameter);
  ~ComplementarityProgram() override;

  /// Sets the parameter of the treatment, also where it stands in a bound.
  void set_parameter(double parameter);
  /// What set_parameter() or the constructor set.
  double parameter() const { return parameter_; }
  /// Bounds of the base program may have changed.
  void refresh_bounds();
  /// A start of this program from one of the base program.
  Eigen::VectorXd extend(ConstVectorRef base_x);

  std::string row_name(int row) const override;
  std::string variable_name(int variable) const override;  ///< That of the base program; "slack 1" and so on behind it.

 protected:
  void do_evaluate(ConstVectorRef x, bool derivatives, Workspace& out) override;
  void do_hessian(ConstVectorRef x, double sigma, ConstVectorRef multipliers, Workspace& out) override;

 private:
  /// psi(g, f) of an extra row and its derivatives.
  struct Coupling {
    double value = 0.0, g = 0.0, f = 0.0, gg = 0.0, gf = 0.0, ff = 0.0;
  };
  Coupling couple(double g, double f) const;
  bool has_rows() const { return treatment_ != Treatment::penalty; }

  NonlinearProgram& base_;
  std::vector<ComplementaryPair> pairs_;
  Treatment treatment_;
  double parameter_;
  int base_variables_, base_rows_;
  Eigen::VectorXd base_x_, base_multipliers_;
};

}  // namespace tendril
