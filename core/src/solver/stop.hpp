#pragma once

#include <cstdio>
#include <string>

#include "tendril/solver.hpp"

namespace tendril {

/// Ends a solve from inside a callback; only Solver::solve may catch it.
class StopSolve : public Error {
 public:
  StopSolve(SolveStatus why, const std::string& message) : Error(message), status(why) {}
  SolveStatus status;
};

/// For messages: three digits.
inline std::string short_number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

[[noreturn]] inline void throw_not_finite(const std::string& what, double value) {
  throw NotFiniteError(what + " is not finite (" + short_number(value) + ")");
}

}  // namespace tendril
