#pragma once

#include <functional>
#include <memory>
#include <string>

#include "combination/support.hpp"
#include "tendril/solver.hpp"

/// Solvers that do as they are told: the verdict of a search has to follow from what they said.
namespace tendril::search {

/// Ends every solve at its start, with this status and message. `before` is called at every solve.
std::unique_ptr<Solver> solver_that_ends_as(SolveStatus status, const std::string& message,
                                            std::function<void()> before = {});

/// Newton on the active set from the start.
std::unique_ptr<Solver> newton(std::function<void()> before = {});

/// A problem of `scene` with another solver than the scene's.
Problem problem_with(const Scene& scene, std::unique_ptr<Solver> solver);
Plan plan_with(const Scene& scene, std::unique_ptr<Solver> solver, const PlanControl& control = {});

/// The record of a mode; fails the test if there is none of this name.
ModeRecord record_of(const Plan& plan, const std::string& mode);

/// Whether `text` holds `part`; else the text.
testing::AssertionResult holds(const std::string& text, const std::string& part);
/// Whether the plan has this status; else what it says of itself.
testing::AssertionResult ended_as(const Plan& plan, PlanStatus status);

/// The object is held by no finger: 15 cm at a weak finger's reach. Nothing of it is known before the search.
Scene weak_grasp(bool both);
/// The brace, with a contact that must press harder than the motor can make it.
Scene impossible_brace();

}  // namespace tendril::search
