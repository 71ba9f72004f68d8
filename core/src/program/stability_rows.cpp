// The margin of stability stays up.

#include "program/margin_row.hpp"
#include "program/row_block.hpp"

namespace tendril {
namespace {

class StabilityRows : public RowBlock {
 public:
  explicit StabilityRows(const PoseState& state)
      : RowBlock("stability", state.layout.first_margin, 1, *state.spec.least_margin, infinity),
        d_(state),
        row_(state.spec) {}

  void evaluate(ConstVectorRef x, bool derivatives, VectorRef values, MatrixRef rows) override {
    row_.set_loads(d_.loads);
    values[0] = derivatives ? row_.differentiate(x) : row_.value(x);
    if (derivatives) rows.row(0) = row_.gradient().transpose();
  }

  void add_second(ConstVectorRef multipliers, Eigen::MatrixXd& hessian) override {
    if (multipliers[0] != 0.0) hessian += multipliers[0] * row_.hessian();
  }

 private:
  const PoseState& d_;
  MarginRow row_;
};

}  // namespace

std::unique_ptr<RowBlock> stability_rows(PoseState& state) { return std::make_unique<StabilityRows>(state); }

}  // namespace tendril
