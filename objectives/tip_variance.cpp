#include "tendril/plugin.hpp"

namespace {

using namespace tendril;

/// How far the tip is from where it is predicted to be: the variance of its place under held moments, to first order,
/// from the error bars of the scene.
class TipVariance : public ObjectiveBase<TipVariance> {
 public:
  Reads reads() const override { return {.tip_deviations = true}; }

  template <class T>
  void operator()(const Quantities<T>& x, Contribution<T>& out) const {
    for (const TipDeviation<T>& one : x.tip_deviations) {
      out.residual(one.x);
      out.residual(one.y);
    }
  }
};

}  // namespace

TENDRIL_PLUGIN(registrar) {
  registrar.add(ObjectiveComponent{"tip_variance",
                                   "a tip whose place is known well: its variance under the error bars of the scene",
                                   {},
                                   [](const Options&) { return std::make_unique<TipVariance>(); }});
}
