#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "result/result_object.hpp"
#include "tendril/plan.hpp"
#include "tendril/scene.hpp"

namespace tendril::app {

/// A finger of a plan, as results show it.
struct ShownFinger {
  std::string name;  ///< "upper" or "lower"; empty: the plan has one rod, or its other finger is the mirror image
  RodSpec rod;
  FingerPlan state;
};

/// The rod of a plan, or both fingers where both are planned.
std::vector<ShownFinger> fingers_of(const Scene& scene, const Plan& plan);

/// One per actuator (N m), those of the lower finger behind those of the upper one.
std::vector<double> all_moments(const Plan& plan);

/// The same of what execution holds: moments, and shortenings (m) of tendons told their length.
std::vector<double> all_held(const Scene& scene, const Plan& plan);

/// Where the lower finger was moved to; nowhere where it is a mirror image.
RodPlace lower_place_of(const Plan& plan);

/// What the moments of a plan of the scene belong to: the actuators of the rod, or of both fingers.
std::vector<ActuatorSpec> actuators_of(const Scene& scene);

/// An actuator as results show it.
struct ShownActuator {
  std::string finger;      ///< as ShownFinger::name
  std::size_t number = 0;  ///< of its rod, from 1
  const char* where = "";  ///< "inside", "at its limit", "beyond its limit", by the tolerance of the certificate
  double moment = 0.0, lowest = 0.0, highest = 0.0;  ///< N m
  ActuatorSpec spec{};
  double shortening = 0.0;  ///< m, of a tendon

  /// Tension, pressure or moment under a moment.
  double input_of(double m) const { return spec.input_of(m) + 0.0; }
  /// What it is told.
  double input() const { return spec.by_length ? shortening : input_of(moment); }
  bool is(ActuatorKind kind) const { return spec.input() == kind; }
};
std::vector<ShownActuator> shown_actuators(const Scene& scene, const Plan& plan);

/// Pressure of each actuator (Pa) under the plan's moments; none where the scene does not say what moment a pressure
/// gives.
std::vector<std::optional<double>> pressures_of(const Scene& scene, const Plan& plan);

/// Whether a planned contact is one: it pushes, or the rod is at the obstacle. A plan may have left it.
bool touches(const Scene& scene, const PlannedContact& contact);

/// "closing" or "opening" (the upper finger: negative or positive); empty for a moment that is no more than rounding.
std::string_view turning(const Scene& scene, double moment);

/// What the contacts of a state of friction leave on the object where it is, N.
Vec2 force_on_object(const Scene& scene, const Plan& plan, const FrictionRange& state);

/// Adds "inputs", "pressures" if a scene knows them, and what only a grasp has.
void add_grasp(Json& json, const Scene& scene, const Plan& plan);

/// The same for people; empty for a plan that is no grasp.
std::string grasp_text(const Scene& scene, const Plan& plan);

}  // namespace tendril::app
