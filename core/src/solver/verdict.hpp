#pragma once

#include <vector>

#include "nlp/multipliers.hpp"
#include "tendril/solver.hpp"

namespace tendril {

/// How near counts as active: a point is as accurate as its rows are.
double active_tolerance(double violation);

/// What the first-order conditions say at the end, with the backend's multipliers or, where those are missing or worse,
/// with recovered ones.
/// `known`: the judgement of report.x with recovered multipliers, if there is one already; it is moved from.
void judge(NonlinearProgram& program, const SolveControl& control, const std::vector<double>& multipliers,
           const std::vector<double>& bound_multipliers, KktJudgement* known, OptimalityReport& report);

/// Lets the judgement overrule the backend's own word.
void weigh(NonlinearProgram& program, const SolveControl& control, OptimalityReport& report);

}  // namespace tendril
