#include "tendril/registrar.hpp"

#include "obstacle/shape_options.hpp"

namespace tendril {

std::string_view to_string(ComponentKind kind) {
  switch (kind) {
    case ComponentKind::coordinates:
      return "coordinates";
    case ComponentKind::objective:
      return "objective";
    case ComponentKind::obstacle:
      return "obstacle";
    case ComponentKind::solver:
      return "solver";
  }
  return "unknown";
}

Registrar::~Registrar() = default;

void register_builtin_obstacles(Registrar& registrar) {
  registrar.add(circle_component());
  registrar.add(wall_component());
  registrar.add(capsule_component());
  registrar.add(polygon_component());
  registrar.add(channel_component());
}

}  // namespace tendril
