// No force is left on a grasped object along the axis. One contact that presses leaves none exactly where it pushes
// across the axis: the row is that direction alone. Times the force it would vanish with it, and a solver would rather
// let go of the object than turn the contact. Contacts of an object that is loaded have to press: there forces count.

#include <algorithm>

#include "program/row_block.hpp"

namespace tendril {
namespace {

class BalanceRows : public RowBlock {
 public:
  explicit BalanceRows(PoseState& state)
      : RowBlock("force_balance", state.layout.first_balance, state.layout.balances), d_(state) {}

  void evaluate(ConstVectorRef /*x*/, bool derivatives, VectorRef values, MatrixRef rows) override {
    values.setZero();
    values[0] = -d_.spec.palm->load;
    if (derivatives) rows.setZero();
    for (int k = 0; k < d_.layout.forces; ++k) {
      const PoseProgram::ContactState& c = d_.contacts[static_cast<std::size_t>(k)];
      for (int part = 0; part < std::min(count(), 2); ++part) {
        const double share = dot(c.push, direction(part));
        values[part] += weight(c) * share;
        if (derivatives) differentiate(k, part, share, rows.row(part));
      }
      if (count() < 3) continue;
      values[2] += c.force * c.lean;
      if (!derivatives) continue;
      rows(2, d_.layout.first_force + k) = c.lean;
      rows(2, d_.layout.first_lean + k) = c.force;
    }
  }

  /// The rows have the form of work along a constant displacement, of a unit force where directions count.
  void add_second(ConstVectorRef multipliers, Eigen::MatrixXd& /*hessian*/) override {
    Vec2 displacement{};
    for (int part = 0; part < std::min(count(), 2); ++part) displacement += multipliers[part] * direction(part);
    for (int k = 0; k < d_.layout.forces; ++k) {
      if (alone()) {
        d_.add_push_work(k, displacement, 1.0);
      } else {
        d_.add_force_work(k, displacement);
      }
      const BaseIndex::Contact& at = d_.base.index.contacts[static_cast<std::size_t>(k)];
      if (count() == 3) d_.base.add_symmetric(at.force, at.lean, multipliers[2]);
    }
  }

 private:
  template <class Row>
  void differentiate(int k, int part, double share, Row&& row) {
    const PoseProgram::ContactState& c = d_.contacts[static_cast<std::size_t>(k)];
    const Vec2 tau = turned(c.surface.normal);
    row += d_.contact_row(k, weight(c) * c.surface.curvature * dot(turned(c.push), direction(part)) * tau);
    if (!alone()) row[d_.layout.first_force + k] += share;
    if (d_.layout.leans > 0) row[d_.layout.first_lean + k] += weight(c) * dot(tau, direction(part));
  }

  bool alone() const { return d_.layout.forces == 1 && !d_.spec.palm->loaded; }
  double weight(const PoseProgram::ContactState& c) const { return alone() ? 1.0 : c.force; }
  Vec2 direction(int part) const { return part == 0 ? d_.spec.palm->axis : turned(d_.spec.palm->axis); }

  PoseState& d_;
};

}  // namespace

std::unique_ptr<RowBlock> balance_rows(PoseState& state) { return std::make_unique<BalanceRows>(state); }

}  // namespace tendril
