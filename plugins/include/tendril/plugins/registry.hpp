#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "tendril/plugins/catalog.hpp"
#include "tendril/plugins/error.hpp"
#include "tendril/registrar.hpp"

namespace tendril::plugins {

/// A component of any kind.
using AnyComponent = std::variant<CoordinateComponent, ObjectiveComponent, ObstacleComponent, SolverComponent>;

/// Hands components to a registrar, as a plugin does, but out of the program itself.
using ComponentSource = std::function<void(Registrar&)>;

/// Opens one plugin, compares the handshake, lets it register, and checks what it registered. Throws PluginError. The
/// library is never unloaded. An exception from the component's factory leaves `make` as a PluginError that names the
/// file, except an OptionError, which is the scene's fault.
AnyComponent open_plugin(const PluginFile& file);

/// Hands out components by name and opens a plugin when it is first asked for. Not for concurrent use.
class Registry {
 public:
  /// Opens nothing yet. `provide` hands over components that need no plugin. Throws PluginError (wrong_component) where
  /// one of them is named like another one, like a shape of core, or like a plugin.
  explicit Registry(Catalog catalog, const ComponentSource& provide = {});

  /// Throw PluginError when there is no such plugin or it cannot be opened. References live as long as the registry.
  const CoordinateComponent& coordinates(std::string_view name);
  const ObjectiveComponent& objective(std::string_view name);  ///< Likewise.
  /// The shapes of core need no plugin, and no plugin replaces them.
  const ObstacleComponent& obstacle(std::string_view name);
  const SolverComponent& solver(std::string_view name);  ///< Likewise.

  /// A plugin that was opened.
  struct Opened {
    ComponentKind kind{};        ///< what it is
    std::string name;            ///< as scenes write it
    std::filesystem::path file;  ///< where it was found
  };
  /// The plugins opened so far, in order.
  const std::vector<Opened>& opened() const { return opened_; }

  /// Names of one kind that can be asked for, sorted; core's shapes and components that were provided too.
  std::vector<std::string> names(ComponentKind kind) const;
  /// Names of the shapes that core brings along, sorted.
  std::vector<std::string> builtin_obstacles() const;
  /// How messages name a component that is not core's: as a plugin with its file, or as provided; empty: it is core's,
  /// or was not asked for yet.
  std::string origin(ComponentKind kind, std::string_view name) const;
  /// What can be asked for, and where it was looked for.
  const Catalog& catalog() const { return catalog_; }

 private:
  const AnyComponent& component(ComponentKind kind, std::string_view name);
  std::vector<std::string> provided(ComponentKind kind) const;

  Catalog catalog_;
  std::set<std::pair<ComponentKind, std::string>> provided_;
  std::map<std::string, ObstacleComponent, std::less<>> builtin_obstacles_;
  std::map<std::pair<ComponentKind, std::string>, AnyComponent> components_;
  std::vector<Opened> opened_;
};

}  // namespace tendril::plugins
