#include "support.hpp"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>

#include "tendril/app/document.hpp"
#include "tendril/app/scene_reader.hpp"

namespace tendril::combination {

namespace {

struct Found {
  std::vector<std::filesystem::path> directories;
  std::vector<std::string> solvers;
  std::optional<plugins::Registry> registry;
};

Found& found() {
  static Found instance;
  return instance;
}

Scene read(app::Document document, const std::vector<std::string>& overrides) {
  // How busy the machine is decides nothing.
  std::vector<app::Override> settings{{"solver.time_limit=36000", "solver.time_limit", "36000"}};
  for (const std::string& text : overrides) {
    const std::size_t equals = text.find('=');
    settings.push_back({text, text.substr(0, equals), text.substr(equals + 1)});
  }
  document.apply(settings);
  Scene scene = app::read_scene(document, std::make_shared<app::Units>());
  // Text that names no solver gets the command's default, which this build may have left out.
  const std::vector<std::string> solvers = registry().names(ComponentKind::solver);
  if (std::find(solvers.begin(), solvers.end(), scene.solver.plugin) == solvers.end()) {
    scene.solver.plugin = TENDRIL_TEST_SOLVER;
  }
  return scene;
}

}  // namespace

void find_plugins(std::vector<std::string>& arguments) {
  std::vector<std::string> rest;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    if (arguments[i] == "--plugin-dir" && i + 1 < arguments.size()) {
      found().directories.emplace_back(arguments[++i]);
    } else if (arguments[i] == "--solver" && i + 1 < arguments.size()) {
      found().solvers.push_back(arguments[++i]);
    } else {
      rest.push_back(arguments[i]);
    }
  }
  arguments = rest;
  found().registry.emplace(fresh_registry());
}

plugins::Registry& registry() { return *found().registry; }

plugins::Registry fresh_registry() {
  return plugins::Registry(plugins::Catalog(plugins::search_places(found().directories)));
}

std::vector<std::string> solvers_to_combine() {
  return found().solvers.empty() ? registry().names(ComponentKind::solver) : found().solvers;
}

Scene scene(const std::string& name, const std::vector<std::string>& overrides) {
  return read(app::Document::read(std::filesystem::path(TENDRIL_SCENES) / (name + ".toml")), overrides);
}

Scene scene_from_text(const std::string& text, const std::vector<std::string>& overrides) {
  return read(app::Document::parse(text, "test.toml"), overrides);
}

Problem problem(const Scene& scene, plugins::Registry& from) {
  return Problem(scene, plugins::make_components(from, scene));
}

Plan plan(const Scene& scene, const PlanControl& control) { return problem(scene).plan(control); }

Plan plan_with(Scene scene, const std::string& solver) {
  scene.solver.plugin = solver;
  return plan(scene);
}

testing::AssertionResult certified(const Plan& plan) {
  if (plan.status == PlanStatus::solved && plan.certificate.valid()) return testing::AssertionSuccess();
  auto failure = testing::AssertionFailure();
  failure << to_string(plan.status) << ": " << plan.message;
  for (const std::string& line : plan.certificate.failures) failure << "\n  " << line;
  for (const ModeRecord& mode : plan.modes) failure << "\n  " << mode.mode << ": " << mode.outcome;
  return failure;
}

}  // namespace tendril::combination
