// What tendons are shorter by (model.md section 10), over the size of their largest offsets, less what is held.

#include "program/row_block.hpp"

namespace tendril {
namespace {

class ShorteningRows : public RowBlock {
 public:
  explicit ShorteningRows(PoseState& state)
      : RowBlock("shortening", state.layout.first_shortening, state.layout.shortenings), d_(state) {
    for (const BaseIndex::Tendon& t : d_.base.index.tendons) {
      const Rod::Actuator& actuator = d_.spec.rod->actuators[static_cast<std::size_t>(t.actuator)];
      if (actuator.limits_length()) tendons_.push_back({actuator, t.turn});
    }
  }

  void bounds(VectorRef lower, VectorRef upper) const override {
    for (int i = 0; i < count(); ++i) {
      lower[i] = at(i).actuator.least_shortening;
      upper[i] = at(i).actuator.most_shortening;
    }
  }

  void evaluate(ConstVectorRef /*x*/, bool derivatives, VectorRef values, MatrixRef rows) override {
    for (int i = 0; i < count(); ++i) {
      const double side = at(i).actuator.side();
      const double held = d_.loads.shortening.empty() ? 0.0 : d_.loads.shortening[static_cast<std::size_t>(i)];
      values[i] = side * d_.base.values.base[at(i).turn] - held;
      if (derivatives) rows.row(i) = side * d_.base.row(at(i).turn);
    }
  }

  void add_second(ConstVectorRef multipliers, Eigen::MatrixXd& /*hessian*/) override {
    for (int i = 0; i < count(); ++i) d_.base.gradient[at(i).turn] += at(i).actuator.side() * multipliers[i];
  }

 private:
  struct Tendon {
    const Rod::Actuator& actuator;
    int turn;  ///< base quantity
  };
  const Tendon& at(int i) const { return tendons_[static_cast<std::size_t>(i)]; }

  PoseState& d_;
  std::vector<Tendon> tendons_;
};

}  // namespace

std::unique_ptr<RowBlock> shortening_rows(PoseState& state) { return std::make_unique<ShorteningRows>(state); }

}  // namespace tendril
