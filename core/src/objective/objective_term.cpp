#include "tendril/objective_term.hpp"

namespace tendril {

ObjectiveTerm::~ObjectiveTerm() = default;

double ObjectiveTerm::lower_bound() const { return 0.0; }

}  // namespace tendril
