#include "tendril/plugin.hpp"

namespace {

using namespace tendril;

/// How far the tensions of tendons are from one that is wanted, or from their mean: the sum of squares, EI/L^2.
class TendonTension : public ObjectiveBase<TendonTension> {
 public:
  TendonTension(double wanted, bool equal) : wanted_(wanted), equal_(equal) {}

  Reads reads() const override { return {.tensions = true}; }

  template <class T>
  void operator()(const Quantities<T>& x, Contribution<T>& out) const {
    T from{wanted_};
    if (equal_ && !x.tensions.empty()) {
      from = T{};
      for (const T& tension : x.tensions) from += tension;
      from = from / static_cast<double>(x.tensions.size());
    }
    for (const T& tension : x.tensions) out.residual(tension - from);
  }

 private:
  double wanted_;
  bool equal_;
};

}  // namespace

TENDRIL_PLUGIN(registrar) {
  const OptionSchema options{{.name = "wanted",
                              .type = OptionType::real,
                              .default_value = 0.0,
                              .description = "tension that every tendon should have",
                              .minimum = 0.0,
                              .dimension = dimension::force},
                             {.name = "equal",
                              .type = OptionType::boolean,
                              .default_value = false,
                              .description = "instead, all tendons should pull alike"}};
  registrar.add(ObjectiveComponent{
      "tendon_tension", "tensions of tendons near one that is wanted, or alike", options, [](const Options& given) {
        return std::make_unique<TendonTension>(given.real("wanted"), given.boolean("equal"));
      }});
}
