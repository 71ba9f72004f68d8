#include "tendril/plugin.hpp"

int tendril_test_absent();

TENDRIL_PLUGIN(registrar) {
  registrar.add(tendril::SolverComponent{"incomplete", "needs a library that is not there", {}, [](const auto&) {
                                           tendril_test_absent();
                                           return nullptr;
                                         }});
}
