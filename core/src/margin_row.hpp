#pragma once

#include "stability.hpp"

namespace tendril {

/// The row of a pose program that keeps its margin of stability up. Values and gradients are exact; second derivatives
/// would be fourth ones of the energy, and are learned from the gradients instead (symmetric rank-one updates, exact
/// along the directions that a search has taken). They steer steps; what is accepted rests on gradients alone.
class MarginRow {
 public:
  /// For the program of `spec`, whose own row is left out here.
  explicit MarginRow(const PoseProgramSpec& spec);

  double value(ConstVectorRef x);
  /// The value as well; gradient() is then that of x.
  double differentiate(ConstVectorRef x);
  const Eigen::VectorXd& gradient() const { return gradient_; }
  const Eigen::MatrixXd& hessian() const { return hessian_; }

 private:
  void learn(ConstVectorRef x);

  PoseProgram program_;
  Stability stability_;
  Eigen::VectorXd gradient_;
  Eigen::VectorXd x_before_, gradient_before_, step_, defect_;
  Eigen::MatrixXd hessian_;
  bool has_before_ = false;
};

}  // namespace tendril
