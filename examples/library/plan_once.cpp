// Builds the scene of scenes/brace.toml in code, plans, and reads the result. SI units. Argument: a solver.
#include <cstdio>

#include "tendril/plugins/components.hpp"

int main(int argc, char** argv) {
  using namespace tendril;
  const auto number = [](double v) { return RawValue{v}; };
  Scene scene;
  scene.gravity = Vec2{0.0, -9.81};
  scene.rod.segments = {{.length = 0.1, .bending_stiffness = 4.9e-4, .linear_density = 0.084}};
  scene.rod.actuators = {{.from = 0.0, .to = 0.1, .minimum = -2.5e-3, .maximum = 2.5e-3}};
  scene.coordinates.plugin = "legendre";
  scene.start_tip_angle = 0.5;
  scene.obstacles = {
      {"peg", "circle", {{"center", {RawValue::List{number(0.06), number(0.0)}}}, {"radius", number(0.008)}}}};
  scene.target.position = Vec2{0.097, 0.02};
  scene.objectives = {{.plugin = "tip_pose", .weight = 100.0}, {.plugin = "actuation_effort", .weight = 1e-4}};
  scene.solver.plugin = argc > 1 ? argv[1] : "nlopt";
  try {
    validate(scene);
    plugins::Registry registry{plugins::Catalog(plugins::search_places({}))};
    const Plan plan = Problem(scene, plugins::make_components(registry, scene)).plan();
    std::printf("%s, moment %.4f N mm, tip misses by %.4f mm\n", std::string(to_string(plan.status)).c_str(),
                1e3 * plan.moments.at(0), 1e3 * plan.target_error.value());
    for (const PlannedContact& c : plan.contacts) std::printf("%s: %.2f mN\n", c.obstacle_name.c_str(), 1e3 * c.force);
    return plan.status == PlanStatus::solved ? 0 : 1;
  } catch (const Error& error) {  // whatever is wrong with the scene or a plugin, in words
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
