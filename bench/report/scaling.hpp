#pragma once

#include "common/extent.hpp"
#include "common/section.hpp"
#include "tendril/plugins/registry.hpp"

namespace tendril::bench {

/// Time of an evaluation and of a plan over the size of what is asked for (functions and pieces of every coordinate
/// plugin that is found, check points, obstacles, contacts), with measured exponents.
Section scaling_section(plugins::Registry& registry, const Extent& extent);

}  // namespace tendril::bench
