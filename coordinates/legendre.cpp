#include "tendril/plugin.hpp"

/// Integrated Legendre functions of any order (model.md section 2).
TENDRIL_PLUGIN(registrar) {
  using namespace tendril;
  const OptionSchema options{{.name = "order",
                              .type = OptionType::integer,
                              .default_value = std::int64_t{6},
                              .description = "number of functions on each piece",
                              .minimum = 1,
                              .maximum = LegendreBasis::maximum_order},
                             {.name = "pieces",
                              .type = OptionType::integer,
                              .default_value = std::int64_t{1},
                              .description = "equal pieces between two knots",
                              .minimum = 1,
                              .maximum = 64}};
  registrar.add(CoordinateComponent{"legendre", "smooth curvature: integrated Legendre functions of a chosen order",
                                    options, [](const Options& given) {
                                      return std::make_unique<LegendreBasis>(static_cast<int>(given.integer("order")),
                                                                             static_cast<int>(given.integer("pieces")));
                                    }});
}
