#include "execute_support.hpp"

#include <numbers>
#include <string>

#include "obstacle/circle.hpp"

namespace tendril::support {

ForwardScene::ForwardScene() {
  scene.rod.segments.push_back({1.0, 1.0, 0.0, 0.0});
  ActuatorSpec actuator;
  actuator.to = 1.0;
  scene.rod.actuators.push_back(actuator);
  scene.coordinates.plugin = "legendre";
  scene.solver.plugin = "none";
}

ForwardScene& ForwardScene::circle(double x, double y, double radius) {
  ObstacleSpec spec;
  spec.name = "circle " + std::to_string(obstacles.size() + 1);
  spec.shape = "circle";
  scene.obstacles.push_back(spec);
  obstacles.push_back(std::make_unique<Circle>(Vec2{x, y}, radius));
  return *this;
}

ForwardScene& ForwardScene::weight(double value) {
  for (SegmentSpec& s : scene.rod.segments) s.linear_density = value;
  scene.gravity = Vec2{0.0, -1.0};
  return *this;
}

Execution ForwardScene::run(const std::vector<double>& moments, const Plan* start) const {
  ExecuteControl control;
  control.start = start;
  control.time_limit = infinity;  // however busy the machine is
  return execute(scene, obstacles, moments, control);
}

std::function<double(double)> angle_of(const Plan& plan) {
  return [points = plan.backbone](double s) {
    std::size_t i = 1;
    while (i + 1 < points.size() && points[i].s < s) ++i;
    const double share = (s - points[i - 1].s) / (points[i].s - points[i - 1].s);
    return points[i - 1].angle + share * (points[i].angle - points[i - 1].angle);
  };
}

ForwardScene unit_braced_arm() {
  ForwardScene s;
  s.weight(1.682);
  s.circle(0.6, 0.0, 0.08);
  s.scene.start_tip_angle = 0.5;
  return s;
}

ForwardScene braced_arm() {
  ForwardScene s;
  s.scene.rod.segments = {{0.1, 4.9e-4, 0.084, 0.0}};
  s.scene.rod.actuators[0].to = 0.1;
  s.scene.gravity = Vec2{0.0, -9.81};
  s.circle(0.6, 0.0, 0.08);
  s.scene.start_tip_angle = 0.5;
  return s;
}

ForwardScene upright(double weight) {
  ForwardScene s;
  s.weight(weight);
  s.scene.rod.base_angle = 0.5 * std::numbers::pi;
  return s;
}

}  // namespace tendril::support
