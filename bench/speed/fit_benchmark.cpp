// What fits to measured shapes take, and what error bars add to a plan: a calibration of 200 shapes with five unknowns,
// frames of a sequence, and derivatives of a plan by two numbers that are known to a standard deviation only. The
// counters are equilibria for each; times depend on the machine.

#include <benchmark/benchmark.h>

#include <cmath>
#include <random>

#include "common/scenes.hpp"
#include "common/workload.hpp"
#include "estimate/loaded_rod.hpp"
#include "scene/make_rod.hpp"
#include "tendril/calibrate.hpp"
#include "tendril/estimate_sequence.hpp"
#include "tendril/plugins/components.hpp"
#include "tendril/sensitivity.hpp"

namespace {

using namespace tendril;

constexpr double noise = 1e-4;  // m
constexpr int markers = 10;

/// A silicone arm of 100 mm that hangs down at its end.
Scene arm() {
  Scene scene;
  scene.file = "arm";
  scene.gravity = Vec2{0.0, -9.81};
  scene.rod.segments = {{.length = 0.1, .bending_stiffness = 4.9e-4, .linear_density = 0.084}};
  scene.rod.actuators = {{.from = 0.0, .to = 0.1}};
  scene.solver.time_limit = 600.0;
  return scene;
}

/// Noisy points of it under a moment (N m), what hangs at its tip (N), and forces along its normal (N, m).
std::vector<MeasuredPoint> seen(const Scene& scene, double moment, std::vector<NormalForce> forces,
                                std::mt19937& bits) {
  const Scale scale = scale_of(scene);
  for (NormalForce& f : forces) f = {f.force / scale.force(), f.arc_length / scale.length};
  const LoadedRod rod(make_rod(scene, scale), {moment / scale.moment()}, 12, 3.0);
  const LoadedRod::Shape shape = rod.solve(std::move(forces), [](double) { return 0.3; });
  std::vector<double> places;
  for (int i = 1; i <= markers; ++i) places.push_back(static_cast<double>(i) / markers);
  std::normal_distribution<double> off(0.0, noise);
  std::vector<MeasuredPoint> out;
  for (const LoadedRod::Point& p : rod.points(shape, places)) {
    out.push_back({scale.length * places[out.size()],
                   {scale.length * p.position.x + off(bits), scale.length * p.position.y + off(bits)}});
  }
  return out;
}

/// Stiffness, density, rest curvature, the gain of a chamber and the base's angle, with cross-validation.
void calibration(benchmark::State& state) {
  const Scene truth = arm();
  std::mt19937 bits(1);
  CalibrationSpec spec;
  for (int i = 0; i < static_cast<int>(state.range(0)); ++i) {
    Recording recording;
    recording.name = std::to_string(i);
    const double pressure = 5e3 * (1 + i % 20);
    recording.inputs = {pressure};
    recording.input_kinds = {ActuatorKind::pressure};
    const int weights = i / 20;
    recording.tip_force = {0.0, -2e-3 * weights};
    Scene loaded = truth;
    loaded.tip_load.force = recording.tip_force;
    for (const MeasuredPoint& p : seen(loaded, 4e-8 * pressure, {}, bits)) {
      recording.markers.push_back({p.arc_length, p.position, {}});
    }
    spec.recordings.push_back(std::move(recording));
  }
  Scene scene = truth;
  scene.rod.segments[0].bending_stiffness = 4e-4;
  scene.rod.segments[0].linear_density = 0.1;
  for (const CalibrationUnknown kind :
       {CalibrationUnknown::stiffness, CalibrationUnknown::density, CalibrationUnknown::rest_curvature,
        CalibrationUnknown::moment, CalibrationUnknown::base_angle}) {
    spec.unknowns.emplace_back().kind = kind;
  }
  Calibration result;
  for (auto _ : state) result = calibrate(scene, spec);
  state.counters["solved"] = result.status == CalibrationStatus::solved ? 1.0 : 0.0;
  state.counters["equilibria"] = result.solves;
}
BENCHMARK(calibration)->Arg(200)->Unit(benchmark::kMillisecond);

/// A contact that wanders; what is told of noise and rates: all (1), or nothing (0).
void sequence(benchmark::State& state) {
  Scene scene = arm();
  std::mt19937 bits(1);
  SequenceSpec spec;
  const auto frames = static_cast<int>(state.range(0));
  for (int k = 0; k < frames; ++k) {
    const double share = std::sin(0.1 * k);
    spec.frames.push_back({static_cast<double>(k), seen(scene, 2.5e-3, {{0.06 + 0.02 * share, 0.058}}, bits), {}});
  }
  scene.problem = ProblemKind::estimate;
  scene.measurement.moments = {2.5e-3};
  if (state.range(1) == 1) {
    scene.measurement.noise = noise;
    spec.force_rate = 2e-3;
    spec.place_rate = 1e-4;
  }
  SequenceEstimate result;
  for (auto _ : state) result = estimate_sequence(scene, spec);
  state.counters["solved"] = result.status == EstimateStatus::solved ? 1.0 : 0.0;
  state.counters["equilibria per frame"] = static_cast<double>(result.solves) / frames;
  state.counters["per frame"] =
      benchmark::Counter(frames, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(sequence)->Args({200, 1})->Args({200, 0})->Unit(benchmark::kMillisecond);

/// What error bars add to a plan whose problem is there; as a share of that, too.
void error_bars(benchmark::State& state) {
  plugins::Registry registry{plugins::Catalog(plugins::search_places({}))};
  const Scene scene = bench::scene_from_text(bench::gravity() + bench::arm("10 N mm") + bench::peg() +
                                                 "[target]\nposition = [\"97 mm\", \"20 mm\"]\n" + bench::objectives(),
                                             "braced arm", registry);
  Problem problem(scene, plugins::make_components(registry, scene));
  const Plan plan = problem.plan();
  const std::vector<std::string> keys{"rod.bending_stiffness", "obstacle[0].radius"};
  const std::vector<Spread> spreads{{keys[0], 1e-5, {{keys[0]}}}, {keys[1], 1e-4, {{keys[1]}}}};
  constexpr int plans = 20;
  const double begin = bench::processor_now();
  for (int i = 0; i < plans; ++i) benchmark::DoNotOptimize(problem.plan().objective);
  const double between = bench::processor_now();
  Uncertainty bars;
  for (auto _ : state) bars = uncertainty_of(problem.sensitivity(plan, SensitivityKind::held, keys), spreads);
  state.counters["told"] = bars.trouble.empty() ? 1.0 : 0.0;
  state.counters["of a plan"] =
      (bench::processor_now() - between) / static_cast<double>(state.iterations()) / ((between - begin) / plans);
}
BENCHMARK(error_bars);

}  // namespace
