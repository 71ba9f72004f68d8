// The margin of stability stays up. Values and gradients are exact; second derivatives would be fourth ones of the
// energy, and are learned instead.

#include "nlp/learned_hessian.hpp"
#include "program/equations.hpp"
#include "program/row_block.hpp"
#include "program/stability.hpp"

namespace tendril {
namespace {

class StabilityRows : public RowBlock {
 public:
  explicit StabilityRows(const PoseState& state)
      : RowBlock("stability", state.layout.first_margin, 1, *state.spec.least_margin, infinity),
        d_(state),
        program_(Equations::alone(state.spec)),
        stability_(program_),
        gradient_(Eigen::VectorXd::Zero(state.variables)),
        learned_(state.variables) {}

  void evaluate(ConstVectorRef x, bool derivatives, VectorRef values, MatrixRef rows) override {
    program_.set_loads(d_.loads);
    const double margin = derivatives ? stability_.margin(program_, x, gradient_) : stability_.margin(program_, x);
    // With nothing left free there is nothing to be unstable: the margin of a rod without loads.
    values[0] = margin == infinity ? 1.0 : margin;
    if (!derivatives) return;
    rows.row(0) = gradient_.transpose();
    learned_.learn(x, gradient_);
  }

  void add_second(ConstVectorRef multipliers, Eigen::MatrixXd& hessian) override {
    if (multipliers[0] != 0.0) hessian += multipliers[0] * learned_.matrix();
  }

 private:
  const PoseState& d_;
  PoseProgram program_;  ///< of the equations alone: this row is part of what is being evaluated
  Stability stability_;
  Eigen::VectorXd gradient_;
  LearnedHessian learned_;
};

}  // namespace

std::unique_ptr<RowBlock> stability_rows(PoseState& state) { return std::make_unique<StabilityRows>(state); }

}  // namespace tendril
