#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <exception>
#include <memory>

#include "solver_comparison.hpp"
#include "tendril/app/document.hpp"
#include "tendril/app/files.hpp"
#include "tendril/app/interrupt.hpp"
#include "tendril/app/scene_reader.hpp"
#include "tendril/planner.hpp"
#include "tendril/version.hpp"
#include "workload.hpp"

namespace {

using namespace tendril;

struct SolverOptions {
  std::string scene, targets_x, targets_y, output;
  std::vector<std::string> limits, solvers, plugin_directories, settings;
  int starts = 0;
  std::uint64_t seed = 1;
};

Scene read(const SolverOptions& options) {
  app::Document document = app::Document::read(options.scene);
  std::vector<app::Override> overrides;
  for (const std::string& text : options.settings) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos) throw Error("--set " + text + ": expected KEY=VALUE");
    overrides.push_back({"--set " + text, text.substr(0, equals), text.substr(equals + 1)});
  }
  document.apply(overrides);
  Scene scene = app::read_scene(document, std::make_shared<app::Units>());
  validate(scene);
  return scene;
}

int compare(const SolverOptions& options) {
  bench::SolverComparisonSetup setup;
  setup.scene = read(options);
  plugins::Registry registry(plugins::Catalog(plugins::search_places(
      std::vector<std::filesystem::path>(options.plugin_directories.begin(), options.plugin_directories.end()))));
  setup.solvers = options.solvers.empty() ? registry.names(ComponentKind::solver) : options.solvers;
  for (const std::string& solver : setup.solvers) (void)registry.solver(solver);
  if (options.targets_x.empty() != options.targets_y.empty()) throw Error("--targets-x and --targets-y go together");
  if (!options.targets_x.empty()) {
    for (const double x : bench::read_lengths(options.targets_x, setup.scene.read_quantity)) {
      for (const double y : bench::read_lengths(options.targets_y, setup.scene.read_quantity)) {
        setup.targets.push_back({x, y});
      }
    }
  }
  for (const std::string& limit : options.limits) {
    setup.limits.push_back(setup.scene.read_quantity(limit, dimension::moment));
  }
  setup.starts = options.starts;
  setup.seed = options.seed;
  const app::InterruptGuard interrupt;
  setup.stop = &app::InterruptGuard::flag();
  const std::vector<bench::SolverRun> runs = bench::compare_solvers(registry, setup);
  const std::string head = fmt::format("{} plans, {} starts per target, seed {}, tendril {}\n\n", runs.size(),
                                       options.starts > 0 ? std::to_string(options.starts) + " random" : "the scene's",
                                       options.seed, TENDRIL_VERSION);
  const std::string table = head + bench::solver_table(setup, runs);
  fmt::print("{}", table);
  if (!options.output.empty()) {
    app::StagedFiles files(options.output);
    files.write("solvers.md", table);
    files.write("solvers.csv", bench::solver_csv(setup, runs));
    files.publish();
  }
  return app::InterruptGuard::flag().load() ? 1 : 0;
}

int run(int argc, char** argv) {
  CLI::App program("Compares what tendril is made of by error, effort and success.", "tendril-bench");
  program.require_subcommand(1);
  program.set_version_flag("--version", TENDRIL_VERSION);
  SolverOptions options;
  CLI::App* solvers = program.add_subcommand("solvers", "Every solver on the same targets, limits and starts");
  solvers->add_option("SCENE", options.scene, "Scene file (TOML)")->required();
  const auto list = [&](const char* name, std::vector<std::string>& to, const char* description) {
    return solvers->add_option(name, to, description)->expected(1)->take_all();
  };
  solvers->add_option("--targets-x", options.targets_x, "First, last, count, for instance \"91 mm:99 mm:5\"");
  solvers->add_option("--targets-y", options.targets_y, "The same for y");
  list("--limit", options.limits, "Limit of every actuator's moment; may be repeated");
  list("--solver", options.solvers, "Solver to compare, by default every one found; may be repeated");
  list("--plugin-dir", options.plugin_directories, "Directory to search for plugins first; may be repeated");
  list("--set", options.settings, "Sets a key of the scene: KEY=VALUE");
  solvers->add_option("--starts", options.starts, "Random starts per target; 0: the scene's own")
      ->check(CLI::Range(0, 100000));
  solvers->add_option("--seed", options.seed, "Seed of the random starts");
  solvers->add_option("--output", options.output, "Directory for solvers.md and solvers.csv");
  try {
    program.parse(argc, argv);
    return compare(options);
  } catch (const CLI::Success& message) {
    return program.exit(message);
  } catch (const CLI::ParseError& error) {
    fmt::print(stderr, "tendril-bench: {}\n", error.what());
    return 2;
  }
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "tendril-bench: %s\n", error.what());
    return 2;
  }
}
