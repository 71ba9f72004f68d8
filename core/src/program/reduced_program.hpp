#pragma once

#include <map>
#include <string>
#include <vector>

#include "program/equations.hpp"

namespace tendril {

/// A pose program in its moments alone, with the palm distance of a grasp and the tangential ratios of contacts where
/// these are variables: they decide
/// the shape, the places and the forces of contacts as long as the equilibrium is followed from a point where all of
/// these are known. For every contact has to be decided whether it touches. What are variables there, and bounded, are
/// rows here, behind the inequalities of the program; equations are solved by Newton's method. Exact first and second
/// derivatives.
///
/// However many coordinates a model has, this program is as small as the rod has actuators. It is never anywhere but in
/// equilibrium, and never leaves the branch of equilibria that it began on: where that ends, its values are not finite.
/// A value depends on the moments and the start alone, not on what was asked for before.
class TENDRIL_API ReducedProgram : public NonlinearProgram {
 public:
  /// Whether equilibrium and contact decide all but these, and there is one of them to choose.
  static bool applies(const PoseProgram& program);

  /// `program` is borrowed, must outlive this, and applies(). From x, which its equations hold at, or nearly so.
  ReducedProgram(PoseProgram& program, ConstVectorRef x);
  ~ReducedProgram() override;

  /// The moments at the point that this began with, then the palm distance, then the tangential ratios.
  const Eigen::VectorXd& start() const { return start_; }
  /// How many of the variables, the last ones, are tangential ratios.
  int ratio_count() const { return parts_.ratios; }
  /// The point of the pose program at moments u; not finite where the branch does not reach.
  const Eigen::VectorXd& full(ConstVectorRef u);

  /// Names of the pose program; what is a variable there and a row here keeps its name.
  std::string row_name(int row) const override;
  std::string variable_name(int variable) const override;  ///< "moment 1", "tangential ratio 1" and so on.

 protected:
  void do_evaluate(ConstVectorRef u, bool derivatives, Workspace& out) override;
  void do_hessian(ConstVectorRef u, double sigma, ConstVectorRef multipliers, Workspace& out) override;

 private:
  struct Parts {
    std::vector<int> chosen;     ///< variables: moments, palm distance and tangential ratios that are not fixed
    std::vector<int> following;  ///< variables: what the equations decide
    std::vector<int> equations;  ///< rows
    std::vector<int> others;     ///< rows
    std::vector<int> limited;    ///< of `following`, those with a bound: places in it
    int ratios = 0;              ///< so many of `chosen`, the last ones, are tangential ratios
  };
  static Parts parts_of(const PoseProgram& program);
  ReducedProgram(PoseProgram& program, ConstVectorRef x, Parts parts);

  /// A point of the branch with its slopes, to follow it from.
  struct Anchor {
    Eigen::VectorXd x;      ///< of the pose program
    Eigen::MatrixXd slope;  ///< following x chosen
    int sign = 0;           ///< of the determinant of the equations; 0: there is no point
  };
  /// The anchor for a cell of a grid of moments around the start: in its middle, if the branch reaches that from the
  /// anchor of the cell half as far from the start; else that one. Made when it is first asked for.
  const Anchor& anchor(const std::vector<int>& cell);
  /// Follows the branch to moments u: x_ is then the point. False: it does not reach.
  bool follow(const Anchor& from, ConstVectorRef u);
  bool follow(ConstVectorRef u);
  /// Newton's method on the equations from x_, whose moments stay.
  bool correct();
  /// d x_following / d u at x_, the factors of the equations there, and the sign of their determinant.
  void find_slopes();
  /// Largest change of what follows, each relative to 1 + itself.
  double distance(const Eigen::VectorXd& from, const Eigen::VectorXd& to) const;

  PoseProgram& program_;
  Parts parts_;
  PoseProgram alone_;  ///< with the variables of `program_`, to follow the branch with
  Equations equations_;
  Eigen::VectorXd start_;
  Eigen::VectorXd x_;  ///< of the pose program, of the last call
  std::map<std::vector<int>, Anchor> anchors_;
  Anchor at_;  ///< the last point in equilibrium on the way
  Eigen::VectorXd predicted_, middle_;
  std::vector<int> cell_;
  int sign_ = 0;
  bool reached_ = false;
  Eigen::VectorXd reached_at_;  ///< moments
  Eigen::MatrixXd slope_;
  Eigen::VectorXd residual_, correction_, step_, adjoint_, full_multipliers_;
  Eigen::MatrixXd tangent_, bent_;  ///< d x / d u: all variables x chosen; Hessian times it
};

}  // namespace tendril
