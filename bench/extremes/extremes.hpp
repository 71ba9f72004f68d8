#pragma once

#include <vector>

#include "common/extent.hpp"
#include "common/section.hpp"
#include "extremes/row.hpp"
#include "tendril/plugins/registry.hpp"

namespace tendril::bench {

/// Loads at which a rod loses its stability, by the certificate at the critical state; what a basis costs in digits.
std::vector<ExtremeRow> instability_rows(plugins::Registry& registry, const Extent& extent);
std::vector<ExtremeRow> conditioning_rows(plugins::Registry& registry, const Extent& extent);

/// All rows. Stops early if the extent says so.
std::vector<ExtremeRow> extreme_rows(plugins::Registry& registry, const Extent& extent, std::vector<LeftOut>& left_out);

Section extremes_section(plugins::Registry& registry, const Extent& extent);

}  // namespace tendril::bench
