#include "report/lean.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#ifdef TENDRIL_COUNTS_HEAP
#include "counting_malloc.hpp"
#endif
#include "common/scenes.hpp"
#include "common/statistics.hpp"
#include "common/workload.hpp"
#include "tendril/plugins/components.hpp"

namespace tendril::bench {

namespace {

struct Variant {
  std::string name;
  std::string what;
  Scene scene;
};

/// Far from anything the rod can do, but within its reach, so that no planner can prove it away.
std::string pegs_nearby(int count) {
  std::string text;
  for (int i = 0; i < count; ++i) {
    text += fmt::format("[[obstacle]]\nshape = \"circle\"\ncenter = [\"{} mm\", \"{} mm\"]\nradius = \"3 mm\"\n",
                        20 + 8 * i, i % 2 == 0 ? -45 : 60);
  }
  return text;
}

/// A weight or a load that is there, and changes nothing that can be seen.
constexpr const char* negligible = "1e-12";

/// Every objective that needs no options, no tendon and no error bars, at a negligible weight, besides those that do
/// the work.
std::string idle_objectives(plugins::Registry& registry) {
  std::string text;
  for (const std::string& name : registry.names(ComponentKind::objective)) {
    const ObjectiveComponent& component = registry.objective(name);
    const bool needs = std::any_of(component.options.begin(), component.options.end(),
                                   [](const OptionSpec& option) { return option.required; });
    if (needs) continue;
    const Reads reads = component.make(resolve_options(component.options, {}, {}, {}, name))->reads();
    if (reads.tensions || reads.shortenings || reads.tip_deviations) continue;
    text += "[[objective]]\nplugin = \"" + name + "\"\nweight = " + negligible + "\n";
  }
  return text;
}

struct Measured {
  int variables = 0, rows = 0, programs = 0, opened = 0;
  double kilobytes = std::nan("");  ///< stays so where a sanitizer stands in for malloc
  std::string left_out;
};

Measured measure(const plugins::Registry& registry, const Scene& scene) {
  Measured m;
  // A registry of its own opens what this scene needs, and nothing else.
  plugins::Registry fresh{registry.catalog()};
  Components components = plugins::make_components(fresh, scene);
  m.opened = static_cast<int>(fresh.opened().size());
#ifdef TENDRIL_COUNTS_HEAP
  test::watch_heap();
#endif
  Problem problem(scene, std::move(components));
  (void)problem.plan();
#ifdef TENDRIL_COUNTS_HEAP
  m.kilobytes = static_cast<double>(test::heap_peak()) / 1024.0;
#endif
  const Description description = problem.describe();
  for (const Description::Count& c : description.variables) m.variables += c.count;
  for (const Description::Count& c : description.rows) m.rows += c.count;
  m.programs = static_cast<int>(description.modes.size());
  return m;
}

std::vector<Variant> variants(plugins::Registry& registry, std::vector<LeftOut>& left_out) {
  // Above the peg and within reach of the free arm: the peg is never touched, so all of these have one answer.
  const std::string target = "[target]\nposition = [\"91 mm\", \"26 mm\"]\n";
  const std::string strong = arm("10 N mm");
  const std::string allow = "[contact]\nmode = \"allow\"\nmax_force = \"1 N\"\n";
  std::vector<Variant> list;
  const auto add = [&](const std::string& name, const std::string& what, const std::string& text) {
    list.push_back({name, what, scene_from_text(text, name, registry)});
  };
  add("free, no gravity", "nothing but the rod", strong + target + objectives());
  add("free", "with gravity", gravity() + strong + target + objectives());
  add("avoid one peg", "with clearance, no contact",
      gravity() + strong + peg() + "[contact]\nmode = \"avoid\"\n" + target + objectives());
  add("allow one contact", "with a contact on one peg", gravity() + strong + peg() + allow + target + objectives());
  add("avoid nine pegs", "many obstacles, no contact",
      gravity() + strong + peg() + pegs_nearby(8) + "[contact]\nmode = \"avoid\"\n" + target + objectives());
  add("allow, nine pegs", "many obstacles, one contact allowed",
      gravity() + strong + peg() + pegs_nearby(8) + allow + target + objectives());
  std::string idle;
  try {
    idle = idle_objectives(registry);
  } catch (const Error& error) {
    left_out.push_back({"objectives with negligible weights", error.what()});
  }
  add("free, no gravity, carrying everything",
      "the first scene's answer from a program that carries all: gravity of 1e-12 m/s^2, a peg that may be touched, "
      "every objective that needs no options and no tendon at a weight of 1e-12",
      std::string("gravity = [\"0 m/s^2\", \"-1e-12 m/s^2\"]\n") + strong + peg() + allow + target + objectives() +
          idle);
  add(
      "free, no gravity, weights of 0", "the first scene with the same objectives at a weight of 0",
      strong + target + objectives() + [&] {
        std::string zero = idle;
        for (std::size_t at = zero.find(negligible); at != std::string::npos; at = zero.find(negligible)) {
          zero.replace(at, std::string(negligible).size(), "0");
        }
        return zero;
      }());
  return list;
}

}  // namespace

Section lean_section(const plugins::Registry& registry, const Extent& extent) {
  Section section;
  section.name = "lean";
  section.title = "What a scene pays for what it does not use";
  plugins::Registry own{registry.catalog()};
  const std::vector<Variant> list = variants(own, section.left_out);
  std::vector<std::vector<double>> seconds(list.size()), evaluation(list.size());
  std::vector<TimedPlan> plans;
  plans.reserve(list.size());
  for (const Variant& variant : list) plans.push_back(timed_plan(own, variant.scene));
  for (int repetition = 0; repetition < extent.repetitions_of_timed() && !extent.stopped(); ++repetition) {
    for (std::size_t i = 0; i < list.size(); ++i) {
      const TimedPlan timed = timed_plan(own, list[i].scene);
      seconds[i].push_back(timed.seconds);
      if (timed.evaluations > 0) evaluation[i].push_back(timed.evaluating / static_cast<double>(timed.evaluations));
    }
  }
  Table table{"lean",
              "All of these plans reach the same target without touching anything. Variables and rows: of the largest "
              "program; programs: ways of being in contact; memory: the most that lives on the heap at once while the "
              "plan is made, components excepted",
              {"scene", "what it is", "variables", "rows", "programs", "plugins opened", "memory (kB)", "evaluations",
               "one evaluation (us)", "plan (ms)", "quartiles (ms)", "times the first", "certified"},
              {}};
  for (std::size_t i = 0; i < list.size(); ++i) {
    const Measured m = measure(registry, list[i].scene);
    const Quartiles q = quartiles(seconds[i]);
    table.rows.push_back({list[i].name, list[i].what, std::int64_t{m.variables}, std::int64_t{m.rows},
                          std::int64_t{m.programs}, std::int64_t{m.opened}, m.kilobytes, plans[i].evaluations,
                          1e6 * median(evaluation[i]), 1e3 * q.median,
                          fmt::format("{:.3g} .. {:.3g}", 1e3 * q.low, 1e3 * q.high), q.median / median(seconds[0]),
                          std::string(plans[i].plan.status == PlanStatus::solved ? "yes" : plans[i].plan.message)});
  }
  const Plan& lean = plans.front().plan;
  const std::size_t carrying = list.size() - 2;
  const double apart = std::hypot(plans[carrying].plan.tip_x - lean.tip_x, plans[carrying].plan.tip_y - lean.tip_y) /
                       list.front().scene.rod.length();
  section.prose.push_back(fmt::format(
      "Everything in a scene is built only if it is asked for. The program that carries everything with negligible "
      "weights ends {:.1e} L from the lean one's tip and takes {:.2g} times its time. With weights of 0 the same "
      "objectives are neither opened nor evaluated, and the plan takes {:.2g} times the lean one's time.",
      apart, median(seconds[carrying]) / median(seconds.front()), median(seconds.back()) / median(seconds.front())));
  section.tables = {table};
  return section;
}

}  // namespace tendril::bench
