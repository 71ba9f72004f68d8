#include "campaign/best_known.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "campaign/campaign.hpp"
#include "campaign/random_scene.hpp"
#include "common/scenes.hpp"
#include "common/statistics.hpp"
#include "common/workload.hpp"
#include "tendril/plugins/components.hpp"

namespace tendril::bench {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
/// rad, of each of the two arcs of a random shape.
constexpr double widest_arc = 4.0;
constexpr int points_of_arc = 24;

/// Two arcs of random turns that meet at a random place.
std::vector<Vec2> random_shape(Uniform& random, double length) {
  const double share = random(0.1, 0.9);
  std::vector<Vec2> points;
  Vec2 at{};
  double angle = 0.0;
  for (const double part : {share, 1.0 - share}) {
    const double turn = random(-widest_arc, widest_arc) / points_of_arc;
    const double step = part * length / points_of_arc;
    for (int i = 0; i < points_of_arc; ++i) {
      angle += 0.5 * turn;
      at += step * Vec2{std::cos(angle), std::sin(angle)};
      angle += 0.5 * turn;
      points.push_back(at);
    }
  }
  return points;
}

void keep(const Plan& plan, BestKnownCase& found) {
  if (plan.status != PlanStatus::solved) return;
  const bool overlaps = plan.self_overlap.has_value();
  if (!overlaps) found.best_apart = std::min(found.best_apart, plan.objective);
  if (plan.objective >= found.best) return;
  found.best = plan.objective;
  found.best_overlaps = overlaps;
}

struct Count {
  std::int64_t planned = 0, found = 0;
};

/// Scenes with a plan, and those whose best known one a normal search found. `simple`: with one moment and one
/// obstacle.
Count counted(const std::vector<BestKnownCase>& cases, const std::string& solver, bool simple) {
  Count count;
  for (const BestKnownCase& c : cases) {
    if (!std::isfinite(c.best) || (simple && (c.actuators != 1 || c.obstacles != 1))) continue;
    ++count.planned;
    if (c.found(solver)) ++count.found;
  }
  return count;
}

}  // namespace

bool BestKnownCase::found(const std::string& solver) const {
  const auto own = objectives.find(solver);
  return own != objectives.end() && own->second <= best + margin_of(best, scale);
}

std::vector<BestKnownCase> run_best_known(plugins::Registry& registry, const BestKnownSetup& setup) {
  std::vector<BestKnownCase> cases;
  const auto stopped = [&] { return setup.stop != nullptr && setup.stop->load(); };
  PlanControl control;
  control.stop = setup.stop;
  for (std::uint64_t seed = setup.first; seed <= setup.last && !stopped(); ++seed) {
    BestKnownCase found;
    found.seed = seed;
    found.best = found.best_apart = infinity;
    std::vector<Scene> scenes;
    for (const std::string& solver : setup.solvers) {
      const RandomScene random = random_scene(seed, solver, setup.time_limit, names_at_hand(registry));
      found.summary = random.summary;
      scenes.push_back(scene_from_text(random.text, fmt::format("seed {}", seed), registry));
    }
    const Scene& scene = scenes.front();
    for (const ActuatorSpec& actuator : scene.rod.actuators) found.actuators += actuator.minimum < actuator.maximum;
    found.obstacles = static_cast<int>(scene.obstacles.size());
    found.scale = scale_of_objective(scene);
    for (const Scene& own : scenes) {
      const Plan plan = Problem(own, plugins::make_components(registry, own)).plan(control);
      keep(plan, found);
      if (plan.status == PlanStatus::solved) found.objectives[own.solver.plugin] = plan.objective;
    }
    Uniform random(seed);
    for (int i = 0; i < setup.starts && !stopped(); ++i) {
      Scene from = scenes[static_cast<std::size_t>(i) % scenes.size()];
      from.effort = SearchEffort::fast;
      from.start_points = random_shape(random, from.rod.length());
      const Plan plan = Problem(from, plugins::make_components(registry, from)).plan(control);
      if (plan.status == PlanStatus::solved) ++found.solved;
      keep(plan, found);
    }
    for (const std::string& solver : setup.solvers) {
      if (std::isfinite(found.best) && !found.found(solver))
        fmt::print(stderr, "{} seed {}: the best known plan has {}{}\n", solver, seed, found.best,
                   found.best_overlaps ? " and overlaps itself" : "");
    }
    cases.push_back(std::move(found));
  }
  return cases;
}

bool finds_best(const BestKnownSetup& setup, const std::vector<BestKnownCase>& cases, double share) {
  return std::all_of(setup.solvers.begin(), setup.solvers.end(), [&](const std::string& solver) {
    const Count count = counted(cases, solver, false);
    return static_cast<double>(count.found) >= share * static_cast<double>(count.planned);
  });
}

Section best_known_section(const BestKnownSetup& setup, const std::vector<BestKnownCase>& cases) {
  Section section;
  section.name = "best_known";
  section.title = "How often a normal search finds the best known plan";
  section.prose.push_back(fmt::format(
      "Random scenes {} to {}, each planned by the normal search of every solver and by {} fast ones from random "
      "shapes of two arcs. The best plan of all is the best known; it is found where the objective is higher by no "
      "more than {:g} of its size, or by {:g} of the largest weight.",
      setup.first, setup.last, setup.starts, same_objective, margin_of(0.0)));
  Table counts{"best_known", "Scenes", {"solver", "scenes", "with a plan", "best known", "%"}, {}, true};
  Table missed{"best_known_missed",
               "Missed",
               {"solver", "seed", "objective", "best known", "best that does not overlap", "scene"},
               {},
               true};
  Table all{"best_known_cases",
            "Every scene",
            {"seed", "solver", "objective", "best known", "best that does not overlap", "starts solved", "scene"},
            {},
            false};
  for (const std::string& solver : setup.solvers) {
    for (const bool simple : {false, true}) {
      const Count count = counted(cases, solver, simple);
      if (count.planned == 0) continue;
      counts.rows.push_back({solver, simple ? "one moment, one obstacle" : "all", count.planned, count.found,
                             100.0 * static_cast<double>(count.found) / static_cast<double>(count.planned)});
    }
    for (const BestKnownCase& c : cases) {
      const auto own = c.objectives.find(solver);
      const double objective = own == c.objectives.end() ? std::nan("") : own->second;
      const auto seed = static_cast<std::int64_t>(c.seed);
      all.rows.push_back({seed, solver, objective, c.best, c.best_apart, std::int64_t{c.solved}, c.summary});
      if (std::isfinite(c.best) && !c.found(solver))
        missed.rows.push_back({solver, seed, objective, c.best, c.best_apart, c.summary});
    }
  }
  section.tables = {counts, missed, all};
  return section;
}

}  // namespace tendril::bench
