#include "nlopt/nlopt_status.hpp"

#include <gtest/gtest.h>

#include "support/print.hpp"

namespace tendril::nlopt_plugin {

namespace {

TEST(NloptStatus, EveryWordOfNloptHasItsMeaning) {
  struct Word {
    nlopt_result native;
    SolveStatus status;
    const char* words;
  };
  // All of nlopt.h. A stop that was forced without an exception kept is a defect; solve() reports the exception else.
  for (const auto& [native, status, text] :
       {Word{NLOPT_SUCCESS, SolveStatus::converged, "SUCCESS"},
        Word{NLOPT_STOPVAL_REACHED, SolveStatus::converged, "STOPVAL_REACHED"},
        Word{NLOPT_FTOL_REACHED, SolveStatus::converged, "FTOL_REACHED"},
        Word{NLOPT_XTOL_REACHED, SolveStatus::converged, "XTOL_REACHED"},
        Word{NLOPT_MAXEVAL_REACHED, SolveStatus::iteration_limit, "MAXEVAL_REACHED"},
        Word{NLOPT_MAXTIME_REACHED, SolveStatus::time_limit, "MAXTIME_REACHED"},
        Word{NLOPT_FAILURE, SolveStatus::stalled, "FAILURE"},
        Word{NLOPT_INVALID_ARGS, SolveStatus::failed, "INVALID_ARGS"},
        Word{NLOPT_OUT_OF_MEMORY, SolveStatus::failed, "OUT_OF_MEMORY"},
        Word{NLOPT_ROUNDOFF_LIMITED, SolveStatus::stalled, "ROUNDOFF_LIMITED"},
        Word{NLOPT_FORCED_STOP, SolveStatus::failed, "FORCED_STOP"},
        Word{static_cast<nlopt_result>(0), SolveStatus::failed, "unknown result"}}) {
    EXPECT_EQ(status_of(native), status) << text;
    EXPECT_EQ(words(native), text);
  }
}

}  // namespace

}  // namespace tendril::nlopt_plugin
