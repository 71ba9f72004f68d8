#pragma once

#include "common/extent.hpp"
#include "common/section.hpp"
#include "tendril/plugins/registry.hpp"

namespace tendril::bench {

/// What a plan, a followed step and a certificate cost, in units of one evaluation that is measured in the same run.
Section speed_section(plugins::Registry& registry, const Extent& extent);

}  // namespace tendril::bench
