#pragma once

#include <optional>
#include <string_view>

#include "result_object.hpp"
#include "tendril/app/figure.hpp"

namespace tendril::app {

/// Pressure of each actuator (Pa) under `moments`; none where the scene does not say what moment a pressure gives.
std::vector<std::optional<double>> pressures_of(const Scene& scene, const std::vector<double>& moments);

/// "closing" or "opening" (the upper finger: negative or positive); empty for a moment that is no more than rounding.
std::string_view turning(const Scene& scene, double moment);

/// Adds "pressures" if a scene knows them, and what only a grasp has.
void add_grasp(Json& json, const Scene& scene, const Plan& plan);

/// The same for people; empty for a plan that is no grasp.
std::string grasp_text(const Scene& scene, const Plan& plan);

/// Puts the object and the other finger of a grasp into a figure of its plan.
void add_gripper(FigureScene& figure, const Scene& scene, const Plan& plan);

}  // namespace tendril::app
