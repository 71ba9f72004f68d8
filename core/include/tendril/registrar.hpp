#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "tendril/coordinate_model.hpp"
#include "tendril/objective_term.hpp"
#include "tendril/obstacle.hpp"
#include "tendril/options.hpp"
#include "tendril/solver.hpp"

namespace tendril {

/// What a component is.
enum class ComponentKind { coordinates, objective, obstacle, solver };

/// "coordinates", "objective", "obstacle", "solver": also the middle word of a plugin's file name.
TENDRIL_API std::string_view to_string(ComponentKind kind);

using CoordinateComponent = Component<CoordinateModel>;  ///< A coordinate model.
using ObjectiveComponent = Component<ObjectiveTerm>;     ///< An objective term.
using ObstacleComponent = Component<Obstacle>;           ///< An obstacle shape.
using SolverComponent = Component<Solver>;               ///< A solver backend.

/// Handed to a plugin while it is loaded; takes its component.
class TENDRIL_API Registrar {
 public:
  virtual ~Registrar();
  virtual void add(CoordinateComponent component) = 0;  ///< a coordinate model
  virtual void add(ObjectiveComponent component) = 0;   ///< an objective term
  virtual void add(ObstacleComponent component) = 0;    ///< an obstacle shape
  virtual void add(SolverComponent component) = 0;      ///< a solver
};

/// Hands the shapes that core brings along (circle, ...) to `registrar`.
TENDRIL_API void register_builtin_obstacles(Registrar& registrar);

/// The components that a scene names, made by whoever can load them. Order as in the scene.
struct Components {
  std::unique_ptr<CoordinateModel> coordinates;       ///< never null
  std::vector<std::unique_ptr<Obstacle>> obstacles;   ///< all of them, or none if needs_obstacles() is false
  std::vector<std::unique_ptr<ObjectiveTerm>> terms;  ///< one per objective of the scene; null where its weight is 0
  std::unique_ptr<Solver> solver;                     ///< never null
};

}  // namespace tendril
