#include <string>

#include "tendril/plugin.hpp"
#include "tendril/weight_matrix.hpp"

namespace {

using namespace tendril;

/// u^T R u over the moments of each finger (paper, Eq. 5).
class ActuationEffort : public ObjectiveBase<ActuationEffort> {
 public:
  explicit ActuationEffort(const NumberTable& weights) : root_(weight_root(weights, weights.rows, "weights")) {}

  Reads reads() const override { return {.moments = true}; }

  template <class T>
  void operator()(const Quantities<T>& x, Contribution<T>& out) const {
    if (root_.rows == 1) {
      for (const T& moment : x.moments) out.residual(root_(0, 0) * moment);
      return;
    }
    // How many actuators there are is known here at the earliest: a factory does not see the scene.
    if (x.moments.size() != static_cast<std::size_t>(root_.rows)) {
      throw Error("option 'weights' of objective plugin 'actuation_effort': found weights for " +
                  std::to_string(root_.rows) + " actuators; expected " + std::to_string(x.moments.size()));
    }
    add_weighted(root_, x.moments, out);
  }

 private:
  NumberTable root_;
};

}  // namespace

TENDRIL_PLUGIN(registrar) {
  const OptionSchema options{{.name = "weights",
                              .type = OptionType::matrix,
                              .default_value = NumberTable{1, 1, {1.0}},
                              .description = "R: a number, one weight for each actuator, or a matrix"}};
  registrar.add(ObjectiveComponent{"actuation_effort", "small moments: u^T R u", options, [](const Options& given) {
                                     return std::make_unique<ActuationEffort>(given.table("weights"));
                                   }});
}
