#pragma once

#include "tendril/app/commands.hpp"

namespace tendril::app {

/// `tendril plan` for a scene with problem = "trajectory".
int run_trajectory(Session& session, const PlanArguments& arguments);

/// Writes and shows what was planned or carried out, and returns the exit code. `strict` as in PlanArguments.
int give_trajectory(Session& session, const Trajectory& trajectory, const ResultPlaces& places, bool strict = false);

}  // namespace tendril::app
