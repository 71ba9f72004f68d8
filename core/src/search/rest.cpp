#include "search/rest.hpp"

#include <algorithm>
#include <limits>

#include "scene/plan_report.hpp"
#include "search/contacts.hpp"
#include "tendril/tolerances.hpp"

namespace tendril {

Rest rest_of(const Task& problem, const Plan& plan) {
  Rest rest{curvature_of(plan, problem.scale.length),
            {},
            {},
            moves_of(problem.rod, problem.scale, place_on_palm(problem.scene, plan.place), problem.rod.starts())};
  if (plan.moments.size() == problem.rod.actuators.size()) {
    for (const double u : plan.moments) rest.moments.push_back(u / problem.scale.moment());
  }
  for (const PlannedContact& c : plan.contacts) {
    const auto name = std::find(problem.obstacle_names.begin(), problem.obstacle_names.end(), c.obstacle_name);
    if (name == problem.obstacle_names.end()) continue;
    const double s = c.arc_length / problem.scale.length;
    const int obstacle = static_cast<int>(name - problem.obstacle_names.begin());
    rest.contacts.push_back(
        {{obstacle, c.at_tip, c.at_tip ? 0 : stretch_at(problem.rod, s)}, s, c.force / problem.scale.force()});
  }
  sort_contacts(rest.contacts);
  return rest;
}

namespace {

void add_contact(Rest& rest, const Task& problem, int obstacle, bool at_tip, double s, double force) {
  if (!(force > 0.0)) return;
  rest.contacts.push_back({{obstacle, at_tip, at_tip ? 0 : stretch_at(problem.rod, s)}, s, force});
}

}  // namespace

Rest rest_of(const Task& problem, const std::vector<double>& moments, const State& state) {
  Rest rest{state.curvature, moments, {}, {}};
  for (const PointContact& c : state.contacts) {
    if (c.force > tolerance::force)
      add_contact(rest, problem, c.setup.obstacle, c.setup.at_tip, c.setup.at_tip ? 1.0 : c.s, c.force);
  }
  sort_contacts(rest.contacts);
  return rest;
}

StartShape shape_of(const Rest& rest, const Mode& mode) {
  StartShape shape;
  shape.curvature = rest.curvature;
  shape.stretch = rest.curvature.stretch;
  shape.moments = rest.moments;
  shape.moves = rest.moves;
  std::vector<bool> used(rest.contacts.size(), false);
  for (const ContactSetup& c : mode.contacts) {
    double s = std::numeric_limits<double>::quiet_NaN();
    double f = 0.0;
    for (std::size_t i = 0; i < rest.contacts.size(); ++i) {
      const PointContact& own = rest.contacts[i];
      if (used[i] || own.setup.obstacle != c.obstacle || own.setup.at_tip != c.at_tip) continue;
      used[i] = true;
      s = own.s;
      f = own.force;
      break;
    }
    shape.arc_lengths.push_back(s);
    shape.forces.push_back(f);
  }
  return shape;
}

}  // namespace tendril
