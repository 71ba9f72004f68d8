#pragma once

#include <string>
#include <vector>

#include "tendril/geometry.hpp"

/// Parts of scenes as text, in SI units. Most extreme cases have L = 1 m and EI = 1 N m^2, so that all numbers are
/// dimensionless.
namespace tendril::bench::scene_text {

/// Downwards, of this size.
std::string gravity_of(double size);

/// A segment of a rod.
struct SegmentText {
  double length, stiffness, density, rest_curvature;
};
std::string rod(const std::vector<SegmentText>& segments);
/// A uniform rod with L = EI = 1.
std::string unit_rod(double weight = 0.0);

std::string actuator(double low, double high, double from = 0.0, double to = 1.0);
std::string tip_force(double x, double y);
/// A start of constant curvature with this tip angle.
std::string start(double angle);
std::string target(double x, double y);

std::string circle(double x, double y, double radius);
/// A horizontal wall; `up`: above 0 if its normal points up, else down.
std::string wall(double y, double up);
std::string capsule(Vec2 from, Vec2 to, double radius);
std::string contact(const char* mode, int count = 1);

/// The terms tip_pose and actuation_effort with these weights.
std::string weighted(double tip, double effort);

/// The arm of the exact table over a peg, in any units, without its target. `limit`: of its moment where L = 0.1 m and
/// EI = 4.9e-4 N m^2.
std::string arm_over(const std::string& peg, double length, double stiffness, double limit = 0.0025);

}  // namespace tendril::bench::scene_text
