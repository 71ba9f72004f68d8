#pragma once

#include "tendril/nonlinear_program.hpp"

namespace tendril {

/// Second derivatives of a function that has gradients alone, learned from these as a search moves: symmetric rank-one
/// updates, exact along the directions that were taken. They steer steps; what is accepted rests on gradients. Nothing
/// allocates after construction.
class TENDRIL_API LearnedHessian {
 public:
  /// What was learned before a step longer than `longest_step` is forgotten: it says nothing of where that leads to.
  explicit LearnedHessian(int variables, double longest_step = infinity);

  /// The gradient at x is this.
  void learn(ConstVectorRef x, ConstVectorRef gradient);
  const Eigen::MatrixXd& matrix() const { return hessian_; }

 private:
  Eigen::VectorXd x_, gradient_, step_, defect_;
  Eigen::MatrixXd hessian_;
  double longest_step_ = infinity;
  bool has_point_ = false;
};

}  // namespace tendril
