#pragma once

#include <string>
#include <vector>

#include "result/json_reader.hpp"
#include "tendril/backbone_point.hpp"
#include "tendril/scene.hpp"

namespace tendril::app {

/// What a result says of the shape of a rod. All throw InputError where it is none.

std::vector<BackbonePoint> backbone_of(const Reader& state, const std::string& name = "backbone");
/// Half the diameters that a state lists for its points, between these in proportion; empty: it has no body.
BodyRadius radius_of(const Reader& state);
std::vector<Vec2> points_in(const Reader& list);
/// Of the first rod that came to a shape; 0: none did.
double length_of(const Reader& result);

std::vector<Vec2> line_of(const std::vector<BackbonePoint>& backbone);
/// Across the normal of a contact, in the direction in which arc lengths grow.
Vec2 tangent_at(const std::vector<BackbonePoint>& backbone, double arc_length, Vec2 normal);

}  // namespace tendril::app
