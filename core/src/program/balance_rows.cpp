// No force is left on a grasped object along the axis.

#include "program/row_block.hpp"

namespace tendril {
namespace {

class BalanceRows : public RowBlock {
 public:
  explicit BalanceRows(PoseState& state) : RowBlock("force_balance", state.layout.first_balance, 1), d_(state) {}

  void evaluate(ConstVectorRef /*x*/, bool derivatives, VectorRef values, MatrixRef rows) override {
    const Vec2 axis = d_.spec.palm->axis;
    values[0] = 0.0;
    if (derivatives) rows.setZero();
    for (int k = 0; k < d_.layout.forces; ++k) {
      const PoseProgram::ContactState& c = d_.contacts[static_cast<std::size_t>(k)];
      const double share = dot(c.push, axis);
      values[0] += c.force * share;
      if (!derivatives) continue;
      const Vec2 tau = turned(c.surface.normal);
      rows.row(0) += d_.contact_row(k, c.force * c.surface.curvature * dot(turned(c.push), axis) * tau);
      rows(0, d_.layout.first_force + k) += share;
    }
  }

  /// The row has the form of work along a constant displacement.
  void add_second(ConstVectorRef multipliers, Eigen::MatrixXd& /*hessian*/) override {
    for (int k = 0; k < d_.layout.forces; ++k) d_.add_force_work(k, multipliers[0] * d_.spec.palm->axis);
  }

 private:
  PoseState& d_;
};

}  // namespace

std::unique_ptr<RowBlock> balance_rows(PoseState& state) { return std::make_unique<BalanceRows>(state); }

}  // namespace tendril
