#pragma once

#include <vector>

#include "certificate/certifier.hpp"
#include "program/pose_program.hpp"

/// Which points of the rod a program keeps outside of obstacles: few, moved to where the true shape comes nearest.
namespace tendril {

/// Half of the depth that is allowed (in L): a valley of the distance below it gets a check point.
inline constexpr double violation_level = -5e-10;
/// A plan this near to an obstacle (in L) leans on a clearance row.
inline constexpr double grazing_level = 1e-6;
/// No check point this near (in L) to a touching contact's own obstacle.
inline constexpr double contact_neighbourhood = 0.02;

/// Valleys that get a check point at a time, each a row of a dense matrix. Seen: 124,484 of a rod that winds on and on,
/// a matrix that no memory holds.
inline constexpr std::size_t most_new_checks = 100;

/// Moves or adds a check point for every valley of the distance below `level` at x, for the deepest ones of very many.
/// False: there was none.
bool exchange_checks(const PoseProgram& program, ConstVectorRef x, Certifier& certifier,
                     std::vector<CheckPoint>& checks, double level, bool keep = false);

/// Each of them once, in order.
void keep_unique(std::vector<CheckPoint>& checks);

}  // namespace tendril
