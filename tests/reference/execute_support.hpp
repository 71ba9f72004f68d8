#pragma once

#include <functional>
#include <memory>
#include <numbers>
#include <vector>

#include "tendril/execute.hpp"
#include "tendril/obstacle.hpp"
#include "tendril/scene.hpp"

/// Scenes for the forward problem, made in code. L = EI = 1 unless said.
namespace tendril::support {

constexpr double exact = 1e-8;  ///< of L; what the forward problem promises
/// EI/L^2. Under this load a straight clamped rod gives way.
constexpr double euler = 0.25 * std::numbers::pi * std::numbers::pi;

struct ForwardScene {
  Scene scene;
  std::vector<std::unique_ptr<Obstacle>> obstacles;

  ForwardScene();
  ForwardScene& circle(double x, double y, double radius);
  /// Weight of the whole rod, pulling along -y.
  ForwardScene& weight(double value);
  Execution run(const std::vector<double>& moments, const Plan* start = nullptr) const;
};

/// The executed backbone angle, between its samples: a start for other methods.
std::function<double(double)> angle_of(const Plan& plan);

/// The arm of data/braced_arm.csv, on top of its circle.
ForwardScene braced_arm();

/// An arm under gravity above a peg, as in the table of the braced arm but with L = EI = 1.
ForwardScene unit_braced_arm();

/// A rod clamped upright with a weight and one actuator.
ForwardScene upright(double weight);

}  // namespace tendril::support
