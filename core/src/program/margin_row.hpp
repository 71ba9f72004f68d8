#pragma once

#include "nlp/learned_hessian.hpp"
#include "program/stability.hpp"

namespace tendril {

/// The row of a pose program that keeps its margin of stability up. Values and gradients are exact; second derivatives
/// would be fourth ones of the energy, and are learned instead.
class MarginRow {
 public:
  /// For the program of `spec`, whose own row is left out here.
  explicit MarginRow(const PoseProgramSpec& spec);

  void set_loads(const Loads& loads) { program_.set_loads(loads); }
  double value(ConstVectorRef x);
  /// The value as well; gradient() is then that of x.
  double differentiate(ConstVectorRef x);
  const Eigen::VectorXd& gradient() const { return gradient_; }
  const Eigen::MatrixXd& hessian() const { return learned_.matrix(); }

 private:
  PoseProgram program_;
  Stability stability_;
  Eigen::VectorXd gradient_;
  LearnedHessian learned_;
};

}  // namespace tendril
