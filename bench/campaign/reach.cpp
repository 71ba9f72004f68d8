#include "campaign/reach.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "campaign/allowed.hpp"
#include "common/statistics.hpp"
#include "common/workload.hpp"
#include "tendril/execute.hpp"
#include "tendril/plugins/components.hpp"

namespace tendril::bench {
namespace {

/// Draws in a row without an execution that a plan may end in: the scene has nothing to reach.
constexpr int most_draws = 1000;

/// What a rod is held at.
struct Inputs {
  std::vector<double> held;  ///< as of execute()
  RodPlace place;
};

double drawn(Uniform& random, double low, double high, const std::string& what) {
  if (!std::isfinite(low) || !std::isfinite(high)) throw Error(what + " has no limits to draw from");
  return low < high ? random(low, high) : low;
}

Inputs draw(Uniform& random, const RodSpec& rod) {
  Inputs inputs;
  for (std::size_t a = 0; a < rod.actuators.size(); ++a) {
    const ActuatorSpec& actuator = rod.actuators[a];
    const std::string name = fmt::format("actuator {}", a + 1);
    inputs.held.push_back(actuator.by_length ? drawn(random, actuator.least_shortening, actuator.most_shortening, name)
                                             : drawn(random, actuator.minimum, actuator.maximum, name));
  }
  if (rod.most_drawn_in > 0.0) {
    inputs.place.insertion = drawn(random, rod.length() - rod.most_drawn_in, rod.length(), "the insertion");
  }
  if (rod.base_position_range || rod.base_angle_range) {
    BasePose base{rod.base_position, rod.base_angle};
    if (const auto& range = rod.base_position_range) {
      base.position = {drawn(random, range->first.x, range->second.x, "the base"),
                       drawn(random, range->first.y, range->second.y, "the base")};
    }
    if (const auto& range = rod.base_angle_range) base.angle = drawn(random, range->first, range->second, "the base");
    inputs.place.base = base;
  }
  return inputs;
}

/// Where random inputs lead the rod; nothing where no plan may end there.
std::optional<Plan> lead(const ReachSetup& setup, const std::vector<std::unique_ptr<Obstacle>>& obstacles,
                         Uniform& random) {
  std::optional<Plan> at;
  for (int leg = 0; leg < setup.way_points; ++leg) {
    const Inputs inputs = draw(random, setup.scene.rod);
    ExecuteControl control;
    control.stop = setup.stop;
    control.place = inputs.place;
    if (at) control.start = &*at;
    Execution there = execute(setup.scene, obstacles, inputs.held, control);
    if (there.result.status != PlanStatus::solved) return std::nullopt;
    at = std::move(there.result);
  }
  if (!at || !allowed(setup.scene, *at)) return std::nullopt;
  return at;
}

ReachCase run_case(plugins::Registry& registry, const ReachSetup& setup, std::uint64_t seed) {
  ReachCase result;
  result.seed = seed;
  Uniform random(seed);
  Scene scene = setup.scene;
  const Components components = plugins::make_components(registry, scene);
  const auto stopped = [&] { return setup.stop != nullptr && setup.stop->load(); };
  std::optional<Plan> led;
  while (!led && !stopped()) {
    if (++result.draws > most_draws)
      throw Error(fmt::format("{} random inputs in a row lead to no state that a plan may end in", most_draws));
    led = lead(setup, components.obstacles, random);
  }
  if (!led) return result;
  result.contacts = led->contacts.size();
  result.target = {led->tip_x, led->tip_y};
  scene.target = TargetSpec{};
  scene.target.position = result.target;
  const TimedPlan timed = timed_plan(registry, scene);
  result.status = to_string(timed.plan.status);
  result.message = timed.plan.message;
  result.seconds = timed.seconds;
  result.error = timed.plan.target_error.value_or(std::nan(""));
  result.reached = timed.plan.status == PlanStatus::solved && result.error <= setup.tolerance * scene.rod.length();
  return result;
}

}  // namespace

bool allowed(const Scene& scene, const Plan& state) {
  if (state.status != PlanStatus::solved || state.contacts.size() > static_cast<std::size_t>(scene.contact.count))
    return false;
  for (std::size_t a = 0; a < state.moments.size(); ++a) {
    if (excess(scene.rod.actuators[a], state.moments[a]) > 0.0) return false;
  }
  const bool touches = scene.contact.mode != ContactModeName::avoid;
  return std::all_of(state.contacts.begin(), state.contacts.end(), [&](const PlannedContact& c) {
    return touches && !c.extended && c.force <= scene.contact.max_force;
  });
}

std::vector<ReachCase> run_reach(plugins::Registry& registry, const ReachSetup& setup) {
  if (setup.scene.problem != ProblemKind::pose) throw Error("targets are drawn for a pose, and this scene is another");
  std::vector<ReachCase> cases;
  for (int i = 0; i < setup.targets; ++i) {
    if (setup.stop != nullptr && setup.stop->load()) break;
    cases.push_back(run_case(registry, setup, setup.seed + static_cast<std::uint64_t>(i)));
    const ReachCase& last = cases.back();
    if (!last.reached) fmt::print(stderr, "seed {}: {}: {}\n", last.seed, last.status, last.message);
  }
  return cases;
}

Section reach_section(const ReachSetup& setup, const std::vector<ReachCase>& cases) {
  Section section;
  section.name = "reach";
  section.title = "Targets that the rod is known to reach";
  section.prose.push_back(fmt::format(
      "Inputs of '{}', each uniform within its limits, lead the rod through {} way points from its start; where the "
      "tip "
      "comes to rest in a state that a plan may end in is a target. A plan with {} is then asked for it without being "
      "told how it was reached. Reached: solved, and within {:g} % of the length.",
      setup.scene.title, setup.way_points, setup.scene.solver.plugin, 100.0 * setup.tolerance));
  Table counts{"reach_counts",
               "Targets",
               {"contacts there", "targets", "reached", "%", "median error (mm)", "median (s)", "longest (s)"},
               {},
               true};
  Table missed{"reach_missed",
               "Targets that were not reached",
               {"seed", "x (mm)", "y (mm)", "contacts there", "status", "error (mm)", "message"},
               {},
               true};
  Table all{"reach_cases",
            "Every target",
            {"seed", "draws", "x (m)", "y (m)", "contacts there", "status", "reached", "error (m)", "seconds"},
            {},
            false};
  std::size_t most = 0;
  for (const ReachCase& c : cases) most = std::max(most, c.contacts);
  const auto count = [&](const std::string& name, const auto& wanted) {
    std::vector<double> errors;
    std::vector<double> seconds;
    std::int64_t reached = 0;
    for (const ReachCase& c : cases) {
      if (!wanted(c)) continue;
      if (std::isfinite(c.error)) errors.push_back(1e3 * c.error);
      seconds.push_back(c.seconds);
      if (c.reached) ++reached;
    }
    if (seconds.empty()) return;
    const auto all_of_them = static_cast<double>(seconds.size());
    counts.rows.push_back({name, static_cast<std::int64_t>(seconds.size()), reached,
                           100.0 * static_cast<double>(reached) / all_of_them, median(errors), median(seconds),
                           quantile(seconds, 1.0)});
  };
  for (std::size_t contacts = 0; contacts <= most; ++contacts) {
    count(fmt::format("{}", contacts), [&](const ReachCase& c) { return c.contacts == contacts; });
  }
  count("all", [](const ReachCase&) { return true; });
  for (const ReachCase& c : cases) {
    const auto seed = static_cast<std::int64_t>(c.seed);
    const auto contacts = static_cast<std::int64_t>(c.contacts);
    all.rows.push_back({seed, std::int64_t{c.draws}, c.target.x, c.target.y, contacts, c.status,
                        std::int64_t{c.reached ? 1 : 0}, c.error, c.seconds});
    if (c.reached) continue;
    missed.rows.push_back({seed, 1e3 * c.target.x, 1e3 * c.target.y, contacts, c.status, 1e3 * c.error, c.message});
  }
  section.tables = {counts, missed, all};
  return section;
}

}  // namespace tendril::bench
