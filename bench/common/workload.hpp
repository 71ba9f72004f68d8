#pragma once

#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include "tendril/plan.hpp"
#include "tendril/plugins/registry.hpp"
#include "tendril/problem.hpp"
#include "tendril/scene.hpp"

namespace tendril::bench {

/// An arithmetic sequence of lengths, "91 mm:99 mm:5": first, last, count.
std::vector<double> read_lengths(const std::string& text, const QuantityReader& read);

inline constexpr double pi = std::numbers::pi;

/// Uniform numbers from a seed, the same on every platform.
class Uniform {
 public:
  explicit Uniform(std::uint64_t seed) : state_(seed) {}
  /// In [low, high).
  double operator()(double low, double high);

 private:
  std::uint64_t state_;
};

/// A shape to start from: curvature over the arc length is a parabola with random coefficients, the tip is turned by up
/// to 2 rad either way. Knows neither moments nor contacts.
Plan random_start(Uniform& random, double length);

/// On which side of every obstacle the rod passes it: '+' to the left of its reference point (seen along the rod), '-'
/// to the right. One character per obstacle. `references` in m.
std::string sides(const Plan& plan, const std::vector<Vec2>& references);

double now();  ///< s, of a clock that never goes back
/// s that this process had a processor. Plans use one thread, so on a quiet machine it runs as fast as now(); what
/// other programs do hardly shows in it.
double processor_now();

/// How fast the machine is while something is measured: processor times of one fixed piece of arithmetic (sines and
/// cosines, a factorization of 24 by 24), about a third of a millisecond. Its changes between two reports are the
/// machine's doing: another clock, a neighbour in the cache.
class Pace {
 public:
  void beat();
  const std::vector<double>& seconds() const { return seconds_; }

 private:
  std::vector<double> seconds_;
  double kept_ = 0.0;  ///< the results are used, so that none is optimized away
};

/// A plan and what it took.
struct TimedPlan {
  Plan plan;
  double seconds = 0.0;     ///< processor time: making the components of opened plugins, assembling, planning
  double evaluating = 0.0;  ///< wall time, inside programs while a solver ran
  int solves = 0, iterations = 0;
  std::int64_t evaluations = 0;  ///< of values inside the solves
};
TimedPlan timed_plan(plugins::Registry& registry, const Scene& scene, const PlanControl& control = {});

/// The way of being in contact whose plan was taken; null: none was certified.
const ModeRecord* winning_mode(const Plan& plan);

/// An integer option of a coordinate plugin that counts something (its least value is 1 or more), and values to try.
struct ModelSweep {
  std::string plugin, option;  ///< option empty: the plugin has none
  std::vector<int> values;     ///< {0} if it has none
  bool split = true;
  std::string name() const;
};
/// Every coordinate plugin that is found, split at contacts and not. Plugins that cannot be opened are left out.
std::vector<ModelSweep> model_sweeps(plugins::Registry& registry, const std::vector<int>& values,
                                     std::vector<LeftOut>& left_out);
/// The scene planned with one value of a sweep.
Scene with_model(Scene scene, const ModelSweep& sweep, int value);

/// Coordinates in the largest program of a scene, without solving it.
int coordinate_count(plugins::Registry& registry, const Scene& scene);

}  // namespace tendril::bench
