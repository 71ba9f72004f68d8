#include "statics/load_path.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tendril {

LoadPath::LoadPath(Rod rod, const std::vector<const Obstacle*>& obstacles, Ends ends)
    : rod_(std::move(rod)), obstacles_(obstacles), ends_(std::move(ends)), shrink_(obstacles.size(), 0.0) {
  // What is held is given: no limit applies, and a limit of zero must not remove an actuator.
  for (Rod::Actuator& a : rod_.actuators) {
    a.minimum = -infinity;
    a.maximum = infinity;
    a.by_length = a.by_length && ends_.holds_lengths;
    a.least_shortening = 0.0;  // than what is held: it may be slack
    a.most_shortening = infinity;
  }
}

Loads LoadPath::loads(double load) const {
  const double share = ends_.loads_grow ? load : 1.0;
  Loads now{share * rod_.gravity, share * rod_.tip_force, shrink_, share};
  for (double& by : now.shrink) by *= 1.0 - load;
  now.friction = friction_;
  for (std::size_t o = 0; o < now.friction.size(); ++o) {
    now.friction[o] = (1.0 - load) * first_friction_[o] + load * friction_[o];
  }
  for (std::size_t a = 0; a < rod_.actuators.size(); ++a) {
    if (holds_length(a)) now.shortening.push_back(held(a, load));
  }
  return now;
}

double LoadPath::weight() const {
  constexpr double least = 0.01;
  double largest = has_friction() && ends_.first == ends_.last && !ends_.loads_grow ? 0.0 : 1.0;
  for (const double ratio : friction_) largest = std::max(largest, std::abs(ratio));
  for (const double by : shrink_) largest = by != 0.0 ? 1.0 : largest;
  return std::clamp(largest * largest, least, 1.0);
}

}  // namespace tendril
