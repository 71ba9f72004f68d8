#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "tendril/geometry.hpp"
#include "tendril/obstacle.hpp"
#include "tendril/plan.hpp"
#include "tendril/scene.hpp"
#include "tendril/uncertainty.hpp"

namespace tendril {

/// A number of a scene, SI.
struct SceneNumber {
  std::string key;     ///< "rod.bending_stiffness", "obstacle[0].center[1]"
  double value = 0.0;  ///< SI
  std::string unit;    ///< "m"; empty: a pure number
};

/// The numbers of a valid scene that its rod, loads, obstacles, limits, target and weights are made of, in the order of
/// the reference of keys. Segments of a uniform rod are called "rod", else "rod.segment[i]"; an actuator's limits
/// "minimum" and "maximum"; coefficients of x, x^2, ... of a property "more_bending_stiffness[0]" and so on.
TENDRIL_API std::vector<SceneNumber> scene_numbers(const Scene& scene);

/// First derivatives of a plan by numbers of its scene, SI.
struct TENDRIL_API Sensitivity {
  /// Derivatives by one number.
  struct Column {
    SceneNumber number;           ///< by which
    std::string trouble{};        ///< why there are none; empty: there are
    std::vector<double> rates{};  ///< of the quantities, in SI of both
    std::vector<Vec2> shape{};    ///< of the points of the backbone at `arc_lengths`
    double margin = 0.0;          ///< of the margin of stability, where moments are held
  };

  SensitivityKind kind = SensitivityKind::replanned;  ///< what stays where the number is another one
  std::string trouble{};                              ///< why there is no derivative at all; empty: there are
  std::vector<ResultQuantity> quantities{};           ///< what is differentiated
  std::vector<Column> columns{};                      ///< by what
  std::vector<double> arc_lengths{};                  ///< m
  double margin = 0.0;                                ///< of stability

  /// The column of a number; null: it has none.
  const Column* find(std::string_view key) const;
};

/// The derivatives of an execution's result by numbers of its scene, the moments held: `keys` of scene_numbers() or
/// "moments[i]", none for all of them. `obstacles` as in execute(). Where it has none the trouble says why. Throws
/// Error for an unknown key.
TENDRIL_API Sensitivity sensitivity_of(const Scene& scene, const std::vector<std::unique_ptr<Obstacle>>& obstacles,
                                       const Plan& executed, const std::vector<std::string>& keys = {});

/// What inputs of these deviations make of results with these derivatives.
TENDRIL_API Uncertainty uncertainty_of(const Sensitivity& sensitivity, const std::vector<Spread>& spreads);

}  // namespace tendril
