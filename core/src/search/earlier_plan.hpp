#pragma once

#include <optional>
#include <vector>

#include "search/task.hpp"

/// What an earlier plan says about the programs of a problem.
namespace tendril {

/// A contact this near (in L) to the end of its stretch leans against it.
inline constexpr double at_knot = 1e-7;

/// The contacts that hold the plan, interior ones along the rod, then the tip; nothing if this scene cannot have them.
std::optional<std::vector<ContactSetup>> contacts_of(const Task& problem, const Plan& plan);

/// Shape, moments and contacts of the plan, as far as `mode` has them.
StartShape shape_of(const Task& problem, const Plan& plan, const Mode& mode);

/// The plan's own point in a program that touches what the plan touched.
struct FollowedPoint {
  Mode mode{};
  std::vector<int> regions{};        ///< of the contacts, see Task::spec
  std::vector<CheckPoint> checks{};  ///< with those where the plan grazes an obstacle
  Eigen::VectorXd x{};
};
/// Nothing where the plan has other coordinates, was not certified, or has a contact that does not press. Without
/// `with_checks` nothing is said of where the plan grazes an obstacle.
std::optional<FollowedPoint> followed_point(const Task& problem, const Plan& earlier, bool with_checks = true);

/// Whether no contact is about to come or go at x of a program whose contacts all touch. If one may, other ways of
/// being in contact know more about it.
bool contacts_unchanged(const Task& problem, PoseProgram& program, ConstVectorRef x);

}  // namespace tendril
