// Contacts that share a stretch keep their order along the rod, behind its port: knots between pieces must not meet.

#include "program/row_block.hpp"

namespace tendril {
namespace {

class OrderRows : public RowBlock {
 public:
  explicit OrderRows(const PoseState& state)
      : RowBlock("contact_order", state.layout.first_order, state.layout.orders, knot_clearance, infinity) {
    for (int k = -1; k < state.layout.arc_lengths; ++k) {
      if (state.ordered(k)) earlier_.push_back(state.layout.first_arc_length + k);
    }
  }

  void evaluate(ConstVectorRef x, bool derivatives, VectorRef values, MatrixRef rows) override {
    for (int i = 0; i < count(); ++i) {
      const int earlier = earlier_[static_cast<std::size_t>(i)];
      values[i] = x[earlier + 1] - x[earlier];
      if (!derivatives) continue;
      rows(i, earlier) = -1.0;
      rows(i, earlier + 1) = 1.0;
    }
  }

 private:
  std::vector<int> earlier_;  ///< variable of the earlier one of each pair; the later one is the next
};

}  // namespace

std::unique_ptr<RowBlock> order_rows(PoseState& state) { return std::make_unique<OrderRows>(state); }

}  // namespace tendril
