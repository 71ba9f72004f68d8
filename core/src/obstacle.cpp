#include "tendril/obstacle.hpp"

namespace tendril {

Obstacle::~Obstacle() = default;

}  // namespace tendril
