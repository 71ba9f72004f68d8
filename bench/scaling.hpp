#pragma once

#include <atomic>
#include <vector>

#include "scenes.hpp"
#include "section.hpp"

namespace tendril::bench {

struct ScalingSetup {
  std::vector<int> values;  ///< of every option that is swept, and of check points
  int most_coordinates = 0;
  int most_obstacles = 32;
  int repetitions = 20;
  const std::atomic<bool>* stop = nullptr;
};

/// Time of an evaluation and of a plan over the size of what is asked for, with measured exponents.
Section scaling_section(plugins::Registry& registry, const ScalingSetup& setup);

}  // namespace tendril::bench
