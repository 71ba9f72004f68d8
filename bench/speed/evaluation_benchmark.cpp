// What one evaluation of a pose program costs, beside what the sines and cosines in it cost anyway: order 6, split, one
// contact, 20 check points; the last number of a name: whether the rod is tapered (1), or stretches (2), or touches one
// body of 200 sides instead of a circle (3), or has 199 circles more around it (4). Reports heap allocations per
// iteration too. The ratio of the rows is the result; times depend on the machine.

#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdint>

#include "certificate/certifier.hpp"
#include "common/pose_fixture.hpp"
#include "counting_malloc.hpp"
#include "nlp/polish.hpp"

namespace {

using namespace tendril;
using Fixture = bench::PoseFixture;
using bench::crowded;
using bench::toothed;
using test::allocations;

void count_allocations(benchmark::State& state, long before) {
  state.counters["allocations"] =
      benchmark::Counter(static_cast<double>(allocations() - before), benchmark::Counter::kAvgIterations);
}

void sixty_sine_cosine_pairs(benchmark::State& state) {
  double angles[60];
  for (int i = 0; i < 60; ++i) angles[i] = 0.013 * i;
  for (auto _ : state) {
    double sum = 0.0;
    for (double& angle : angles) {
      sum += std::sin(angle) + std::cos(angle);
    }
    benchmark::DoNotOptimize(sum);
    benchmark::ClobberMemory();
  }
}
BENCHMARK(sixty_sine_cosine_pairs);

void values(benchmark::State& state) {
  Fixture f(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)), state.range(2));
  const long before = allocations();
  for (auto _ : state) {
    f.nudge();
    benchmark::DoNotOptimize(f.program->constraints(f.x).data());
  }
  count_allocations(state, before);
}
BENCHMARK(values)->Args({6, 20, 0})->Args({6, 20, 1})->Args({6, 20, 2})->Args({6, 20, toothed})->Args({6, 20, crowded});

void first_derivatives(benchmark::State& state) {
  Fixture f(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)), state.range(2));
  const long before = allocations();
  for (auto _ : state) {
    f.nudge();
    benchmark::DoNotOptimize(f.program->jacobian(f.x).data());
    benchmark::DoNotOptimize(f.program->gradient(f.x).data());
  }
  count_allocations(state, before);
}
BENCHMARK(first_derivatives)
    ->Args({6, 20, 0})
    ->Args({6, 4, 0})
    ->Args({12, 20, 0})
    ->Args({24, 20, 0})
    ->Args({48, 20, 0})
    ->Args({6, 20, 1})
    ->Args({12, 20, 1})
    ->Args({6, 20, 2})
    ->Args({12, 20, 2})
    ->Args({6, 20, toothed})
    ->Args({6, 20, crowded});

void with_hessian(benchmark::State& state) {
  Fixture f(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)), state.range(2));
  const long before = allocations();
  for (auto _ : state) {
    f.nudge();
    benchmark::DoNotOptimize(f.program->jacobian(f.x).data());
    benchmark::DoNotOptimize(f.program->hessian(f.x, 1.0, f.y).data());
  }
  count_allocations(state, before);
}
BENCHMARK(with_hessian)
    ->Args({6, 20, 0})
    ->Args({6, 4, 0})
    ->Args({12, 20, 0})
    ->Args({24, 20, 0})
    ->Args({48, 20, 0})
    ->Args({6, 20, 1})
    ->Args({12, 20, 1})
    ->Args({6, 20, 2})
    ->Args({12, 20, 2})
    ->Args({6, 20, toothed})
    ->Args({6, 20, crowded});

/// One mode's program with its tables, and what judges it.
void assembly(benchmark::State& state) {
  const Fixture f;
  for (auto _ : state) {
    PoseProgram program(f.program->spec());
    const Certifier certifier(program);
    benchmark::DoNotOptimize(&program);
    benchmark::DoNotOptimize(&certifier);
  }
}
BENCHMARK(assembly);

/// The whole certificate of a polished plan.
void certificate(benchmark::State& state) {
  Fixture f(6, 20, state.range(0));
  f.program->set_branch(0, Branch::touching);
  const PolishReport plan = polish(*f.program, f.x, {});
  Certifier certifier(*f.program);
  for (auto _ : state) benchmark::DoNotOptimize(certifier.certify(*f.program, plan.x).stability);
  state.counters["converged"] = plan.converged ? 1.0 : 0.0;
}
BENCHMARK(certificate)->Arg(0)->Arg(toothed)->Arg(crowded);

}  // namespace
