#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "tendril/app/session.hpp"
#include "tendril/files/scene_file.hpp"

namespace tendril::app {

using files::InputKind;
using files::Inputs;

/// Of the command line that says what moves the actuators.
const char* option_of(InputKind kind);

/// One moment (N m) per actuator of the session's scene. Throws InputError.
std::vector<double> moments_of(const Inputs& inputs, const Session& session);
/// Where they move the rod to. Throws InputError.
RodPlace place_of(const Inputs& inputs, const Session& session);
/// Both, as of a plan. Where they only move the rod, moments are those of `start`.
Plan held_of(const Inputs& inputs, const Session& session, const std::optional<Plan>& start);

/// Whether they are several lists between semicolons, which follow one another.
bool are_way_points(const Inputs& inputs);
/// A step, without a target that the scene has not, for each of these lists; what is given once is the same for all.
/// Throws InputError.
std::vector<TrajectoryStep> way_points_of(const Inputs& inputs, const Session& session,
                                          const std::optional<Plan>& start);

/// The moments of an earlier result carried out: those of a plan, or those of each step of a trajectory.
/// `moved`: where the rod is moved to instead; of a plan also one place after the other.
std::variant<Execution, Trajectory> execute_result(Session& session, const files::ResultText& earlier,
                                                   const std::optional<Plan>& start, const Inputs& moved = {});

}  // namespace tendril::app
