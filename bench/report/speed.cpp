#include "report/speed.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <optional>

#include "certificate/certifier.hpp"
#include "common/pose_fixture.hpp"
#include "common/scenes.hpp"
#include "common/statistics.hpp"
#include "common/workload.hpp"
#include "nlp/polish.hpp"
#include "tendril/plugins/components.hpp"

namespace tendril::bench {

namespace {

/// So many at a time are timed together: a clock costs a part of one of them.
constexpr int batch = 40;

struct Cost {
  std::string what, solver;
  std::vector<double> seconds{}, ratios{};
  /// `unit`: seconds of an evaluation, measured just before, so that the machine was as busy.
  void add(double own, double unit) {
    seconds.push_back(own);
    ratios.push_back(own / unit);
  }
};

/// The braced arm with a limit of its motor.
Scene braced(const std::string& limit, const std::string& solver, SearchEffort effort,
             const plugins::Registry& registry) {
  Scene scene = scene_from_text(gravity() + arm(limit) + peg() + "[contact]\nmode = \"allow\"\nmax_force = \"1 N\"\n" +
                                    "[target]\nposition = [\"97 mm\", \"20 mm\"]\n" + objectives(),
                                "braced arm", registry);
  scene.solver.plugin = solver;
  scene.effort = effort;
  return scene;
}

/// The same with a body of 200 sides instead of the peg, or with 199 further pegs that the rod cannot reach.
Scene braced_among(bool body, const std::string& solver, const plugins::Registry& registry) {
  std::string text = peg();
  if (body) {
    text = "[[obstacle]]\nshape = \"polygon\"\nrounding = \"0.4 mm\"\nvertices = [";
    for (int i = 0; i < 200; ++i) {
      const double angle = 0.01 * std::numbers::pi * i;
      const double reach = (i % 2 == 0 ? 0.0076 : 0.0072);
      text += fmt::format("[{}, {}],", 0.06 + reach * std::cos(angle), reach * std::sin(angle));
    }
    text += "]\n";
  } else {
    for (int i = 0; i < 199; ++i) {
      const int row = i / 20;
      text += fmt::format("[[obstacle]]\nshape = \"circle\"\ncenter = [{}, {}]\nradius = \"1 mm\"\n",
                          0.01 * (i % 20) - 0.05, -0.11 - 0.01 * row);
    }
  }
  Scene scene =
      scene_from_text(gravity() + arm("10 N mm") + text + "[contact]\nmode = \"allow\"\nmax_force = \"1 N\"\n" +
                          "[target]\nposition = [\"97 mm\", \"20 mm\"]\n" + objectives(),
                      "braced arm", registry);
  scene.solver.plugin = solver;
  return scene;
}

/// Of an evaluation: cost, gradient, rows and Jacobian.
double evaluation(std::int64_t kind = 0) {
  PoseFixture f(6, 20, kind);
  const double begin = processor_now();
  for (int i = 0; i < batch; ++i) {
    f.nudge();
    (void)f.program->jacobian(f.x);
    (void)f.program->gradient(f.x);
  }
  return (processor_now() - begin) / batch;
}

/// Of the certificate of a polished point, which the program was evaluated at, as it is after every polish.
double certificate() {
  PoseFixture f;
  f.program->set_branch(0, Branch::touching);
  const PolishReport plan = polish(*f.program, f.x, {});
  Certifier certifier(*f.program);
  Certificate c;
  const auto certify = [&](const Eigen::VectorXd& x) {
    (void)f.program->jacobian(x);
    const double begin = processor_now();
    certifier.certify(*f.program, x, c, &plan.multipliers, &plan.bound_multipliers);
    return processor_now() - begin;
  };
  double seconds = 0.0;
  for (int i = 0; i < batch; ++i) {
    Eigen::VectorXd near = plan.x;
    near[0] += i % 2 == 0 ? 1e-14 : -1e-14;
    seconds += certify(near);
  }
  return c.valid() ? seconds / batch : std::nan("");
}

/// All targets at one limit, planned one after the other by one problem.
void plan_targets(plugins::Registry& registry, const Scene& scene, int side, Cost& whole, Cost& winning) {
  Problem problem(scene, plugins::make_components(registry, scene));
  for (const Vec2 at : grid({0.091, 0.006}, {0.099, 0.026}, side)) {
    problem.set_target({at, std::nullopt});
    const double unit = evaluation();
    const double wall = now();
    const double begin = processor_now();
    const Plan plan = problem.plan();
    const double seconds = processor_now() - begin;
    const double took = now() - wall;
    const ModeRecord* mode = winning_mode(plan);
    if (mode == nullptr) continue;
    whole.add(seconds, unit);
    winning.add(seconds * mode->seconds / took, unit);
  }
}

TargetSpec on_the_way(double share) { return {Vec2{0.095 + 0.002 * share, 0.032 - 0.014 * share}, std::nullopt}; }

/// From above the peg down to it and back.
void follow_path(plugins::Registry& registry, const Scene& scene, Cost& kept, Cost& changed) {
  Problem problem(scene, plugins::make_components(registry, scene));
  constexpr int steps = 10 * batch;
  problem.set_target(on_the_way(0.0));
  Plan plan = problem.plan();
  double seconds = 0.0;
  double unit = evaluation();
  int together = 0;
  for (int i = 1; i <= 2 * steps; ++i) {
    const auto contacts = plan.contacts.size();
    const double begin = processor_now();
    problem.follow(on_the_way(1.0 - std::abs(1.0 - static_cast<double>(i) / steps)), plan);
    const double own = processor_now() - begin;
    if (plan.status != PlanStatus::solved) continue;
    if (plan.contacts.size() != contacts) {
      changed.add(own, unit);
      continue;
    }
    seconds += own;
    if (++together < batch) continue;
    kept.add(seconds / batch, unit);
    unit = evaluation();
    seconds = 0.0;
    together = 0;
  }
}

}  // namespace

Section speed_section(plugins::Registry& registry, const Extent& extent) {
  Section section;
  section.name = "speed";
  section.title = "What a plan, a step and a certificate cost";
  std::vector<std::string> solvers;
  for (const std::string& name : registry.names(ComponentKind::solver)) {
    try {
      (void)registry.solver(name);
      solvers.push_back(name);
    } catch (const plugins::PluginError& error) {
      section.left_out.push_back({"solver '" + name + "'", error.what()});
    }
  }
  const std::string planning[] = {"plan, fast search", "plan, normal search"};
  std::vector<Cost> costs{{"certificate of one contact", "none"},
                          {"followed step, contacts kept", "none"},
                          {"followed step, a contact comes or goes", solvers.empty() ? "none" : solvers.front()},
                          {"evaluation beside one body of 200 sides", "none"},
                          {"evaluation beside 199 circles more", "none"}};
  const std::size_t first_plans = costs.size();
  for (const std::string& solver : solvers) {
    for (const std::string& what : planning) {
      costs.push_back({what, solver});
      costs.push_back({"its winning way", solver});
    }
    costs.push_back({"plan beside one body of 200 sides", solver});
    costs.push_back({"plan beside 199 circles more", solver});
  }
  std::vector<double> unit;
  const int side = extent.quick ? 2 : 5;
  for (int repetition = 0; repetition < extent.repetitions_of_timed() && !extent.stopped(); ++repetition) {
    unit.push_back(evaluation());
    costs[0].add(certificate(), unit.back());
    costs[3].add(evaluation(toothed), unit.back());
    costs[4].add(evaluation(crowded), unit.back());
    std::size_t next = first_plans;
    for (const std::string& solver : solvers) {
      if (solver == solvers.front())
        follow_path(registry, braced("10 N mm", solver, SearchEffort::normal, registry), costs[1], costs[2]);
      for (const SearchEffort effort : {SearchEffort::fast, SearchEffort::normal}) {
        for (const char* limit : {"2.5 N mm", "10 N mm"})
          plan_targets(registry, braced(limit, solver, effort, registry), side, costs[next], costs[next + 1]);
        next += 2;
      }
      for (const bool body : {true, false}) {
        Cost winning;
        plan_targets(registry, braced_among(body, solver, registry), side, costs[next++], winning);
      }
    }
  }
  const Quartiles one = quartiles(unit);
  Table table{
      "speed",
      "The braced arm, order 6, split at its contact; medians. Unit: one evaluation of its program with 20 check "
      "points (cost, gradient, rows and Jacobian), measured just before. Plans: 25 targets at limits of 2.5 and "
      "10 N mm, one problem for all targets of a limit; a way of being in contact has its share of "
      "the plan's processor time. Among 200 pieces, with one contact: limit 10 N mm. Steps: from above the peg down to "
      "it and back, limit 10 N mm, 400 steps each way",
      {"what", "solver", "evaluations' worth", "quartiles", "time (us)", "measured"},
      {}};
  for (const Cost& cost : costs) {
    const Quartiles q = quartiles(cost.ratios);
    table.rows.push_back({cost.what, cost.solver, q.median, fmt::format("{:.3g} .. {:.3g}", q.low, q.high),
                          1e6 * median(cost.seconds), static_cast<std::int64_t>(cost.seconds.size())});
  }
  section.prose.push_back(fmt::format("One evaluation took {:.3g} us (quartiles {:.3g} .. {:.3g}).", 1e6 * one.median,
                                      1e6 * one.low, 1e6 * one.high));
  section.tables = {table};
  return section;
}

}  // namespace tendril::bench
