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

BodyRadius RodSpec::body() const {
  const auto thick = [](const SegmentSpec& s) { return s.thickness != 0.0 || !s.more_thickness.empty(); };
  if (std::none_of(segments.begin(), segments.end(), thick)) return {};
  return [this](double s) {
    std::size_t i = 0;
    double from = 0.0;
    for (; i + 1 < segments.size() && s >= from + segments[i].length; ++i) from += segments[i].length;
    const double x = std::clamp((s - from) / segments[i].length, 0.0, 1.0);
    double more = 0.0;
    for (auto c = segments[i].more_thickness.rbegin(); c != segments[i].more_thickness.rend(); ++c)
      more = (more + *c) * x;
    return 0.5 * (segments[i].thickness + more);
  };
}

double RodSpec::length() const {
  double sum = 0.0;
  for (const SegmentSpec& s : segments) sum += s.length;
  return sum;
}

}  // namespace tendril
