#pragma once

#include <string>

#include "tendril/solver.hpp"

namespace tendril {

/// Ends a solve from inside a callback; only Solver::solve may catch it.
class StopSolve : public Error {
 public:
  StopSolve(SolveStatus why, const std::string& message) : Error(message), status(why) {}
  SolveStatus status;
};

[[noreturn]] inline void throw_not_finite(const std::string& what, double value) {
  throw NotFiniteError(what + " is not finite (" + shown(value, 3) + ")");
}

}  // namespace tendril
