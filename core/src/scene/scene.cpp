#include "tendril/scene.hpp"

#include "tendril/plan.hpp"

namespace tendril {

std::string_view to_string(ProblemKind kind) {
  switch (kind) {
    case ProblemKind::pose:
      return "pose";
    case ProblemKind::trajectory:
      return "trajectory";
    case ProblemKind::grasp:
      return "grasp";
    case ProblemKind::execute:
      return "execute";
    case ProblemKind::estimate:
      return "estimate";
  }
  return "?";
}

std::string_view to_string(ContactModeName mode) {
  switch (mode) {
    case ContactModeName::ignore:
      return "ignore";
    case ContactModeName::avoid:
      return "avoid";
    case ContactModeName::allow:
      return "allow";
    case ContactModeName::require:
      return "require";
  }
  return "?";
}

std::string_view to_string(SearchEffort effort) {
  switch (effort) {
    case SearchEffort::fast:
      return "fast";
    case SearchEffort::normal:
      return "normal";
    case SearchEffort::thorough:
      return "thorough";
  }
  return "?";
}

std::string_view to_string(SnapKind kind) {
  switch (kind) {
    case SnapKind::fold:
      return "fold";
    case SnapKind::bifurcation:
      return "bifurcation";
    case SnapKind::release:
      return "release";
    case SnapKind::slip:
      return "slip";
    case SnapKind::start:
      return "start";
  }
  return "?";
}

std::string_view to_string(PlanStatus status) {
  switch (status) {
    case PlanStatus::solved:
      return "solved";
    case PlanStatus::infeasible:
      return "infeasible";
    case PlanStatus::unstable:
      return "unstable";
    case PlanStatus::not_converged:
      return "not_converged";
    case PlanStatus::diverged:
      return "diverged";
    case PlanStatus::time_limit:
      return "time_limit";
    case PlanStatus::interrupted:
      return "interrupted";
    case PlanStatus::failed:
      return "failed";
  }
  return "?";
}

double RodSpec::length() const {
  double sum = 0.0;
  for (const SegmentSpec& s : segments) sum += s.length;
  return sum;
}

}  // namespace tendril
