#pragma once

#include "common/extent.hpp"
#include "common/section.hpp"
#include "tendril/plugins/registry.hpp"

namespace tendril::bench {

/// What a scene pays for what it does not use. Every objective that is found takes part where everything is carried, if
/// it can be had without options.
Section lean_section(const plugins::Registry& registry, const Extent& extent);

}  // namespace tendril::bench
