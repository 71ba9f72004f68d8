#pragma once

#include <IpReturnCodes.hpp>
#include <string_view>

#include "tendril/solver.hpp"

namespace tendril::ipopt_plugin {

/// Ipopt's word in those of every backend.
inline SolveStatus status_of(Ipopt::ApplicationReturnStatus status) {
  switch (status) {
    case Ipopt::Solve_Succeeded:
    case Ipopt::Feasible_Point_Found:
      return SolveStatus::converged;
    case Ipopt::Infeasible_Problem_Detected:
      return SolveStatus::infeasible;
    case Ipopt::Diverging_Iterates:
      return SolveStatus::diverged;
    case Ipopt::User_Requested_Stop:
      return SolveStatus::interrupted;
    case Ipopt::Maximum_Iterations_Exceeded:
      return SolveStatus::iteration_limit;
    case Ipopt::Maximum_CpuTime_Exceeded:
      return SolveStatus::time_limit;
    case Ipopt::Solved_To_Acceptable_Level:
    case Ipopt::Search_Direction_Becomes_Too_Small:
    case Ipopt::Restoration_Failed:
    case Ipopt::Error_In_Step_Computation:
      return SolveStatus::stalled;
    case Ipopt::Invalid_Number_Detected:
      return SolveStatus::not_finite;
    case Ipopt::Not_Enough_Degrees_Of_Freedom:
      return SolveStatus::unsupported;
    default:
      return SolveStatus::failed;
  }
}

/// Ipopt's own word.
inline std::string_view words(Ipopt::ApplicationReturnStatus status) {
  switch (status) {
    case Ipopt::Solve_Succeeded:
      return "Solve_Succeeded";
    case Ipopt::Solved_To_Acceptable_Level:
      return "Solved_To_Acceptable_Level";
    case Ipopt::Infeasible_Problem_Detected:
      return "Infeasible_Problem_Detected";
    case Ipopt::Search_Direction_Becomes_Too_Small:
      return "Search_Direction_Becomes_Too_Small";
    case Ipopt::Diverging_Iterates:
      return "Diverging_Iterates";
    case Ipopt::User_Requested_Stop:
      return "User_Requested_Stop";
    case Ipopt::Feasible_Point_Found:
      return "Feasible_Point_Found";
    case Ipopt::Maximum_Iterations_Exceeded:
      return "Maximum_Iterations_Exceeded";
    case Ipopt::Restoration_Failed:
      return "Restoration_Failed";
    case Ipopt::Error_In_Step_Computation:
      return "Error_In_Step_Computation";
    case Ipopt::Maximum_CpuTime_Exceeded:
      return "Maximum_CpuTime_Exceeded";
    case Ipopt::Not_Enough_Degrees_Of_Freedom:
      return "Not_Enough_Degrees_Of_Freedom";
    case Ipopt::Invalid_Problem_Definition:
      return "Invalid_Problem_Definition";
    case Ipopt::Invalid_Option:
      return "Invalid_Option";
    case Ipopt::Invalid_Number_Detected:
      return "Invalid_Number_Detected";
    case Ipopt::Unrecoverable_Exception:
      return "Unrecoverable_Exception";
    case Ipopt::NonIpopt_Exception_Thrown:
      return "NonIpopt_Exception_Thrown";
    case Ipopt::Insufficient_Memory:
      return "Insufficient_Memory";
    case Ipopt::Internal_Error:
      return "Internal_Error";
  }
  return "unknown status";
}

}  // namespace tendril::ipopt_plugin
