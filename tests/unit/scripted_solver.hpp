#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "tendril/solver.hpp"

namespace tendril {

/// A backend that does what a test says.
class ScriptedSolver : public Solver {
 public:
  using Callbacks = Solver::Callbacks;
  using Start = Solver::Start;
  using Outcome = Solver::Outcome;
  using Script = std::function<Outcome(Callbacks&, const Start&)>;

  explicit ScriptedSolver(Script script, SolverCapabilities can = {}) : script_(std::move(script)), can_(can) {}
  std::string name() const override { return "scripted"; }
  SolverCapabilities capabilities() const override { return can_; }

 private:
  Outcome do_solve(Callbacks& callbacks, const Start& start, const SolveControl&) override {
    return script_(callbacks, start);
  }

  Script script_;
  SolverCapabilities can_;
};

inline ScriptedSolver::Outcome converged_at(const std::vector<double>& x) {
  ScriptedSolver::Outcome outcome;
  outcome.status = SolveStatus::converged;
  outcome.x = x;
  return outcome;
}

}  // namespace tendril
