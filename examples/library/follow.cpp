// Leads the tip along a line, fifty times a second, each plan from the one before. Argument: a solver.
#include <chrono>
#include <cstdio>
#include <thread>

#include "tendril/plugins/components.hpp"

using namespace tendril;

Scene arm(const char* solver) {
  Scene scene;
  scene.gravity = Vec2{0.0, -9.81};
  scene.rod.segments = {{.length = 0.1, .bending_stiffness = 4.9e-4, .linear_density = 0.084}};
  scene.rod.actuators = {{.from = 0.0, .to = 0.1, .minimum = -5e-3, .maximum = 5e-3}};
  scene.coordinates.plugin = "legendre";
  scene.target.position = Vec2{0.097, 0.0};
  scene.objectives = {{.plugin = "tip_pose", .weight = 100.0}, {.plugin = "actuation_effort", .weight = 1e-4}};
  scene.solver.plugin = solver;
  return scene;
}

int main(int argc, char** argv) {
  const Scene scene = arm(argc > 1 ? argv[1] : "nlopt");
  try {
    validate(scene);
    plugins::Registry registry{plugins::Catalog(plugins::search_places({}))};
    Problem problem(scene, plugins::make_components(registry, scene));
    Plan last = problem.plan();
    int solved = 0, without_solver = 0;
    double longest = 0.0;
    constexpr int steps = 50;
    auto next = std::chrono::steady_clock::now();
    for (int step = 1; step <= steps; ++step) {
      const auto begin = std::chrono::steady_clock::now();
      problem.follow({.position = Vec2{0.097, 0.02 * step / steps}, .angle = {}}, last);  // from and into `last`
      const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
      longest = std::max(longest, taken.count());
      solved += last.status == PlanStatus::solved ? 1 : 0;
      without_solver += last.solver.iterations == 0 ? 1 : 0;
      std::this_thread::sleep_until(next += std::chrono::milliseconds(20));
    }
    std::printf("%d of %d steps solved, %d by Newton alone, longest %.2f ms\n", solved, steps, without_solver,
                1e3 * longest);
    return solved == steps ? 0 : 1;
  } catch (const Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
