#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "accuracy.hpp"
#include "lean.hpp"
#include "scaling.hpp"
#include "section.hpp"
#include "solver_comparison.hpp"

namespace tendril::bench {

/// How much is measured. `quick` finishes in well under two minutes and shows that everything works; its numbers decide
/// nothing.
struct Extent {
  bool quick = false;
  int repetitions = 0;  ///< 0: as the extent has it
  std::uint64_t seed = 1;
  const std::atomic<bool>* stop = nullptr;
};

AccuracySetup accuracy_setup(const plugins::Registry& registry, const Extent& extent);
/// Its contestants are those that can solve something; what was left out is added to `left_out`.
SolverComparisonSetup solver_setup(plugins::Registry& registry, const Extent& extent, std::vector<LeftOut>& left_out);
LeanSetup lean_setup(const Extent& extent);
ScalingSetup scaling_setup(const Extent& extent);
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
