#include "campaign/completeness.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "campaign/allowed.hpp"
#include "campaign/campaign.hpp"
#include "campaign/random_scene.hpp"
#include "common/scenes.hpp"
#include "common/statistics.hpp"
#include "common/workload.hpp"
#include "tendril/execute.hpp"
#include "tendril/plugins/components.hpp"

namespace tendril::bench {
namespace {

constexpr double widest_start = 6.4;  ///< rad, of the tip of a shape to execute from

/// Fast plans from where executions come to rest.
void look_for_better(plugins::Registry& registry, const CompletenessSetup& setup, Scene scene,
                     CompletenessCase& found) {
  const Components components = plugins::make_components(registry, scene);
  Uniform random(found.seed);
  scene.effort = SearchEffort::fast;
  Problem problem(scene, plugins::make_components(registry, scene));
  found.best = found.objective;
  for (int i = 0; i < setup.executions && (setup.stop == nullptr || !setup.stop->load()); ++i) {
    std::vector<double> moments;
    for (const ActuatorSpec& actuator : scene.rod.actuators)
      moments.push_back(actuator.minimum < actuator.maximum ? random(actuator.minimum, actuator.maximum)
                                                            : actuator.minimum);
    Scene bent = scene;
    bent.start_tip_angle = random(-widest_start, widest_start);
    ExecuteControl execution;
    execution.stop = setup.stop;
    execution.with_obstacles = needs_obstacles(scene);
    Plan rest;
    try {
      rest = execute(bent, components.obstacles, moments, execution).result;
    } catch (const SceneError&) {
      continue;  // it starts through the middle of an obstacle
    }
    if (!allowed(scene, rest)) continue;
    ++found.executions;
    PlanControl control;
    control.stop = setup.stop;
    control.start = &rest;
    const Plan plan = problem.plan(control);
    if (plan.status == PlanStatus::solved) found.best = std::min(found.best, plan.objective);
  }
  found.found_more = found.best < found.objective - margin_of(found.objective);
}

}  // namespace

std::vector<CompletenessCase> run_completeness(plugins::Registry& registry, const CompletenessSetup& setup) {
  std::vector<CompletenessCase> cases;
  for (std::uint64_t seed = setup.first; seed <= setup.last; ++seed) {
    if (setup.stop != nullptr && setup.stop->load()) break;
    const RandomScene random = random_scene(seed, setup.solver, setup.time_limit, names_at_hand(registry));
    Scene scene = scene_from_text(random.text, fmt::format("seed {}", seed), registry);
    scene.effort = SearchEffort::thorough;
    const TimedPlan timed = timed_plan(registry, scene);
    if (timed.plan.status != PlanStatus::solved || !timed.plan.scan) continue;
    CompletenessCase found;
    found.seed = seed;
    found.summary = random.summary;
    found.complete = timed.plan.scan->complete();
    found.actuators = static_cast<int>(timed.plan.scan->steps.size());
    found.equilibria = timed.plan.scan->equilibria;
    found.lost = timed.plan.scan->lost;
    found.unresolved = timed.plan.scan->unresolved;
    found.objective = found.best = timed.plan.objective;
    found.seconds = timed.seconds;
    look_for_better(registry, setup, std::move(scene), found);
    if (found.complete && found.found_more)
      fmt::print(stderr, "seed {}: {} is no better than {}\n", seed, found.objective, found.best);
    cases.push_back(std::move(found));
  }
  return cases;
}

Section completeness_section(const CompletenessSetup& setup, const std::vector<CompletenessCase>& cases) {
  Section section;
  section.name = "completeness";
  section.title = "Plans that are complete to a resolution";
  section.prose.push_back(fmt::format(
      "Random scenes {} to {} whose thorough search with {} looked at all equilibria over the box of one moment or "
      "two. The rod is "
      "executed {} times from random shapes under random moments, and where it comes to rest as a plan may, a fast "
      "plan "
      "starts. Better: its objective is lower by more than {:g} of its size.",
      setup.first, setup.last, setup.solver, setup.executions, same_objective));
  Table counts{"completeness",
               "Scenes",
               {"moments", "complete", "scenes", "executions", "better found", "median equilibria", "median (s)"},
               {},
               true};
  Table better{"completeness_better",
               "Plans that are not the best",
               {"seed", "complete", "objective", "best", "scene"},
               {},
               true};
  Table open{"completeness_open",
             "Plans that are not complete",
             {"seed", "equilibria", "could not be followed on", "cost less and led to no plan", "scene"},
             {},
             true};
  for (int actuators = 0; actuators <= 2; ++actuators) {
    for (const bool complete : {true, false}) {
      std::vector<double> equilibria;
      std::vector<double> seconds;
      std::int64_t executions = 0;
      std::int64_t more = 0;
      for (const CompletenessCase& c : cases) {
        if (c.actuators != actuators || c.complete != complete) continue;
        equilibria.push_back(c.equilibria);
        seconds.push_back(c.seconds);
        executions += c.executions;
        if (c.found_more) ++more;
      }
      if (equilibria.empty()) continue;
      counts.rows.push_back({std::int64_t{actuators}, complete ? "yes" : "no",
                             static_cast<std::int64_t>(equilibria.size()), executions, more, median(equilibria),
                             median(seconds)});
    }
  }
  for (const CompletenessCase& c : cases) {
    if (!c.complete) {
      open.rows.push_back({static_cast<std::int64_t>(c.seed), std::int64_t{c.equilibria}, std::int64_t{c.lost},
                           std::int64_t{c.unresolved}, c.summary});
    }
    if (c.found_more)
      better.rows.push_back(
          {static_cast<std::int64_t>(c.seed), c.complete ? "yes" : "no", c.objective, c.best, c.summary});
  }
  section.tables = {counts, better, open};
  return section;
}

}  // namespace tendril::bench
