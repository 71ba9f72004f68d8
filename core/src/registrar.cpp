#include "tendril/registrar.hpp"

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

}  // namespace tendril
