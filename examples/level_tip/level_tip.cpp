#include "tendril/plugin.hpp"

struct LevelTip : tendril::ObjectiveBase<LevelTip> {
  tendril::Reads reads() const override { return {.tip_angle = true}; }
  template <class T>
  void operator()(const tendril::Quantities<T>& x, tendril::Contribution<T>& out) const {
    out.residual(x.tip.angle);
  }
};

TENDRIL_PLUGIN(registrar) {
  registrar.add(tendril::ObjectiveComponent{
      "level_tip", "keeps the tip level", {}, [](const tendril::Options&) { return std::make_unique<LevelTip>(); }});
}
