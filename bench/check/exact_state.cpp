#include "check/exact_state.hpp"

#include <algorithm>
#include <cmath>

#include "scene/make_rod.hpp"
#include "support/rod_bvp.hpp"
#include "tendril/problem.hpp"
#include "tendril/tolerances.hpp"

namespace tendril::bench {

namespace {

/// Shooting intervals per rod: under a load of 1e4 what is wrong at one end grows by less than e^2 to the other.
constexpr int intervals = 64;

support::RodBvp bvp_of(const Rod& rod) {
  support::RodBvp bvp;
  bvp.sections.clear();
  for (const Rod::Segment& s : rod.segments) {
    bvp.sections.push_back({s.to - s.from, s.stiffness, s.weight, s.rest_curvature});
  }
  bvp.actuators.clear();
  for (const Rod::Actuator& a : rod.actuators) bvp.actuators.push_back({a.from, a.to});
  bvp.gravity = {rod.gravity.x, rod.gravity.y};
  bvp.tip_force = {rod.tip_force.x, rod.tip_force.y};
  bvp.payload = rod.payload;
  bvp.base = {rod.base.x, rod.base.y};
  bvp.base_angle = rod.base_angle;
  return bvp;
}

/// The part of the boundary beside a point: a circle where it is curved, a wall where it is straight.
support::BvpContact contact_of(const Obstacle& obstacle, Vec2 point, bool at_tip) {
  const SurfacePoint surface = obstacle.at(point);
  support::BvpContact contact;
  contact.at_tip = at_tip;
  if (surface.curvature == 0.0) {
    const Vec2 foot = point - surface.distance * surface.normal;
    contact.center = {foot.x, foot.y};
    contact.wall_normal = {surface.normal.x, surface.normal.y};
    return contact;
  }
  const Vec2 center = point - 1.0 / surface.curvature * surface.normal;
  contact.center = {center.x, center.y};
  contact.radius = 1.0 / surface.curvature - surface.distance;
  return contact;
}

bool presses(const PlannedContact& c, const Scale& scale) { return c.force > tolerance::force * scale.force(); }

}  // namespace

ExactState exact_state(const Scene& scene, const std::vector<std::unique_ptr<Obstacle>>& obstacles, const Plan& plan,
                       const Plan& start) {
  const Scale scale = scale_of(scene);
  ExactState exact;
  if (plan.backbone.empty() || start.backbone.size() < 2) {
    exact.why = "there is no shape";
    return exact;
  }
  std::vector<double> moments;
  for (const double m : plan.moments) moments.push_back(scale.to_dimensionless(m, dimension::moment));
  std::vector<support::BvpContact> contacts;
  support::BvpGuess guess;
  for (const PlannedContact& c : plan.contacts) {
    if (!presses(c, scale)) continue;
    const auto o = static_cast<std::size_t>(c.obstacle);
    contacts.push_back(contact_of(*obstacles[o], 1.0 / scale.length * c.point, c.at_tip));
    guess.arc_lengths.push_back(c.at_tip ? 1.0 : c.arc_length / scale.length);
    guess.forces.push_back(c.force / scale.force());
  }
  std::size_t k = 0;
  for (const PlannedContact& c : start.contacts) {
    if (!presses(c, scale) || k == contacts.size()) continue;
    guess.arc_lengths[k] = c.at_tip ? 1.0 : c.arc_length / scale.length;
    guess.forces[k++] = c.force / scale.force();
  }
  guess.angle = [&start, &scale](double s) {
    const std::vector<BackbonePoint>& points = start.backbone;
    std::size_t i = 1;
    while (i + 1 < points.size() && points[i].s < s * scale.length) ++i;
    // The cubic through angles and curvatures: a layer may be as thin as the samples lie apart.
    const double step = points[i].s - points[i - 1].s;
    const double t = (s * scale.length - points[i - 1].s) / step;
    const double u = 1.0 - t;
    return u * u * (1.0 + 2.0 * t) * points[i - 1].angle + t * t * (1.0 + 2.0 * u) * points[i].angle +
           t * u * step * (u * points[i - 1].curvature - t * points[i].curvature);
  };
  support::BvpOptions options;
  options.intervals = intervals;
  try {
    const support::BvpSolution solution =
        support::solve(bvp_of(make_rod(scene, scale)), moments, contacts, guess, options);
    exact.tip = {solution.tip_x, solution.tip_y};
    exact.arc_lengths = solution.arc_lengths;
    exact.forces = solution.forces;
    exact.found = true;
  } catch (const support::BvpError& error) {
    exact.why = error.what();
  }
  return exact;
}

double distance(const Scene& scene, const Plan& plan, const ExactState& exact) {
  const Scale scale = scale_of(scene);
  double worst = norm(1.0 / scale.length * Vec2{plan.tip_x, plan.tip_y} - exact.tip);
  std::size_t k = 0;
  for (const PlannedContact& c : plan.contacts) {
    if (!presses(c, scale)) continue;
    worst = std::max(worst, std::abs(c.arc_length / scale.length - exact.arc_lengths[k]));
    const double force = exact.forces[k++];
    worst = std::max(worst, std::abs(c.force / scale.force() - force) / std::max(1.0, std::abs(force)));
  }
  return worst;
}

}  // namespace tendril::bench
