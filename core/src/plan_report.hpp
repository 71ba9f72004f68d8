#pragma once

#include <string>
#include <vector>

#include "tendril/plan.hpp"
#include "tendril/pose_program.hpp"
#include "tendril/rod.hpp"
#include "tendril/scale.hpp"

namespace tendril {

/// The shape of a program's point computed last as points in SI units, at least 100 of them, every knot included.
std::vector<BackbonePoint> sampled_backbone(const PoseProgram& program, double length);

/// The contacts of a program's point computed last in SI units.
std::vector<PlannedContact> planned_contacts(const PoseProgram& program, const std::vector<std::string>& obstacle_names,
                                             const Scale& scale);

/// The shape of a start, integrated by midpoints: a line for the figure.
std::vector<BackbonePoint> outline(const StartShape& shape, const Rod& rod, double length);

/// The curvature of an earlier plan of a rod of this length (m), dimensionless, over s/L.
std::function<double(double)> curvature_of(const Plan& plan, double length);

/// What a scene calls its obstacles, or "obstacle 1", ...
std::vector<std::string> obstacle_names(const Scene& scene);

}  // namespace tendril
