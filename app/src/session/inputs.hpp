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

/// Whether they are several lists between semicolons, which follow one another.
inline bool are_way_points(const Inputs& inputs) { return inputs.text.find(';') != std::string::npos; }
/// A step, without a target that the scene has not, for each of these lists.
/// Throws InputError.
std::vector<TrajectoryStep> way_points_of(const Inputs& inputs, const Session& session);

/// The moments of an earlier result carried out: those of a plan, or those of each step of a trajectory.
std::variant<Execution, Trajectory> execute_result(Session& session, const files::ResultText& earlier,
                                                   const std::optional<Plan>& start);

}  // namespace tendril::app
