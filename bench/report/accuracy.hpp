#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "common/scenes.hpp"
#include "common/section.hpp"
#include "common/statistics.hpp"
#include "common/workload.hpp"

namespace tendril::bench {

struct AccuracySetup {
  std::vector<KnownScene> scenes;
  std::vector<int> values;   ///< of every option that is swept
  int repetitions = 20;      ///< interleaved over all models
  int most_coordinates = 0;  ///< larger programs are left out
  int compared = 0;          ///< up to this many coordinates, every solver plans each model
  const std::atomic<bool>* stop = nullptr;
};

/// One model on one scene.
struct AccuracyPoint {
  std::size_t scene = 0, sweep = 0;
  int value = 0, coordinates = 0;
  /// Of the model, against the fine reference at the plan's own moment: tips in L, places in L, forces relative.
  double tip = 0.0, place = 0.0, force = 0.0;
  double solvers_differ = 0.0;  ///< largest distance of the tips of two solvers on this model, L; NaN: one solver only
  Quartiles seconds, evaluating;
  int solves = 0, iterations = 0;
  std::int64_t evaluations = 0;
  bool repeatable = true;        ///< iterations and evaluations were the same each time
  bool at_known_moment = false;  ///< the plan's moment is that of the exact table
};

/// The fine reference of a scene, and what is known of it.
struct AccuracyReference {
  double bound = 0.0;     ///< on its tip, L: what the local moment balance leaves
  double to_table = 0.0;  ///< distance of its tip from the exact table, L; NaN: planned at another moment
};

/// How the error of one model falls.
struct ConvergenceOrder {
  std::size_t scene = 0, sweep = 0;
  bool exponential = false;
  Line line;  ///< slope: exponent of a power, or decades per unit
  int from = 0, to = 0;
};

struct Accuracy {
  std::vector<ModelSweep> sweeps;
  std::vector<AccuracyReference> references;
  std::vector<AccuracyPoint> points;
  std::vector<ConvergenceOrder> orders;
  std::vector<double> pace;  ///< s, one beat beside every plan
  std::vector<LeftOut> left_out;
};

Accuracy measure_accuracy(plugins::Registry& registry, const AccuracySetup& setup);

/// A model over all scenes.
struct ModelChoice {
  std::size_t sweep = 0;
  int value = 0, coordinates = 0;
  double error = 0.0;    ///< largest over the scenes
  double seconds = 0.0;  ///< sum over the scenes
};
/// Every model that was certified on all scenes, cheapest first.
std::vector<ModelChoice> model_choices(const Accuracy& accuracy, std::size_t scenes);

Section accuracy_section(const AccuracySetup& setup, const Accuracy& accuracy);

}  // namespace tendril::bench
