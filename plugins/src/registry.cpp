#include "tendril/plugins/registry.hpp"

#include <algorithm>

#include "kinds.hpp"

namespace tendril::plugins {

namespace {

/// Takes what a program registers.
class AllRegistered : public Registrar {
 public:
  void add(CoordinateComponent component) override { all.emplace_back(std::move(component)); }
  void add(ObjectiveComponent component) override { all.emplace_back(std::move(component)); }
  void add(ObstacleComponent component) override { all.emplace_back(std::move(component)); }
  void add(SolverComponent component) override { all.emplace_back(std::move(component)); }
  std::vector<AnyComponent> all;
};

}  // namespace

Registry::Registry(Catalog catalog, const ComponentSource& provide) : catalog_(std::move(catalog)) {
  AllRegistered shapes;
  register_builtin_obstacles(shapes);
  for (AnyComponent& shape : shapes.all) {
    auto& component = std::get<ObstacleComponent>(shape);
    std::string name = component.name;
    builtin_obstacles_.insert_or_assign(std::move(name), std::move(component));
  }
  AllRegistered own;
  if (provide) provide(own);
  for (AnyComponent& component : own.all) {
    const ComponentKind kind = kinds[component.index()];
    const std::string name = std::visit([](const auto& c) { return c.name; }, component);
    const std::vector<std::string> taken = names(kind);
    const auto refuse = [&](const std::string& reason) {
      throw PluginError(Failure::wrong_component, std::string(to_string(kind)) + " '" + name + "' " + reason);
    };
    if (!parse_file_name(file_name(kind, name))) {
      refuse("is no name of a component: lower-case letters, digits and '_' are, a letter first");
    }
    if (std::find(taken.begin(), taken.end(), name) != taken.end()) refuse("is there already; expected another name");
    provided_.emplace(kind, name);
    components_.emplace(std::pair(kind, name), std::move(component));
  }
}

std::string Registry::origin(ComponentKind kind, std::string_view name) const {
  const std::string shown = std::string(to_string(kind)) + " ";
  for (const Opened& plugin : opened_) {
    if (plugin.kind == kind && plugin.name == name) {
      return shown + "plugin '" + plugin.name + "' (" + plugin.file.string() + ")";
    }
  }
  if (provided_.count(std::pair(kind, std::string(name))) == 0) return "";
  return shown + "'" + std::string(name) + "' of this program";
}

std::vector<std::string> Registry::provided(ComponentKind kind) const {
  std::vector<std::string> names;
  for (const auto& [of, name] : provided_) {
    if (of == kind) names.push_back(name);
  }
  return names;
}

const AnyComponent& Registry::component(ComponentKind kind, std::string_view name) {
  std::pair key(kind, std::string(name));
  if (const auto found = components_.find(key); found != components_.end()) return found->second;
  const std::vector<std::string> known = names(kind);
  const PluginFile& file = catalog_.find(kind, name, known);
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
  for (std::string& name : provided(kind)) names.push_back(std::move(name));
  if (kind == ComponentKind::obstacle) {
    for (std::string& name : builtin_obstacles()) names.push_back(std::move(name));
  }
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

}  // namespace tendril::plugins
