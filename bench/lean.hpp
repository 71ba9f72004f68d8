#pragma once

#include <atomic>

#include "scenes.hpp"
#include "section.hpp"

namespace tendril::bench {

struct LeanSetup {
  int repetitions = 20;
  const std::atomic<bool>* stop = nullptr;
};

/// What a scene pays for what it does not use. Every objective that is found takes part where everything is carried, if
/// it can be had without options.
Section lean_section(const plugins::Registry& registry, const LeanSetup& setup);

}  // namespace tendril::bench
