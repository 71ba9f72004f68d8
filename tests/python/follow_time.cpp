// follow_time SCENE STEPS REPEATS: the shortest time, in seconds of this thread, in which the tip follows so many
// targets.

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <iostream>
#include <limits>

#include "tendril/files/scene_file.hpp"

namespace {

double now() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  tendril::files::SceneFile file({argv[1]});
  tendril::Problem& problem = file.problem();
  tendril::Plan plan = problem.plan();
  const int steps = std::atoi(argv[2]);
  double best = std::numeric_limits<double>::infinity();
  for (int repeat = std::atoi(argv[3]); repeat > 0; --repeat) {
    const double begin = now();
    for (int i = 0; i < steps; ++i) {
      tendril::TargetSpec target;
      target.position = tendril::Vec2{0.097, 0.02 - 1e-5 * (i % 100)};
      problem.follow(target, plan);
      if (plan.status != tendril::PlanStatus::solved) return 1;
    }
    best = std::min(best, now() - begin);
  }
  std::cout << best << '\n';
}
