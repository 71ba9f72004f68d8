#include "earlier_plan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "check_points.hpp"
#include "contact_search.hpp"
#include "plan_report.hpp"
#include "tendril/chain.hpp"
#include "tendril/tolerances.hpp"

namespace tendril {

std::optional<std::vector<ContactSetup>> contacts_of(const Problem::Data& problem, const Plan& plan) {
  std::vector<std::pair<double, ContactSetup>> holding;
  for (const PlannedContact& c : plan.contacts) {
    if (!(c.force > 0.0)) continue;
    const auto name = std::find(problem.obstacle_names.begin(), problem.obstacle_names.end(), c.obstacle_name);
    if (name == problem.obstacle_names.end()) return std::nullopt;
    const double s = c.at_tip ? 1.0 : c.arc_length / problem.scale.length;
    const int obstacle = static_cast<int>(name - problem.obstacle_names.begin());
    holding.push_back({s, {obstacle, c.at_tip, c.at_tip ? 0 : stretch_at(problem.rod, s)}});
  }
  if (static_cast<int>(holding.size()) > problem.scene.contact.count) return std::nullopt;
  std::stable_sort(holding.begin(), holding.end(), [](const auto& a, const auto& b) {
    return std::pair(a.second.at_tip, a.first) < std::pair(b.second.at_tip, b.first);
  });
  std::vector<ContactSetup> contacts;
  contacts.reserve(holding.size());
  for (const auto& [s, contact] : holding) contacts.push_back(contact);
  return contacts;
}

StartShape shape_of(const Problem::Data& problem, const Plan& plan, const Mode& mode) {
  const double length = problem.scale.length;
  StartShape shape;
  shape.curvature = curvature_of(plan, length);
  if (plan.moments.size() == problem.rod.actuators.size()) {
    for (const double u : plan.moments) shape.moments.push_back(u / problem.scale.moment());
  }
  for (const ContactSetup& c : mode.contacts) {
    double s = std::numeric_limits<double>::quiet_NaN();
    double f = 0.0;
    for (const PlannedContact& planned : plan.contacts) {
      if (planned.obstacle_name != problem.obstacle_names[static_cast<std::size_t>(c.obstacle)] ||
          planned.at_tip != c.at_tip)
        continue;
      s = planned.arc_length / length;
      f = planned.force / problem.scale.force();
    }
    shape.arc_lengths.push_back(s);
    shape.forces.push_back(f);
  }
  if (plan.grasp) shape.palm_distance = plan.grasp->palm_distance / length;
  return shape;
}

std::optional<FollowedPoint> followed_point(const Problem::Data& problem, const Plan& earlier) {
  const bool same_coordinates = earlier.status == PlanStatus::solved &&
                                earlier.coordinates_name == problem.scene.coordinates.plugin &&
                                earlier.order == problem.components.coordinates->function_count() &&
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

  const Chain chain(problem.rod, *problem.components.coordinates, {}, 1);
  std::vector<int>& regions = point.regions;
  for (std::size_t k = 0; k < mode.contacts.size(); ++k) {
    const ContactSetup& c = mode.contacts[k];
    const bool in_piece = !c.at_tip && !problem.scene.coordinates.split_at_contact;
    regions.push_back(in_piece ? chain.piece_at(earlier.contacts[k].arc_length / problem.scale.length, {}) : c.region);
  }
  PoseProgramSpec spec = problem.spec(mode, regions, problem.nodes);
  PoseProgram program(spec);
  const PoseProgram::Layout& at = program.layout();
  if (at.coordinates != static_cast<int>(earlier.coordinates.size())) return std::nullopt;
  const StartShape shape = shape_of(problem, earlier, mode);
  point.x = program.start_from(shape);
  point.x.head(at.coordinates) = Eigen::Map<const Eigen::VectorXd>(earlier.coordinates.data(), at.coordinates);
  point.checks = problem.first_checks(spec, shape);
  for (int k = 0; k < at.forces; ++k) program.set_branch(k, Branch::touching);
  // Where the earlier plan grazes an obstacle, Newton has to know.
  Certifier certifier(spec);
  exchange_checks(program, point.x, certifier, point.checks, grazing_level);
  return point;
}

bool contacts_unchanged(const Problem::Data& problem, PoseProgram& program, ConstVectorRef x) {
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
