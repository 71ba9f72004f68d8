#include "search/earlier_plan.hpp"

#include <algorithm>
#include <cmath>

#include "certificate/check_points.hpp"
#include "program/equations.hpp"
#include "search/rest.hpp"
#include "tendril/tolerances.hpp"

namespace tendril {

std::optional<std::vector<ContactSetup>> contacts_of(const Task& problem, const Plan& plan) {
  const bool all_known = std::all_of(plan.contacts.begin(), plan.contacts.end(), [&](const PlannedContact& c) {
    const auto& names = problem.obstacle_names;
    return !(c.force > 0.0) || std::find(names.begin(), names.end(), c.obstacle_name) != names.end();
  });
  if (!all_known) return std::nullopt;
  std::vector<ContactSetup> contacts;
  for (const PointContact& c : rest_of(problem, plan).contacts) {
    if (c.force > 0.0) contacts.push_back(c.setup);
  }
  if (static_cast<int>(contacts.size()) > problem.scene.contact.count) return std::nullopt;
  return contacts;
}

StartShape shape_of(const Task& problem, const Plan& plan, const Mode& mode) {
  StartShape shape = shape_of(rest_of(problem, plan), mode);
  if (plan.grasp) shape.palm_distance = plan.grasp->palm_distance / problem.scale.length;
  if (problem.friction.empty() || plan.contacts.size() != mode.contacts.size()) return shape;
  for (const PlannedContact& c : plan.contacts) {
    shape.leans.push_back(c.force > 0.0 ? c.tangential / c.force * dot(c.tangent, turned(c.normal)) : 0.0);
  }
  return shape;
}

std::optional<FollowedPoint> followed_point(const Task& problem, const Plan& earlier, bool with_checks) {
  const bool same_coordinates = earlier.status == PlanStatus::solved &&
                                earlier.coordinates_name == problem.scene.coordinates.plugin &&
                                earlier.order == problem.model->function_count() &&
                                earlier.split_at_contact == problem.scene.coordinates.split_at_contact &&
                                earlier.moments.size() == problem.rod.actuators.size();
  if (!same_coordinates) return std::nullopt;
  const std::optional<std::vector<ContactSetup>> contacts = contacts_of(problem, earlier);
  // A contact that did not press, or another order of them: other modes know more about it.
  const auto same_place = [&](const ContactSetup& c, const PlannedContact& p) {
    return p.at_tip == c.at_tip && p.obstacle_name == problem.obstacle_names[static_cast<std::size_t>(c.obstacle)];
  };
  if (!contacts ||
      !std::equal(contacts->begin(), contacts->end(), earlier.contacts.begin(), earlier.contacts.end(), same_place)) {
    return std::nullopt;
  }
  if (contacts->empty() ? problem.min_force > 0.0 : !problem.contact_planned()) return std::nullopt;
  FollowedPoint point;
  point.mode = contacts->empty() ? problem.modes.front() : problem.mode(*contacts);
  const Mode& mode = point.mode;
  if (!mode.skip.empty()) return std::nullopt;

  std::vector<double> places;
  for (std::size_t k = 0; k < mode.contacts.size(); ++k) {
    places.push_back(earlier.contacts[k].arc_length / problem.scale.length);
  }
  point.regions = problem.regions_of(mode, places);
  PoseProgramSpec spec = problem.spec(mode, point.regions, problem.nodes);
  if (!with_checks) spec = Equations::alone(std::move(spec));
  PoseProgram program(spec);
  const PoseProgram::Layout& at = program.layout();
  if (at.coordinates != static_cast<int>(earlier.coordinates.size())) return std::nullopt;
  const StartShape shape = shape_of(problem, earlier, mode);
  point.x = program.start_from(shape);
  point.x.head(at.coordinates) = Eigen::Map<const Eigen::VectorXd>(earlier.coordinates.data(), at.coordinates);
  if (!with_checks) return point;
  point.checks = problem.first_checks(program, point.x, shape);
  for (int k = 0; k < at.forces; ++k) program.set_branch(k, Branch::touching);
  // Where the earlier plan grazes an obstacle, Newton has to know.
  Certifier certifier(program);
  exchange_checks(program, point.x, certifier, point.checks, grazing_level);
  return point;
}

bool contacts_unchanged(const Task& problem, PoseProgram& program, ConstVectorRef x) {
  if (!problem.contact_planned()) return true;
  const PoseProgram::Layout& at = program.layout();
  for (int k = 0; k < at.forces; ++k) {
    if (x[program.force_variable(k)] <= std::max(tolerance::force, problem.min_force)) return false;
  }
  for (int v = at.first_arc_length; v < at.first_arc_length + at.arc_lengths; ++v) {
    if (x[v] <= program.lower()[v] + at_knot || x[v] >= program.upper()[v] - at_knot) return false;
  }
  // A rod held off by a mere clearance row could press there.
  const VectorView c = program.constraints(x);
  return at.checks == 0 || c.segment(at.first_check, at.checks).minCoeff() > tolerance::branch_decided;
}

}  // namespace tendril
