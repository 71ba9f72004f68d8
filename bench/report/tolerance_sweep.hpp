#pragma once

#include <vector>

#include "common/scenes.hpp"
#include "common/section.hpp"
#include "report/solver_comparison.hpp"

namespace tendril::bench {

/// What each solver itself reaches at each tolerance, before the polish, and in what time: error against time per
/// solver. Contestants that differ from their solver in a treatment or an option take no part.
Section tolerance_section(plugins::Registry& registry, const SolverComparisonSetup& setup, const BenchScene& scene,
                          const std::vector<double>& tolerances);

}  // namespace tendril::bench
