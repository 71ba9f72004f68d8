#pragma once

#include <nlopt.h>

#include <string_view>

#include "tendril/solver.hpp"

namespace tendril::nlopt_plugin {

/// NLopt's word in those of every backend, where nothing else is known of the end.
inline SolveStatus status_of(nlopt_result result) {
  switch (result) {
    case NLOPT_SUCCESS:
    case NLOPT_STOPVAL_REACHED:
    case NLOPT_FTOL_REACHED:
    case NLOPT_XTOL_REACHED:
      return SolveStatus::converged;
    case NLOPT_MAXEVAL_REACHED:
      return SolveStatus::iteration_limit;
    case NLOPT_MAXTIME_REACHED:
      return SolveStatus::time_limit;
    case NLOPT_ROUNDOFF_LIMITED:
    case NLOPT_FAILURE:
      return SolveStatus::stalled;
    default:
      return SolveStatus::failed;
  }
}

/// NLopt's own word.
inline std::string_view words(nlopt_result result) {
  switch (result) {
    case NLOPT_SUCCESS:
      return "SUCCESS";
    case NLOPT_STOPVAL_REACHED:
      return "STOPVAL_REACHED";
    case NLOPT_FTOL_REACHED:
      return "FTOL_REACHED";
    case NLOPT_XTOL_REACHED:
      return "XTOL_REACHED";
    case NLOPT_MAXEVAL_REACHED:
      return "MAXEVAL_REACHED";
    case NLOPT_MAXTIME_REACHED:
      return "MAXTIME_REACHED";
    case NLOPT_FAILURE:
      return "FAILURE";
    case NLOPT_INVALID_ARGS:
      return "INVALID_ARGS";
    case NLOPT_OUT_OF_MEMORY:
      return "OUT_OF_MEMORY";
    case NLOPT_ROUNDOFF_LIMITED:
      return "ROUNDOFF_LIMITED";
    case NLOPT_FORCED_STOP:
      return "FORCED_STOP";
    default:
      return "unknown result";
  }
}

}  // namespace tendril::nlopt_plugin
