#pragma once

#include "base/clock.hpp"
#include "search/task.hpp"

namespace tendril {

/// Another value for a while: the task keeps its own, whatever a solver throws.
template <class T>
struct Kept {
  T& of;
  const T own = of;
  ~Kept() { of = own; }
};

/// One time limit for several searches.
struct Limit {
  explicit Limit(Task& task) : limit{task.scene.solver.time_limit} {}
  Kept<double> limit;
  const double begin = now();
  /// What is left of it is the limit from now on.
  bool leaves_time() {
    limit.of = limit.own - (now() - begin);
    return limit.of > 0.0;
  }
};

}  // namespace tendril
