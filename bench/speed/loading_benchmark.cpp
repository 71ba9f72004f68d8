// What it costs to begin: opening a plugin for the first time, making a component of an opened one, reading a scene.

#include <benchmark/benchmark.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <memory>
#include <string>

#include "common/scenes.hpp"
#include "common/workload.hpp"
#include "tendril/app/document.hpp"
#include "tendril/app/scene_reader.hpp"
#include "tendril/plugins/components.hpp"

namespace {

using namespace tendril;

plugins::Registry registry() { return plugins::Registry(plugins::Catalog(plugins::search_places({}))); }

void open_one(plugins::Registry& in, ComponentKind kind, const std::string& name) {
  if (kind == ComponentKind::coordinates) (void)in.coordinates(name);
  if (kind == ComponentKind::objective) (void)in.objective(name);
  if (kind == ComponentKind::solver) (void)in.solver(name);
}

/// Seconds that a fresh process takes to open one plugin with all libraries it needs; negative: it could not. A library
/// stays in the process that opened it, so each opening needs its own.
double first_opening(ComponentKind kind, const std::string& name) {
  int ends[2];
  if (::pipe(ends) != 0) return -1.0;
  const pid_t child = ::fork();
  if (child == 0) {
    double seconds = -1.0;
    try {
      plugins::Registry fresh = registry();
      const double begin = bench::now();
      open_one(fresh, kind, name);
      seconds = bench::now() - begin;
    } catch (const Error& error) {
      std::fprintf(stderr, "%s\n", error.what());
    }
    ::_exit(::write(ends[1], &seconds, sizeof seconds) == sizeof seconds ? 0 : 1);
  }
  ::close(ends[1]);
  double seconds = -1.0;
  if (child < 0 || ::read(ends[0], &seconds, sizeof seconds) != sizeof seconds) seconds = -1.0;
  ::close(ends[0]);
  if (child > 0) ::waitpid(child, nullptr, 0);
  return seconds;
}

void opening(benchmark::State& state, ComponentKind kind, const std::string& name) {
  for (auto _ : state) {
    const double seconds = first_opening(kind, name);
    if (seconds < 0.0) {
      state.SkipWithError("the plugin could not be opened");
      break;
    }
    state.SetIterationTime(seconds);
  }
}

/// Listing what is there opens nothing.
void catalog(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(registry().names(ComponentKind::solver).size());
}
BENCHMARK(catalog);

std::string example() {
  return bench::gravity() + bench::arm("2.5 N mm") + bench::peg() +
         "[contact]\nmode = \"allow\"\nmax_force = \"1 N\"\n" + "[target]\nposition = [\"97 mm\", \"20 mm\"]\n" +
         bench::objectives();
}

/// From text to a scene in SI. Units are read once per process, from a database.
void scene_reading(benchmark::State& state) {
  const std::string text = example();
  const auto units = std::make_shared<app::Units>();
  for (auto _ : state) {
    benchmark::DoNotOptimize(app::read_scene(app::Document::parse(text, "scene"), units).obstacles.data());
  }
}
BENCHMARK(scene_reading);

/// The first scene of a process, with the database of units.
void first_scene_reading(benchmark::State& state) {
  const std::string text = example();
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        app::read_scene(app::Document::parse(text, "scene"), std::make_shared<app::Units>()).obstacles.data());
  }
}
BENCHMARK(first_scene_reading);

/// Components of plugins that are open already, and the program they make.
void component_making(benchmark::State& state) {
  plugins::Registry opened = registry();
  const Scene scene = bench::scene_from_text(example(), "example", opened);
  (void)plugins::make_components(opened, scene);
  for (auto _ : state) benchmark::DoNotOptimize(plugins::make_components(opened, scene).solver.get());
}

/// One step of a loop that follows a target by Newton alone, leaning on the peg: certificate and result included.
void followed_step(benchmark::State& state) {
  plugins::Registry opened = registry();
  const Scene scene = bench::scene_from_text(example(), "example", opened);
  Problem problem(scene, plugins::make_components(opened, scene));
  Plan plan = problem.plan();
  Vec2 at = *scene.target.position;
  double flip = 1e-4;
  int solved = 0;
  for (auto _ : state) {
    at.y += (flip = -flip);
    problem.follow({.position = at, .angle = {}}, plan);
    solved += plan.status == PlanStatus::solved && plan.solver.iterations == 0 ? 1 : 0;
  }
  state.counters["followed"] = benchmark::Counter(solved, benchmark::Counter::kAvgIterations);
}

/// Whatever is found takes part. Making components comes last: it opens plugins here, which forked processes inherit.
void register_openings() {
  const plugins::Registry found = registry();
  for (const ComponentKind kind : {ComponentKind::coordinates, ComponentKind::objective, ComponentKind::solver}) {
    for (const std::string& name : found.names(kind)) {
      const std::string title = "opening/" + std::string(to_string(kind)) + "/" + name;
      benchmark::RegisterBenchmark(title.c_str(), opening, kind, name)->UseManualTime()->Iterations(20);
    }
  }
  benchmark::RegisterBenchmark("component_making", component_making);
  benchmark::RegisterBenchmark("followed_step", followed_step);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
    register_openings();
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "tendril-evaluation-benchmark: %s\n", error.what());
    return 2;
  }
  return 0;
}
