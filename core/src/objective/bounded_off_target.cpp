#include "tendril/bounded_off_target.hpp"

namespace tendril {

BoundedOffTarget::~BoundedOffTarget() = default;

}  // namespace tendril
