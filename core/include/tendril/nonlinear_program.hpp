#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <string_view>

#include "tendril/export.hpp"
#include "tendril/numbers.hpp"

namespace tendril {

/// What a program hands out: views without an alignment promise. Owning Eigen objects must not cross into a plugin,
/// which may be built for wider vector registers than core. `auto` keeps a view; naming VectorXd makes a copy.
using VectorView = Eigen::Map<const Eigen::VectorXd>;
using MatrixView = Eigen::Map<const Eigen::MatrixXd>;  ///< As VectorView; column-major.

/// What becomes of complementarity before a solver sees it (ComplementarityProgram).
enum class Treatment { penalty, slack, scholtes, fischer_burmeister };
TENDRIL_API std::string_view to_string(Treatment treatment);  ///< The word that scenes use.

/// How often a program was evaluated (cache hits do not count).
struct EvaluationCounts {
  std::int64_t values = 0;             ///< cost and constraints
  std::int64_t first_derivatives = 0;  ///< gradient and Jacobian
  std::int64_t hessians = 0;           ///< Hessian of the Lagrangian
  double seconds = 0.0;                ///< wall time inside the program for all of these

  /// Adds up.
  EvaluationCounts& operator+=(const EvaluationCounts& more) {
    values += more.values;
    first_derivatives += more.first_derivatives;
    hessians += more.hessians;
    seconds += more.seconds;
    return *this;
  }
};

/// A dense, smooth nonlinear program
///
///     min f(x)   s.t.   row_lower <= c(x) <= row_upper,   lower <= x <= upper
///
/// with f(x) = sum r_i(x)^2 + rest(x) where it has a least-squares view. Equal bounds make an equality, infinities
/// leave a side open. Values and derivatives at one x are computed once, in whatever order a solver asks. Sizes are
/// fixed for the lifetime; nothing here allocates after construction.
class TENDRIL_API NonlinearProgram {
 public:
  virtual ~NonlinearProgram();
  NonlinearProgram(const NonlinearProgram&) = delete;
  NonlinearProgram& operator=(const NonlinearProgram&) = delete;

  /// Length of x.
  int variable_count() const { return static_cast<int>(lower_.size()); }
  /// Length of c(x).
  int row_count() const { return static_cast<int>(row_lower_.size()); }
  /// Lower bounds of x: variable_count() entries.
  VectorView lower() const { return view(lower_); }
  /// Upper bounds of x: variable_count() entries.
  VectorView upper() const { return view(upper_); }
  /// Lower bounds of c(x): row_count() entries.
  VectorView row_lower() const { return view(row_lower_); }
  /// Upper bounds of c(x): row_count() entries.
  VectorView row_upper() const { return view(row_upper_); }
  /// Whether both bounds of a row are equal.
  bool is_equality(int row) const { return row_lower()[row] == row_upper()[row]; }

  /// All of these move the program to x (variable_count() entries, else Error) and compute only what is missing there;
  /// two points are the same if they are so bit by bit. Views stay valid until the next call with another x. A value
  /// may be non-finite: the caller decides. What the implementation throws passes, and the point then counts as not
  /// computed.
  double cost(ConstVectorRef x);
  VectorView gradient(ConstVectorRef x);     ///< Of the whole cost: variable_count() entries.
  VectorView constraints(ConstVectorRef x);  ///< c(x): row_count() entries.
  /// row_count() x variable_count().
  MatrixView jacobian(ConstVectorRef x);
  /// Full symmetric Hessian of  sigma f(x) + sum_i multipliers_i c_i(x),  variable_count() squared.
  MatrixView hessian(ConstVectorRef x, double sigma, ConstVectorRef multipliers);

  /// Least-squares view: number of residuals; r(x); dr/dx (residual_count() x variable_count()); and the part of the
  /// cost that is not a sum of squares with its gradient. There may be no residuals, and the rest may be 0, everywhere
  /// or at some points.
  int residual_count() const { return static_cast<int>(work_.residuals.size()); }
  VectorView residuals(ConstVectorRef x);          ///< r(x): residual_count() entries.
  MatrixView residual_jacobian(ConstVectorRef x);  ///< dr/dx: residual_count() x variable_count().
  double rest(ConstVectorRef x);                   ///< The part of the cost that is not a sum of squares.
  VectorView rest_gradient(ConstVectorRef x);      ///< Gradient of rest(x): variable_count() entries.

  /// What the program calls its rows and variables, for messages ("equilibrium row 3").
  virtual std::string row_name(int row) const;
  virtual std::string variable_name(int variable) const;  ///< The same for a variable ("moment 1").

  /// Evaluations since the program was made or reset_counts() was called.
  const EvaluationCounts& counts() const { return counts_; }
  /// Starts counting anew.
  void reset_counts() { counts_ = {}; }
  /// Forgets the point computed last (after data of the program changed).
  void invalidate();

 protected:
  /// All bounds start open, all rows as equations c = 0; the implementation sets its own.
  NonlinearProgram(int variables, int rows, int residuals);

  Eigen::VectorXd lower_;      ///< variable_count() entries
  Eigen::VectorXd upper_;      ///< variable_count() entries
  Eigen::VectorXd row_lower_;  ///< row_count() entries
  Eigen::VectorXd row_upper_;  ///< row_count() entries

  /// What an implementation writes into. Cost and gradient are those of the whole objective.
  struct Workspace {
    double cost = 0.0;                  ///< f(x)
    double rest = 0.0;                  ///< the part of f(x) that is no sum of squares
    Eigen::VectorXd gradient;           ///< of f: variable_count() entries
    Eigen::VectorXd constraints;        ///< c(x): row_count() entries
    Eigen::VectorXd residuals;          ///< r(x): residual_count() entries
    Eigen::VectorXd rest_gradient;      ///< variable_count() entries
    Eigen::MatrixXd jacobian;           ///< row_count() x variable_count()
    Eigen::MatrixXd hessian;            ///< of the Lagrangian: variable_count() squared, both triangles
    Eigen::MatrixXd residual_jacobian;  ///< residual_count() x variable_count()
  };

  /// Fills cost, rest, constraints, residuals; with `derivatives` also gradient, jacobian, rest_gradient,
  /// residual_jacobian. Matrices arrive as they were left: write every entry, or keep constant entries from the first
  /// time on.
  virtual void do_evaluate(ConstVectorRef x, bool derivatives, Workspace& out) = 0;
  /// Fills out.hessian at the x of the last do_evaluate(x, true, ...).
  virtual void do_hessian(ConstVectorRef x, double sigma, ConstVectorRef multipliers, Workspace& out) = 0;

 private:
  static VectorView view(const Eigen::VectorXd& v) { return {v.data(), v.size()}; }
  static MatrixView view(const Eigen::MatrixXd& m) { return {m.data(), m.rows(), m.cols()}; }
  void move_to(ConstVectorRef x, bool derivatives);

  Workspace work_;
  Eigen::VectorXd x_;
  bool values_known_ = false;
  bool derivatives_known_ = false;
  bool hessian_known_ = false;
  double hessian_sigma_ = 0.0;
  Eigen::VectorXd hessian_multipliers_;
  EvaluationCounts counts_;
};

/// A point of a program judged by first-order conditions alone.
struct KktJudgement {
  double cost = infinity;             ///< of the program
  double infeasibility = infinity;    ///< largest violation of rows and bounds
  double stationarity = infinity;     ///< largest entry of the Lagrangian's gradient with admissible multipliers
  Eigen::VectorXd multipliers;        ///< of the rows; a row at its lower bound <= 0, at its upper >= 0, inactive 0
  Eigen::VectorXd bound_multipliers;  ///< of the variables, same signs
  Eigen::VectorXd slope;              ///< gradient of the Lagrangian, where multipliers were given
};

}  // namespace tendril
