#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "nlp/learned_hessian.hpp"
#include "program/equations.hpp"
#include "program/motion.hpp"
#include "rod/rod.hpp"

namespace tendril {

/// A number that a program was made of, and what changes with it, dimensionless, per unit of the number.
struct UncertainNumber {
  /// The rod where the number is larger by `step`: the program's rows are affine in its numbers, so that a difference
  /// is their rate. Absent: it is the same.
  std::optional<Rod> rod{};
  double step = 1.0;
  ProgramMotion motion{};
  bool moves = false;                    ///< `motion` is not nothing
  double length = 0.0, stiffness = 0.0;  ///< relative, of the units L and EI0
  /// Rate of an actuator's moment where its input is held, and its derivative by the moment. Empty: it stays.
  std::function<Rod::Jet(double moment)> held{};
  int actuator = -1;  ///< whose moment that is
};

/// What is not known of a program, as independent deviations.
struct Uncertainties {
  std::vector<UncertainNumber> numbers;
  Eigen::MatrixXd shares;  ///< deviations x numbers: by what each number goes with a deviation
  int deviations() const { return static_cast<int>(shares.rows()); }
};

/// Where each deviation takes the tip, to first order, under held moments and with closed contacts: x and y in turn, as
/// functions of a program's variables. They mean that at equilibria; elsewhere they are what the linear equations there
/// say. Exact first derivatives, by adjoints; second ones would be fourth derivatives of the energy, and are learned
/// instead. Nothing allocates after construction but set_branch().
class TipDeviations {
 public:
  explicit TipDeviations(const PoseProgramSpec& spec);
  ~TipDeviations();

  int count() const { return static_cast<int>(values_.size()); }
  /// As PoseProgram::set_branch(): what is separated holds nothing.
  void set_branch(int contact, Branch branch);
  /// At a point of the program; not finite where the equations have no solution.
  const Eigen::VectorXd& values_at(ConstVectorRef x);
  /// Derivatives by all variables, at the point that values were asked for last: count() x variables.
  const Eigen::MatrixXd& rows();
  /// Adds second derivatives of slopes . values.
  void add_second(ConstVectorRef slopes, Eigen::MatrixXd& hessian) const;

 private:
  /// A program of another rod.
  struct Other;

  /// Of the rows by a number, and of multipliers_ times them.
  void find_rates(int number, bool slopes);
  void solve();
  void start();
  void set_axis(int axis);

  std::shared_ptr<const Uncertainties> uncertain_;
  std::unique_ptr<ObjectiveTerm> tip_;  ///< along the target, the term of the program
  PoseProgram program_;
  std::optional<Equations> equations_;
  std::unique_ptr<MotionRates> motion_;         ///< where anything moves
  std::vector<std::unique_ptr<Other>> others_;  ///< of numbers; null: the rod stays
  std::vector<int> moment_variables_;           ///< of numbers; -1: it moves none
  Eigen::VectorXd x_, values_, pulled_, adjoint_, multipliers_;
  Eigen::MatrixXd right_;         ///< unknowns x deviations
  Eigen::MatrixXd along_, bent_;  ///< variables x deviations: their rates, second derivatives times these
  Eigen::MatrixXd tip_rows_;      ///< variables x 2
  Eigen::MatrixXd rows_;          ///< count x variables
  ProgramRates rates_;
  std::vector<LearnedHessian> learned_;
  bool solved_ = false, differentiated_ = false;
};

}  // namespace tendril
