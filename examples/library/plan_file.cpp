// Plans a scene file as the command does, with one key changed, and writes the result as JSON. Arguments: a scene, and
// optionally a solver.
#include <cstdio>
#include <fstream>

#include "tendril/files/scene_file.hpp"

int main(int argc, char** argv) {
  using namespace tendril;
  try {
    files::SceneSource source{argc > 1 ? argv[1] : "scene.toml"};
    source.settings = {{"contact.max_force", "2 N"}};
    if (argc > 2) source.settings.push_back({"solver.plugin", argv[2]});
    files::SceneFile file(source);
    const Plan plan = file.plan({}, true);
    std::ofstream("plan.json") << file.json(plan);
    const Execution execution = file.execute({files::InputKind::moments, "2.5 N mm"});
    std::printf("%s, tip at %.3f mm; under 2.5 N mm at %.3f mm\n", std::string(to_string(plan.status)).c_str(),
                1e3 * plan.tip_y, 1e3 * execution.result.tip_y);
    const Plan again = file.plan({nullptr, files::ResultText{file.json(plan)}});
    return plan.status == PlanStatus::solved && again.status == PlanStatus::solved ? 0 : 1;
  } catch (const Error& error) {  // the message names file, line and column
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
