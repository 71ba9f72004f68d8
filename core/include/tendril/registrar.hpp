#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

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

/// What a component says of itself, and how to make one.
template <class Interface>
struct Component {
  std::string name;                                                ///< as scenes write it: lower case, digits, '_'
  std::string description;                                         ///< one line
  OptionSchema options;                                            ///< what a scene may set
  std::function<std::unique_ptr<Interface>(const Options&)> make;  ///< from checked, dimensionless options
};

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

}  // namespace tendril
