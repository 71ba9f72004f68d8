#include "tendril/plugins/components.hpp"

#include <utility>

#include "tendril/pivot.hpp"
#include "use_guard.hpp"

namespace tendril::plugins {

namespace {

void run(const Located& at, const std::string& path, const std::function<void()>& step) {
  if (at) {
    at(path, step);
  } else {
    step();
  }
}

std::string numbered(const char* table, std::size_t i) { return std::string(table) + '[' + std::to_string(i) + ']'; }

/// What came from elsewhere is guarded in use; what core brings along needs no guard.
template <class Interface>
std::unique_ptr<Interface> guarded_if_foreign(const Registry& registry, ComponentKind kind, const std::string& name,
                                              std::unique_ptr<Interface> made) {
  const std::string origin = registry.origin(kind, name);
  return origin.empty() ? std::move(made) : guarded(std::move(made), origin);
}

/// Makes components of one scene, each with its options resolved.
struct Maker {
  const Scene& scene;
  Scale scale = scale_of(scene);

  template <class Component>
  auto operator()(const Component& component, const RawOptions& options, const std::string& kind) const {
    return component.make(
        resolve_options(component.options, options, scale, scene.read_quantity, kind + " '" + component.name + "'"));
  }
};

}  // namespace

std::vector<std::unique_ptr<Obstacle>> make_obstacles(Registry& registry, const Scene& scene, const Located& at) {
  const Maker make{scene};
  std::vector<std::unique_ptr<Obstacle>> made;
  for (std::size_t i = 0; i < scene.obstacles.size(); ++i) {
    const ObstacleSpec& spec = scene.obstacles[i];
    run(at, numbered("obstacle", i), [&] {
      RawOptions own = spec.options;
      RawOptions pivot;
      if (auto given = own.extract(pivot_option().name)) pivot.insert(std::move(given));
      made.push_back(guarded_if_foreign(registry, ComponentKind::obstacle, spec.shape,
                                        make(registry.obstacle(spec.shape), own, "obstacle shape")));
      const Vec2 shift = (1.0 / make.scale.length) * spec.place.shift;
      if (pivot.empty()) {
        made.back() = moved(std::move(made.back()), shift, spec.place.turn);
        return;
      }
      const Options options = resolve_options({pivot_option()}, pivot, make.scale, scene.read_quantity, spec.shape);
      const NumberTable& pivoted = options.table(pivot_option().name);
      made.back() = moved_about(std::move(made.back()), {pivoted(0, 0), pivoted(0, 1)}, shift, spec.place.turn);
    });
  }
  return made;
}

Components make_components(Registry& registry, const Scene& scene, const Located& at) {
  const Maker make{scene};
  Components made;
  run(at, "coordinates", [&] {
    made.coordinates = guarded_if_foreign(
        registry, ComponentKind::coordinates, scene.coordinates.plugin,
        make(registry.coordinates(scene.coordinates.plugin), scene.coordinates.options, "coordinates plugin"));
  });
  if (needs_obstacles(scene)) made.obstacles = make_obstacles(registry, scene, at);
  for (std::size_t i = 0; i < scene.objectives.size(); ++i) {
    const ObjectiveSpec& spec = scene.objectives[i];
    if (!needs_term(spec)) {
      made.terms.push_back(nullptr);
      continue;
    }
    run(at, numbered("objective", i), [&] {
      made.terms.push_back(guarded_if_foreign(registry, ComponentKind::objective, spec.plugin,
                                              make(registry.objective(spec.plugin), spec.options, "objective plugin")));
    });
  }
  const SolverComponent* solver = nullptr;
  run(at, "solver", [&] { solver = &registry.solver(scene.solver.plugin); });
  // A solver's options stand one table deeper than those of other components.
  run(at, "solver.options", [&] { made.solver = make(*solver, scene.solver.options, "solver plugin"); });
  return made;
}

}  // namespace tendril::plugins
