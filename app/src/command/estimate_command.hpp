#pragma once

#include "tendril/app/commands.hpp"

namespace tendril::app {

/// Estimates the contacts of a session's scene and writes what run_plan() writes of a plan. Exit code 0: every contact
/// that the points show is identifiable.
int run_estimate(Session& session, const PlanArguments& arguments);

}  // namespace tendril::app
