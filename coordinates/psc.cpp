#include "tendril/plugin.hpp"

/// Piecewise smooth curvature: the paper's Table I, right column.
TENDRIL_PLUGIN(registrar) {
  using namespace tendril;
  registrar.add(CoordinateComponent{
      "psc", "piecewise smooth curvature: three Legendre functions (Table I)", {}, [](const Options&) {
        constexpr int order = 3;
        return std::make_unique<LegendreBasis>(order);
      }});
}
