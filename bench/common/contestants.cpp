#include "common/contestants.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "common/workload.hpp"

namespace tendril::bench {

namespace {

constexpr Treatment treatments[] = {Treatment::penalty, Treatment::slack, Treatment::scholtes,
                                    Treatment::fischer_burmeister};

/// What a contestant did in the trial: its calls, and where its last solves ended, to the last bit. An option that has
/// no effect leaves no trace; another factorization does, by its rounding.
using Trace = std::pair<std::vector<std::int64_t>, std::vector<double>>;

}  // namespace

Scene with_contestant(Scene scene, const Contestant& contestant) {
  // Options belong to the solver that the scene names.
  if (scene.solver.plugin != contestant.solver) scene.solver.options.clear();
  scene.solver.plugin = contestant.solver;
  for (const auto& [name, value] : contestant.options) scene.solver.options[name] = value;
  scene.contact.treatment = contestant.treatment;
  return scene;
}

std::vector<Contestant> find_contestants(plugins::Registry& registry, std::vector<LeftOut>& left_out) {
  std::vector<Contestant> all;
  for (const std::string& solver : registry.names(ComponentKind::solver)) {
    const SolverComponent* component = nullptr;
    try {
      component = &registry.solver(solver);
    } catch (const plugins::PluginError& error) {
      left_out.push_back({"solver '" + solver + "'", error.what()});
      continue;
    }
    for (const Treatment treatment : treatments) {
      const std::string word(to_string(treatment));
      all.push_back({treatment == Treatment::penalty ? solver : solver + ", " + word, solver, {}, treatment});
    }
    for (const OptionSpec& option : component->options) {
      if (option.type != OptionType::text) continue;
      for (const std::string& choice : option.choices) {
        all.push_back({fmt::format("{}, {} = {}", solver, option.name, choice),
                       solver,
                       {{option.name, RawValue{choice}}},
                       Treatment::penalty});
      }
    }
  }
  return all;
}

std::vector<Contestant> able_contestants(plugins::Registry& registry, const std::vector<Contestant>& all,
                                         const std::vector<Scene>& trial, double time_limit,
                                         std::vector<LeftOut>& left_out) {
  std::vector<Contestant> able;
  std::vector<std::pair<Trace, std::string>> traces;
  // Dozens of choices are out for the same few reasons.
  std::vector<LeftOut> groups;
  const auto group = [&](std::string why, const Contestant& contestant) {
    const std::string& what = contestant.name;
    // "solver CHOICE cannot ...": whose name it is stands before the reason already.
    for (const auto& [option, value] : contestant.options) {
      const auto* choice = std::get_if<std::string>(&value.value);
      const std::string own = choice != nullptr ? contestant.solver + ' ' + *choice + ' ' : "";
      if (!own.empty() && why.starts_with(own)) why.erase(0, own.size());
    }
    const auto same = std::find_if(groups.begin(), groups.end(), [&](const LeftOut& g) { return g.why == why; });
    if (same != groups.end()) {
      same->what += "; " + what;
    } else {
      groups.push_back({what, why});
    }
  };
  for (const Contestant& contestant : all) {
    Trace trace;
    int certified = 0;
    bool refused = false;
    std::string reason;
    for (Scene scene : trial) {
      scene.solver.time_limit = time_limit;
      try {
        const TimedPlan timed = timed_plan(registry, with_contestant(scene, contestant));
        if (timed.plan.solver.status == SolveStatus::unsupported) {
          refused = true;
          reason = timed.plan.solver.message;
          break;
        }
        if (timed.plan.status == PlanStatus::solved) {
          ++certified;
        } else if (reason.empty()) {
          reason = timed.plan.status == PlanStatus::time_limit
                       ? fmt::format("no certified plan within {} s", time_limit)
                       : fmt::format(
                             "{}", timed.plan.solver.message.empty() ? timed.plan.message : timed.plan.solver.message);
        }
        trace.first.push_back(timed.iterations);
        trace.first.push_back(timed.evaluations);
        const Eigen::VectorXd& end = timed.plan.solver.x;
        trace.second.insert(trace.second.end(), end.data(), end.data() + end.size());
      } catch (const Error& error) {
        if (reason.empty()) reason = error.what();
      }
    }
    const bool choice = !contestant.options.empty();
    if (choice && (refused || certified == 0)) {
      group(reason, contestant);
      continue;
    }
    const auto twin = std::find_if(traces.begin(), traces.end(), [&](const auto& t) { return t.first == trace; });
    if (choice && twin != traces.end()) {
      group("does the same as '" + twin->second + "', to the last bit", contestant);
      continue;
    }
    if (contestant.treatment == Treatment::penalty) traces.emplace_back(std::move(trace), contestant.name);
    able.push_back(contestant);
  }
  left_out.insert(left_out.end(), groups.begin(), groups.end());
  return able;
}

}  // namespace tendril::bench
