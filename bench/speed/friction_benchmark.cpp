// What friction adds to a plan of the braced arm and to a followed step: the number of a name is the state of friction
// (0: none, 1: range, 2: any, 3: worst). Counters are processor time of the same without friction, in between, and its
// share; times depend on the machine.

#include <benchmark/benchmark.h>

#include "common/scenes.hpp"
#include "common/workload.hpp"
#include "tendril/plugins/components.hpp"

namespace {

using namespace tendril;

Problem braced(plugins::Registry& registry, std::int64_t state) {
  Scene scene = bench::scene_from_text(bench::gravity() + bench::arm("2.5 N mm") + bench::peg() +
                                           "[target]\nposition = [\"97 mm\", \"20 mm\"]\n" + bench::objectives(),
                                       "braced arm", registry);
  constexpr FrictionState states[] = {FrictionState::none, FrictionState::range, FrictionState::any,
                                      FrictionState::worst};
  if (state > 0) scene.contact.friction = 0.3;
  scene.contact.friction_state = state > 0 ? states[state] : FrictionState::range;
  return {scene, plugins::make_components(registry, scene)};
}

/// Times one thing against another, in turn.
template <class One, class Other>
void compare(benchmark::State& state, const One& one, const Other& other) {
  double with = 0.0;
  double without = 0.0;
  for (auto _ : state) {
    const double begin = bench::processor_now();
    other();
    const double between = bench::processor_now();
    one();
    without += between - begin;
    with += bench::processor_now() - between;
  }
  state.counters["of without"] = with / without;
}

void plan_with_friction(benchmark::State& state) {
  plugins::Registry registry{plugins::Catalog(plugins::search_places({}))};
  Problem without = braced(registry, 0);
  Problem with = braced(registry, state.range(0));
  bool solved = true;
  compare(
      state, [&] { solved = solved && with.plan().status == PlanStatus::solved; }, [&] { without.plan(); });
  state.counters["solved"] = solved ? 1.0 : 0.0;
}
BENCHMARK(plan_with_friction)->DenseRange(0, 3)->Unit(benchmark::kMillisecond);

/// To and fro between two targets.
void step_with_friction(benchmark::State& state) {
  plugins::Registry registry{plugins::Catalog(plugins::search_places({}))};
  Problem without = braced(registry, 0);
  Problem with = braced(registry, state.range(0));
  Plan one = without.plan();
  Plan other = with.plan();
  bool followed = true;
  bool there = false;
  TargetSpec target;
  compare(
      state, [&] { followed = with.step(target, other, nullptr) && followed; },
      [&] {
        there = !there;
        target.position = Vec2{there ? 0.0969 : 0.097, 0.02};
        without.step(target, one, nullptr);
      });
  state.counters["followed"] = followed ? 1.0 : 0.0;
}
BENCHMARK(step_with_friction)->DenseRange(0, 2)->Unit(benchmark::kMillisecond);

}  // namespace
