// What one evaluation of a pose program costs, beside what the sines and cosines in it cost anyway: order 6, split, one
// contact, 20 check points; the last number of a name: whether the rod is tapered (1), or stretches (2), or touches one
// body of 200 sides instead of a circle (3), or has 199 circles more around it (4). Reports heap allocations per
// iteration too. The ratio of the rows is the result; times depend on the machine.

#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdint>
#include <deque>
#include <memory>
#include <numbers>

#include "certificate/certifier.hpp"
#include "counting_malloc.hpp"
#include "nlp/polish.hpp"
#include "obstacle/circle.hpp"
#include "obstacle/part.hpp"
#include "program/pose_program.hpp"

namespace {

using namespace tendril;
using test::allocations;

/// Tip position and moment, as in the paper's Eq. 5.
class Pose : public ObjectiveBase<Pose> {
 public:
  Reads reads() const override {
    Reads r;
    r.tip_position = r.moments = true;
    return r;
  }
  template <class T>
  void operator()(const Quantities<T>& x, Contribution<T>& out) const {
    out.residual(x.tip.x - 0.97);
    out.residual(x.tip.y - 0.2);
    out.residual(0.01 * x.moments[0]);
  }
};

/// A toothed wheel where the circle is: its teeth reach as far as that.
Part wheel(Vec2 center, double radius, int corners) {
  ClosedLine line;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / corners;
    const double reach = (i % 2 == 0 ? 0.95 : 0.9) * radius;
    line.push_back(center + reach * Vec2{std::cos(angle), std::sin(angle)});
  }
  return Part({line}, 0.05 * radius);
}

constexpr std::int64_t toothed = 3, crowded = 4;

struct Fixture {
  explicit Fixture(int order = 6, int check_points = 20, std::int64_t kind = 0) : basis(order) {
    rod.segments[0].weight = 1.68;
    if (kind == 2) {
      rod.stretch_order = order / 2;
      rod.segments[0].axial = 1600.0;
    }
    if (kind == 1) {
      // A round section whose diameter falls by a fifth.
      rod.segments[0].more_stiffness = {-0.8, 0.24, -0.032, 0.0016};
      rod.segments[0].more_weight = {-0.4 * 1.68, 0.04 * 1.68};
    }
    rod.actuators = {{0.0, 1.0, -0.51, 0.51}};
    rod.gravity = {0.0, -1.0};
    PoseProgramSpec spec;
    spec.rod = &rod;
    spec.model = &basis;
    spec.obstacles = {&circle};
    if (kind == toothed) spec.obstacles = {&teeth};
    if (kind == crowded) {
      for (int i = 0; i < 199; ++i) crowd.emplace_back(Vec2{0.1 * (i % 20) - 0.5, 0.1 * (i / 20) + 0.6}, 0.01);
      for (const Circle& c : crowd) spec.obstacles.push_back(&c);
    }
    spec.terms = {{&pose, 1.0, "pose"}};
    spec.split = true;
    spec.contacts = {{0, false, 0}};
    const int per_piece = check_points / 2;
    for (int i = 1; i <= per_piece; ++i) {
      for (const int piece : {0, 1}) {
        const int obstacle = 2 * (i - 1) + piece;
        spec.checks.push_back({piece, static_cast<double>(i) / (per_piece + 1), kind == crowded ? obstacle : 0});
      }
    }
    spec.nodes = suggested_nodes(order, 1.0);
    program = std::make_unique<PoseProgram>(spec);
    x = program->start_from(constant_curvature(0.5));
    x[program->layout().first_force] = 1.2;
    y = Eigen::VectorXd::Constant(program->row_count(), 0.3);
  }

  /// A new point each time, so that nothing is found in the cache.
  void nudge() { x[0] += (flip = -flip); }

  LegendreBasis basis;
  Circle circle{{0.6, 0.0}, 0.08};
  Part teeth = wheel({0.6, 0.0}, 0.08, 200);
  std::deque<Circle> crowd;
  Pose pose;
  Rod rod;
  std::unique_ptr<PoseProgram> program;
  Eigen::VectorXd x, y;
  double flip = 1e-6;
};

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

/// One mode's program with its tables, and the doubled one that judges it.
void assembly(benchmark::State& state) {
  const Fixture f;
  for (auto _ : state) {
    const PoseProgram program(f.program->spec());
    const Certifier certifier(f.program->spec());
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
  Certifier certifier(f.program->spec());
  for (auto _ : state) benchmark::DoNotOptimize(certifier.certify(*f.program, plan.x).stability);
  state.counters["converged"] = plan.converged ? 1.0 : 0.0;
}
BENCHMARK(certificate)->Arg(0)->Arg(toothed)->Arg(crowded);

}  // namespace
