#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "tendril/execute.hpp"
#include "tendril/obstacle.hpp"
#include "tendril/scene.hpp"

/// Scenes for the forward problem, made in code. L = EI = 1 unless said.
namespace tendril::support {

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

/// A rod clamped upright with a weight and one actuator.
ForwardScene upright(double weight);

}  // namespace tendril::support
