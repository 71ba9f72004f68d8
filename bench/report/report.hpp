#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "common/extent.hpp"
#include "report/accuracy.hpp"
#include "report/solver_comparison.hpp"

namespace tendril::bench {

AccuracySetup accuracy_setup(const plugins::Registry& registry, const Extent& extent);
/// Its contestants are those that can solve something; what was left out is added to `left_out`.
SolverComparisonSetup solver_setup(plugins::Registry& registry, const Extent& extent, std::vector<LeftOut>& left_out);
std::vector<double> tolerance_values(const Extent& extent);

struct ReportArguments {
  std::filesystem::path directory;
  Extent extent;
  std::optional<std::filesystem::path> against;  ///< another report's directory
};

/// Everything, as report.html (self-contained), report.md, report.json, and the files of each section. False if it was
/// interrupted, in which case nothing is written. Throws InputError.
bool write_report(plugins::Registry& registry, const ReportArguments& arguments);

}  // namespace tendril::bench
