#pragma once

#include <string>

#include "common/section.hpp"
#include "report/accuracy.hpp"
#include "report/solver_comparison.hpp"

namespace tendril::bench {

/// Which coordinates, order, solver and treatment the numbers speak for, and whether `tendril plan` takes these where a
/// scene names none.
struct Recommendation {
  ModelSweep model;
  int value = 0;
  Contestant contestant;
  bool model_is_default = false, solver_is_default = false, treatment_is_default = false;
  bool contestant_is_default() const { return solver_is_default && treatment_is_default; }
  bool found = false;  ///< false: no model meets the goal on all scenes, or nobody was certified
};

Recommendation recommend(plugins::Registry& registry, const AccuracySetup& accuracy_setup, const Accuracy& accuracy,
                         const SolverComparisonSetup& solver_setup, const SolverComparison& comparison);

Section recommendation_section(const Recommendation& recommendation, const AccuracySetup& accuracy_setup,
                               const Accuracy& accuracy, const SolverComparisonSetup& solver_setup,
                               const SolverComparison& comparison);

}  // namespace tendril::bench
