// No force is left on a grasped object along the axis. One contact that presses leaves none exactly where it pushes
// across the axis: the row is that direction alone. Times the force it would vanish with it, and a solver would rather
// let go of the object than turn the contact.

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
      values[0] += weight(c) * share;
      if (!derivatives) continue;
      const Vec2 tau = turned(c.surface.normal);
      rows.row(0) += d_.contact_row(k, weight(c) * c.surface.curvature * dot(turned(c.push), axis) * tau);
      if (!alone()) rows(0, d_.layout.first_force + k) += share;
    }
  }

  /// The row has the form of work along a constant displacement, of a unit force where there is one contact.
  void add_second(ConstVectorRef multipliers, Eigen::MatrixXd& /*hessian*/) override {
    for (int k = 0; k < d_.layout.forces; ++k) {
      const Vec2 displacement = multipliers[0] * d_.spec.palm->axis;
      if (alone()) {
        d_.add_push_work(k, displacement, 1.0);
      } else {
        d_.add_force_work(k, displacement);
      }
    }
  }

 private:
  bool alone() const { return d_.layout.forces == 1; }
  double weight(const PoseProgram::ContactState& c) const { return alone() ? 1.0 : c.force; }

  PoseState& d_;
};

}  // namespace

std::unique_ptr<RowBlock> balance_rows(PoseState& state) { return std::make_unique<BalanceRows>(state); }

}  // namespace tendril
