#pragma once

#include <cstdint>
#include <set>
#include <string>

namespace tendril::bench {

/// A scene drawn at random, and in a few words what was drawn.
struct RandomScene {
  std::string text;     ///< TOML, as a user would write it
  std::string summary;  ///< "legendre 6, 2 segments, w 12, ..."
};

/// The scene of a seed: a planar pose of any size in SI, millimetre or inch units, with loads, segments, actuators,
/// obstacles of every kind, a target, a coordinate model and a treatment of complementarity. The same on every machine.
///
/// Ranges (lengths in L, loads in EI/L^2): EI 1e-12 to 1e6 N m^2, L 1 mm to 100 m, self-weight to 1e4, tip force to
/// 1e3, stiffness jumps to 1e6, segments of 1e-3 and more, rest curvature to two turns, obstacle radius 1e-6 to 1e4,
/// force limits to 1e4, targets to 1e3, weights 1e-12 to 1e12. Most draws are from the middle of these ranges.
/// `plugins`: names of the coordinate models and objectives at hand. In place of a model that is missing the scene's
/// default is taken, and a missing objective is left out.
/// `outlines`: obstacles are polygons that are not convex: stars, bars with notches, and rooms around the base.
/// `friction`: contacts rub where the scene plans any, with coefficients of 1e-6 to 10, and their state is planned as
/// "range", "worst" or "any"; everything else is the scene without it.
RandomScene random_scene(std::uint64_t seed, const std::string& solver, double time_limit,
                         const std::set<std::string>& plugins, bool outlines = false, bool friction = false);

}  // namespace tendril::bench
