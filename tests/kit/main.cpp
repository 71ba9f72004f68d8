// tendril-check-plugin KIND NAME [--plugin-dir DIRECTORY]... [--scene FILE] [--set KEY=VALUE]... [--time-limit SECONDS]
//
// Opens one plugin as the command does and checks what every component of its kind has to keep. With a scene, the
// component's options are those of the scene, once for each use; without one, the defaults.
// Exit code 0: nothing is wrong; 1: something is, told on standard output, or the plugin does not return within the
// time limit; 2: wrong use, or the plugin cannot be had. A crash names the plugin.

#include <cstdio>
#include <exception>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "checks.hpp"
#include "tendril/app/document.hpp"
#include "tendril/app/scene_reader.hpp"
#include "tendril/plugins/crash.hpp"
#include "tendril/plugins/registry.hpp"
#include "tendril/problem.hpp"

namespace {

using namespace tendril;

struct Arguments {
  std::string kind, name, scene;
  std::vector<std::filesystem::path> plugin_directories;
  std::vector<app::Override> settings;
  unsigned time_limit = 60;  // s
};

Arguments read_arguments(const std::vector<std::string>& words) {
  const std::string usage =
      "usage: tendril-check-plugin coordinates|objective|obstacle NAME [--plugin-dir DIR]... [--scene FILE] [--set "
      "KEY=VALUE]... [--time-limit SECONDS] (solvers: tendril-conformance-tests --solver NAME)";
  Arguments arguments;
  std::vector<std::string> plain;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (!words[i].starts_with("--")) {
      plain.push_back(words[i]);
      continue;
    }
    if (i + 1 == words.size()) throw Error(words[i] + " has no value; " + usage);
    const std::string& value = words[i + 1];
    const std::size_t equals = value.find('=');
    if (words[i] == "--plugin-dir") {
      arguments.plugin_directories.emplace_back(value);
    } else if (words[i] == "--scene") {
      arguments.scene = value;
    } else if (words[i] == "--time-limit" && !value.empty() && value.size() < 6 &&
               value.find_first_not_of("0123456789") == std::string::npos) {
      arguments.time_limit = static_cast<unsigned>(std::stoul(value));
    } else if (words[i] == "--set" && equals != std::string::npos) {
      arguments.settings.push_back({"--set " + value, value.substr(0, equals), value.substr(equals + 1)});
    } else {
      throw Error("found '" + words[i] + " " + value + "'; " + usage);
    }
    ++i;
  }
  if (plain.size() != 2) throw Error(usage);
  arguments.kind = plain[0];
  arguments.name = plain[1];
  return arguments;
}

/// One use of the component: its options, and what surrounds it.
struct Use {
  std::string where;
  RawOptions options;
};

/// The scene around the component; without a file, a rod of unit length and stiffness with two actuators.
Scene surroundings(const Arguments& arguments) {
  if (!arguments.scene.empty()) {
    app::Document document = app::Document::read(arguments.scene);
    document.apply(arguments.settings);
    return app::read_scene(document, std::make_shared<app::Units>());
  }
  if (!arguments.settings.empty()) throw Error("--set changes a key of a scene: give one with --scene FILE");
  Scene scene;
  scene.rod.segments = {{1.0, 1.0, 0.0, 0.0}};
  scene.rod.actuators = {{.from = 0.0, .to = 0.5}, {.from = 0.5, .to = 1.0}};
  scene.target = {Vec2{0.7, 0.4}, 0.6};
  return scene;
}

std::vector<Use> uses(const Arguments& arguments, const Scene& scene) {
  if (arguments.scene.empty()) return {{"default options", {}}};
  std::vector<Use> found;
  const auto add = [&](const std::string& plugin, const std::string& where, const RawOptions& options) {
    if (plugin == arguments.name) found.push_back({arguments.scene + ", " + where, options});
  };
  if (arguments.kind == "coordinates") add(scene.coordinates.plugin, "[coordinates]", scene.coordinates.options);
  if (arguments.kind == "objective") {
    for (std::size_t i = 0; i < scene.objectives.size(); ++i) {
      add(scene.objectives[i].plugin, "objective " + std::to_string(i + 1), scene.objectives[i].options);
    }
  }
  if (arguments.kind == "obstacle") {
    for (const ObstacleSpec& obstacle : scene.obstacles)
      add(obstacle.shape, "'" + obstacle.name + "'", obstacle.options);
  }
  if (found.empty()) {
    throw Error(arguments.scene + " does not use the " + arguments.kind + " '" + arguments.name + "'; expected it to");
  }
  return found;
}

template <class Interface>
std::unique_ptr<Interface> make(const Component<Interface>& component, const RawOptions& options, const Scene& scene) {
  return component.make(
      resolve_options(component.options, options, scale_of(scene), scene.read_quantity, "'" + component.name + "'"));
}

Target target_of(const Scene& scene) {
  const double length = scene.rod.length();
  Target target;
  target.has_position = scene.target.position.has_value();
  target.has_angle = scene.target.angle.has_value();
  if (target.has_position) target.position = (1.0 / length) * *scene.target.position;
  if (target.has_angle) target.angle = *scene.target.angle;
  return target;
}

void check(plugins::Registry& registry, const Arguments& arguments, const Scene& scene, const RawOptions& options,
           kit::Findings& findings) {
  if (arguments.kind == "coordinates") {
    kit::check_coordinates(*make(registry.coordinates(arguments.name), options, scene), findings);
  } else if (arguments.kind == "objective") {
    kit::check_objective(*make(registry.objective(arguments.name), options, scene),
                         static_cast<int>(scene.rod.actuators.size()), target_of(scene), findings);
  } else if (arguments.kind == "obstacle") {
    kit::check_obstacle(*make(registry.obstacle(arguments.name), options, scene), findings);
  } else {
    throw Error("found the kind '" + arguments.kind +
                "'; expected coordinates, objective or obstacle (solvers: tendril-conformance-tests --solver NAME)");
  }
}

int run(const std::vector<std::string>& words) {
  const Arguments arguments = read_arguments(words);
  plugins::name_plugin_in_crashes();
  plugins::end_after(arguments.time_limit);
  plugins::Registry registry{plugins::Catalog(plugins::search_places(arguments.plugin_directories))};
  const Scene scene = surroundings(arguments);
  validate(scene);
  int wrong = 0;
  for (const Use& use : uses(arguments, scene)) {
    kit::Findings findings;
    check(registry, arguments, scene, use.options, findings);
    std::printf(
        "%s '%s' (%s): %s\n%s", arguments.kind.c_str(), arguments.name.c_str(), use.where.c_str(),
        findings.empty() ? ("nothing wrong in " + std::to_string(findings.tested()) + " checks").c_str() : "WRONG",
        findings.text().c_str());
    wrong += findings.empty() ? 0 : 1;
  }
  return wrong == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    std::fprintf(stderr, "tendril-check-plugin: %s\n", error.what());
    return 2;
  }
}
