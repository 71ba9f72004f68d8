#pragma once

#include <vector>

#include "common/extent.hpp"
#include "common/section.hpp"
#include "tendril/plugins/registry.hpp"

namespace tendril::bench {

/// A part of the bench that stands by itself: a command of tendril-bench and one or more sections of the report. What
/// the recommendation draws on (accuracy, solvers) is not among them.
struct Part {
  const char* name;         ///< of the command
  const char* description;  ///< for --help
  std::vector<Section> (*run)(plugins::Registry& registry, const Extent& extent);
};

/// In the order of the report. A further part needs a line here and nothing else.
const std::vector<Part>& parts();

}  // namespace tendril::bench
