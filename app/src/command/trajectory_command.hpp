#pragma once

#include "tendril/app/commands.hpp"

namespace tendril::app {

/// `tendril plan` for a scene with problem = "trajectory".
int run_trajectory(Session& session, const PlanArguments& arguments);

}  // namespace tendril::app
