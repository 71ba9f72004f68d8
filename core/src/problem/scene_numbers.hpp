#pragma once

#include <functional>
#include <string>
#include <vector>

#include "program/motion.hpp"
#include "rod/rod.hpp"
#include "tendril/scale.hpp"
#include "tendril/scene.hpp"
#include "tendril/sensitivity.hpp"

namespace tendril {

/// How a dimensionless program follows a number of its scene, per unit (SI) of the number.
struct SceneChange {
  /// The rod where the number is larger by `share` times `step`. The program's rows are affine in its numbers, so that
  /// a difference is their rate; the bending energy is quadratic at most. Empty: it is the same.
  std::function<Rod(double share)> rod{};
  double step = 1.0;
  ProgramMotion motion{};
  bool moves = false;  ///< `motion` is not nothing
  Vec2 target{};
  double target_angle = 0.0;
  std::vector<double> lowest{}, highest{};  ///< of the actuators' moments; empty: they stay
  double least_force = 0.0, most_force = 0.0;
  int objective = -1;  ///< whose weight it is, of the scene; -1: of none
  double held = 0.0;   ///< of the moment of `actuator`
  int actuator = -1;
  double length = 0.0, stiffness = 0.0;  ///< relative, of the units L and EI0
  std::string trouble{};                 ///< why nothing is known of it
};

/// A number of a scene, and how to differentiate by it.
struct SceneEntry {
  SceneNumber number;
  std::function<SceneChange()> change;
};

/// Those of scene_numbers() with these keys, if not more; without keys all. What else is handed over is borrowed by the
/// changes.
std::vector<SceneEntry> scene_entries(const Scene& scene, const Scale& scale, const Rod& rod,
                                      const std::vector<std::string>& keys);
/// A moment that is held, N m.
SceneEntry held_moment(const Scene& scene, const Scale& scale, const Rod& rod, int actuator, double moment);

}  // namespace tendril
