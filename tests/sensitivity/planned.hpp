#pragma once

#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tendril/app/session.hpp"

namespace tendril::app::test {

using Settings = std::vector<std::pair<std::string, std::string>>;

/// The braced arm with no number that is zero.
inline const std::string arm = R"(
problem = "pose"
gravity = ["0.5 m/s^2", "-9.81 m/s^2"]
[rod]
length = "100 mm"
bending_stiffness = "4.9e-4 N m^2"
linear_density = "84 g/m"
rest_curvature = "1.5 1/m"
base = {position = ["1 mm", "-2 mm"], angle = "3 deg"}
[[rod.actuator]]
limit = "20 N mm"
[coordinates]
plugin = "legendre"
[start]
tip_angle = "0.5 rad"
[tip_load]
mass = "0.5 g"
force = ["4 mN", "-3 mN"]
[[obstacle]]
shape = "circle"
center = ["60 mm", "0.5 mm"]
radius = "8 mm"
[contact]
max_force = "1 N"
[target]
position = ["97 mm", "20 mm"]
[[objective]]
plugin = "tip_pose"
weight = 100
[[objective]]
plugin = "actuation_effort"
weight = 1e-3
[solver]
plugin = ")" TENDRIL_TEST_SOLVER R"("
)";

inline SceneArguments arguments_of(const std::string& text, const Settings& settings) {
  SceneArguments arguments{"scene.toml", {}, {}, text};
  for (const auto& [key, value] : settings) arguments.overrides.push_back({key, key, value});
  return arguments;
}

/// Text such as "8 mm" with another number.
inline std::string with_number(const std::string& text, double number) {
  const auto blank = text.find(' ');
  char shown[64];
  std::snprintf(shown, sizeof shown, "%.17g", number);
  return shown + (blank == std::string::npos ? std::string() : text.substr(blank));
}

/// SI per unit that a text is written in.
inline double unit_of(const std::string& text) {
  static const std::map<std::string, double> units{
      {"mm", 1e-3}, {"g/m", 1e-3},  {"N m^2", 1.0}, {"m/s^2", 1.0}, {"1/m", 1.0},    {"mN", 1e-3},
      {"g", 1e-3},  {"N mm", 1e-3}, {"N", 1.0},     {"MPa", 1e6},   {"kg/m^3", 1.0}, {"deg", std::acos(-1.0) / 180.0}};
  const auto blank = text.find(' ');
  return blank == std::string::npos ? 1.0 : units.at(text.substr(blank + 1));
}

/// What a sensitivity differentiates, of a plan or of what was executed.
inline std::vector<double> quantities(const Plan& plan, bool planned) {
  std::vector<double> all{plan.tip_x, plan.tip_y, plan.tip_angle};
  for (const PlannedContact& c : plan.contacts) {
    if (!(c.force > 0.0)) continue;
    all.push_back(c.force);
    if (!c.at_tip) all.push_back(c.arc_length);
  }
  if (!planned) return all;
  all.insert(all.end(), plan.moments.begin(), plan.moments.end());
  all.push_back(plan.objective);
  return all;
}

}  // namespace tendril::app::test
