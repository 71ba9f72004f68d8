#include "ipopt/ipopt_status.hpp"

#include <gtest/gtest.h>

#include "support/print.hpp"

namespace tendril::ipopt_plugin {

namespace {

TEST(IpoptStatus, EveryWordOfIpoptHasItsMeaning) {
  struct Word {
    Ipopt::ApplicationReturnStatus native;
    SolveStatus status;
    const char* words;
  };
  // All of IpReturnCodes_inc.h.
  for (const auto& [native, status, text] :
       {Word{Ipopt::Solve_Succeeded, SolveStatus::converged, "Solve_Succeeded"},
        Word{Ipopt::Solved_To_Acceptable_Level, SolveStatus::stalled, "Solved_To_Acceptable_Level"},
        Word{Ipopt::Infeasible_Problem_Detected, SolveStatus::infeasible, "Infeasible_Problem_Detected"},
        Word{Ipopt::Search_Direction_Becomes_Too_Small, SolveStatus::stalled, "Search_Direction_Becomes_Too_Small"},
        Word{Ipopt::Diverging_Iterates, SolveStatus::diverged, "Diverging_Iterates"},
        Word{Ipopt::User_Requested_Stop, SolveStatus::interrupted, "User_Requested_Stop"},
        Word{Ipopt::Feasible_Point_Found, SolveStatus::converged, "Feasible_Point_Found"},
        Word{Ipopt::Maximum_Iterations_Exceeded, SolveStatus::iteration_limit, "Maximum_Iterations_Exceeded"},
        Word{Ipopt::Restoration_Failed, SolveStatus::stalled, "Restoration_Failed"},
        Word{Ipopt::Error_In_Step_Computation, SolveStatus::stalled, "Error_In_Step_Computation"},
        Word{Ipopt::Maximum_CpuTime_Exceeded, SolveStatus::time_limit, "Maximum_CpuTime_Exceeded"},
        Word{Ipopt::Not_Enough_Degrees_Of_Freedom, SolveStatus::unsupported, "Not_Enough_Degrees_Of_Freedom"},
        Word{Ipopt::Invalid_Problem_Definition, SolveStatus::failed, "Invalid_Problem_Definition"},
        Word{Ipopt::Invalid_Option, SolveStatus::failed, "Invalid_Option"},
        Word{Ipopt::Invalid_Number_Detected, SolveStatus::not_finite, "Invalid_Number_Detected"},
        Word{Ipopt::Unrecoverable_Exception, SolveStatus::failed, "Unrecoverable_Exception"},
        Word{Ipopt::NonIpopt_Exception_Thrown, SolveStatus::failed, "NonIpopt_Exception_Thrown"},
        Word{Ipopt::Insufficient_Memory, SolveStatus::failed, "Insufficient_Memory"},
        Word{Ipopt::Internal_Error, SolveStatus::failed, "Internal_Error"},
        Word{static_cast<Ipopt::ApplicationReturnStatus>(77), SolveStatus::failed, "unknown status"}}) {
    EXPECT_EQ(status_of(native), status) << text;
    EXPECT_EQ(words(native), text);
  }
}

}  // namespace

}  // namespace tendril::ipopt_plugin
