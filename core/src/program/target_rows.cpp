// The tip stays within tolerances of the target.

#include <cmath>

#include "program/row_block.hpp"

namespace tendril {
namespace {

class TargetRows : public RowBlock {
 public:
  explicit TargetRows(PoseState& state)
      : RowBlock("target", state.layout.first_target, state.layout.targets),
        d_(state),
        position_(state.spec.tolerance.position),
        angle_(state.spec.tolerance.angle),
        turn_row_(std::isfinite(position_) ? 1 : 0) {}

  void bounds(VectorRef lower, VectorRef upper) const override {
    lower.setConstant(-infinity);
    upper.setZero();
    if (turn_row_ == count()) return;
    lower[turn_row_] = -angle_;
    upper[turn_row_] = angle_;
  }

  /// The distance itself has a kink at the target. This one is as long where it is large, and smooth.
  void evaluate(ConstVectorRef /*x*/, bool derivatives, VectorRef values, MatrixRef rows) override {
    const BaseIndex::Point& tip = d_.base.index.tip;
    const Eigen::VectorXd& base = d_.base.values.base;
    if (turn_row_ == 1) {
      const Vec2 off = from_target();
      values[0] = rounded(off) - std::sqrt(2.0) * position_;
      if (derivatives) rows.row(0) = (off.x * d_.base.row(tip.x) + off.y * d_.base.row(tip.y)) / rounded(off);
    }
    if (turn_row_ == count()) return;
    values[turn_row_] = base[tip.angle] - d_.spec.target.angle;
    if (derivatives) rows.row(turn_row_) = d_.base.row(tip.angle);
  }

  void add_second(ConstVectorRef multipliers, Eigen::MatrixXd& /*hessian*/) override {
    BaseQuantities& base = d_.base;
    const BaseIndex::Point& tip = base.index.tip;
    if (turn_row_ == 1) {
      const Vec2 off = from_target();
      const double distance = rounded(off);
      const double factor = multipliers[0] / distance;
      const Vec2 slope{off.x / distance, off.y / distance};
      base.gradient[tip.x] += multipliers[0] * slope.x;
      base.gradient[tip.y] += multipliers[0] * slope.y;
      base.add(tip,
               {factor * (1.0 - slope.x * slope.x), -factor * slope.x * slope.y, factor * (1.0 - slope.y * slope.y)});
    }
    if (turn_row_ < count()) base.gradient[tip.angle] += multipliers[turn_row_];
  }

 private:
  Vec2 from_target() const {
    const BaseIndex::Point& tip = d_.base.index.tip;
    const Eigen::VectorXd& base = d_.base.values.base;
    return Vec2{base[tip.x], base[tip.y]} - d_.spec.target.position;
  }
  double rounded(Vec2 off) const { return std::hypot(norm(off), position_); }

  PoseState& d_;
  double position_, angle_;
  int turn_row_;  ///< row of the angle
};

}  // namespace

std::unique_ptr<RowBlock> target_rows(PoseState& state) { return std::make_unique<TargetRows>(state); }

}  // namespace tendril
