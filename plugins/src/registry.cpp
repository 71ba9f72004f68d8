#include "tendril/plugins/registry.hpp"

#include <algorithm>

namespace tendril::plugins {

namespace {

/// Takes core's shapes; core registers nothing else.
class ObstacleCollector : public Registrar {
 public:
  void add(CoordinateComponent) override {}
  void add(ObjectiveComponent) override {}
  void add(SolverComponent) override {}
  void add(ObstacleComponent component) override {
    std::string name = component.name;
    obstacles.insert_or_assign(std::move(name), std::move(component));
  }
  std::map<std::string, ObstacleComponent, std::less<>> obstacles;
};

}  // namespace

Registry::Registry(Catalog catalog) : catalog_(std::move(catalog)) {
  ObstacleCollector collector;
  register_builtin_obstacles(collector);
  builtin_obstacles_ = std::move(collector.obstacles);
}

const AnyComponent& Registry::component(ComponentKind kind, std::string_view name) {
  std::pair key(kind, std::string(name));
  if (const auto found = components_.find(key); found != components_.end()) return found->second;
  const std::vector<std::string> more =
      kind == ComponentKind::obstacle ? builtin_obstacles() : std::vector<std::string>{};
  const PluginFile& file = catalog_.find(kind, name, more);
  const auto added = components_.emplace(std::move(key), open_plugin(file)).first;
  opened_.push_back({kind, file.name, file.path});
  return added->second;
}

const CoordinateComponent& Registry::coordinates(std::string_view name) {
  return std::get<CoordinateComponent>(component(ComponentKind::coordinates, name));
}

const ObjectiveComponent& Registry::objective(std::string_view name) {
  return std::get<ObjectiveComponent>(component(ComponentKind::objective, name));
}

const ObstacleComponent& Registry::obstacle(std::string_view name) {
  if (const auto shape = builtin_obstacles_.find(name); shape != builtin_obstacles_.end()) return shape->second;
  return std::get<ObstacleComponent>(component(ComponentKind::obstacle, name));
}

const SolverComponent& Registry::solver(std::string_view name) {
  return std::get<SolverComponent>(component(ComponentKind::solver, name));
}

std::vector<std::string> Registry::builtin_obstacles() const {
  std::vector<std::string> names;
  for (const auto& [name, component] : builtin_obstacles_) names.push_back(name);
  return names;
}

std::vector<std::string> Registry::names(ComponentKind kind) const {
  std::vector<std::string> names = catalog_.names(kind);
  if (kind == ComponentKind::obstacle) {
    for (std::string& name : builtin_obstacles()) names.push_back(std::move(name));
    std::sort(names.begin(), names.end());
    names.erase(std::unique(names.begin(), names.end()), names.end());
  }
  return names;
}

}  // namespace tendril::plugins
