#include "program/pose_state.hpp"

#include <algorithm>
#include <utility>

#include "obstacle/surface.hpp"

namespace tendril {
namespace {

std::vector<int> knot_stretches(const PoseProgramSpec& spec) {
  std::vector<int> stretches;
  if (!spec.split) return stretches;
  for (const ContactSetup& c : spec.contacts) {
    if (!c.at_tip) stretches.push_back(c.region);
  }
  return stretches;
}

std::vector<int> moment_variables(const Rod& rod, int next) {
  std::vector<int> variables;
  for (const Rod::Actuator& a : rod.actuators) variables.push_back(a.fixed_at_zero() ? -1 : next++);
  return variables;
}

std::vector<int> shears_of(const PoseProgramSpec& spec, int next) {
  std::vector<int> variables;
  for (const ContactSetup& c : spec.contacts) variables.push_back(c.sticks ? next++ : -1);
  return variables;
}

bool ordered(const PoseProgramSpec& spec, const PoseProgram::Layout& at, int contact) {
  if (contact + 1 >= at.arc_lengths) return false;
  const int next = spec.contacts[static_cast<std::size_t>(contact + 1)].region;
  if (contact < 0) return spec.rod->draws() && next == 0;
  return spec.contacts[static_cast<std::size_t>(contact)].region == next;
}

PoseProgram::Layout layout_of(const PoseProgramSpec& spec, const Chain& chain) {
  PoseProgram::Layout at;
  at.coordinates = at.first_moment = chain.coordinate_count();
  at.moments = static_cast<int>(std::count_if(spec.rod->actuators.begin(), spec.rod->actuators.end(),
                                              [](const Rod::Actuator& a) { return !a.fixed_at_zero(); }));
  at.first_move = at.first_moment + at.moments;
  at.moves = static_cast<int>(spec.rod->moves.size());
  at.first_arc_length = at.first_move + at.moves;
  at.arc_lengths = static_cast<int>(
      std::count_if(spec.contacts.begin(), spec.contacts.end(), [](const ContactSetup& c) { return !c.at_tip; }));
  at.first_force = at.first_arc_length + at.arc_lengths;
  at.forces = static_cast<int>(spec.contacts.size());
  at.first_lean = at.first_force + at.forces;
  at.leans = spec.friction.empty() ? 0 : at.forces;
  if (spec.palm && spec.palm->minimum != spec.palm->maximum) at.palm = at.first_lean + at.leans;
  at.first_shear = at.first_lean + at.leans + (at.palm >= 0 ? 1 : 0);
  at.shears = static_cast<int>(
      std::count_if(spec.contacts.begin(), spec.contacts.end(), [](const ContactSetup& c) { return c.sticks; }));
  at.first_gap = at.coordinates;
  at.first_closest = at.first_gap + at.forces;
  at.first_shortening = at.first_closest + at.forces;
  at.shortenings = static_cast<int>(std::count_if(spec.rod->actuators.begin(), spec.rod->actuators.end(),
                                                  [](const Rod::Actuator& a) { return a.limits_length(); }));
  at.first_check = at.first_shortening + at.shortenings;
  at.checks = static_cast<int>(spec.checks.size());
  at.first_order = at.first_check + at.checks;
  for (int k = -1; k + 1 < at.arc_lengths; ++k) at.orders += ordered(spec, at, k) ? 1 : 0;
  at.first_balance = at.first_order + at.orders;
  at.balances = spec.palm && spec.palm->balance && at.forces > 0 ? spec.palm->parts : 0;
  at.first_target = at.first_balance + at.balances;
  at.targets = (spec.tolerance.position < infinity ? 1 : 0) + (spec.tolerance.angle < infinity ? 1 : 0);
  at.first_margin = at.first_target + at.targets;
  at.margins = spec.least_margin ? 1 : 0;
  at.first_convexity = at.first_margin + at.margins;
  at.convexities = spec.least_convexity ? 2 * at.arc_lengths : 0;
  at.first_stick = at.first_convexity + at.convexities;
  return at;
}

std::vector<int> places_of_contacts(const PoseProgramSpec& spec, const Chain& chain, Places& places) {
  std::vector<int> made;
  for (int k = 0; k < static_cast<int>(spec.contacts.size()); ++k) {
    const ContactSetup& c = spec.contacts[static_cast<std::size_t>(k)];
    made.push_back(c.at_tip     ? places.add_tip()
                   : spec.split ? places.add_knot(chain.piece_before_knot(k))
                                : places.add_sliding(c.region, k));
  }
  return made;
}

}  // namespace

PoseState::PoseState(PoseProgramSpec s)
    : spec(std::move(s)),
      chain(*spec.rod, *spec.model, knot_stretches(spec), spec.nodes, spec.tables.get()),
      layout(layout_of(spec, chain)),
      moment_variable(moment_variables(*spec.rod, layout.first_moment)),
      branches(spec.contacts.size(), Branch::open),
      places(*spec.rod, chain, layout.arc_lengths),
      contact_places(places_of_contacts(spec, chain, places)),
      shear_variables(shears_of(spec, layout.first_shear)),
      base(spec, layout, moment_variable, contact_places, places),
      contacts(spec.contacts.size()),
      loads{spec.rod->gravity, spec.rod->tip_force, std::vector<double>(spec.obstacles.size(), 0.0)},
      variables(layout.variables()) {
  forces.on.resize(contact_places.size());
}

void PoseState::move(ConstVectorRef x) {
  const Rod& rod = *spec.rod;
  if (spec.palm) {
    shift = -(layout.palm >= 0 ? x[layout.palm] : spec.palm->minimum) * spec.palm->axis;
    places.place(rod.base + shift);
  }
  places.move(x.head(layout.coordinates), slides(x));
  forces.tip = loads.tip_force;
  forces.gravity = loads.gravity;
  forces.payload = rod.payload;
  forces.dead = {loads.dead, 0.0};
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    PoseProgram::ContactState& c = contacts[k];
    const auto variable = static_cast<int>(k);
    const int place = contact_places[k];
    c.force = x[layout.first_force + variable];
    c.point = places.point(place);
    c.angle = places.angle(place);
    c.tangent = places.tangent(place);
    c.arc_length = spec.contacts[k].at_tip ? 1.0 : x[layout.first_arc_length + variable];
    const int obstacle = spec.contacts[k].obstacle;
    c.surface = surface(obstacle, c.point);
    if (chain.is_thick()) c.radius = places.radius(place);
    c.surface.distance -= c.radius.value;
    const Vec2 tau = turned(c.surface.normal);
    c.lean = loads.friction.empty() ? 0.0 : loads.friction[static_cast<std::size_t>(obstacle)];
    if (dot(tau, c.tangent) < 0.0) c.lean = -c.lean;
    if (spec.contacts[k].lean != 0.0) c.lean = spec.contacts[k].lean;
    if (layout.leans > 0) c.lean = x[layout.first_lean + variable];
    c.push = c.surface.normal + c.lean * tau;
    Push& push = forces.on[static_cast<std::size_t>(place)];
    push.force = c.force * c.push;
    push.moment = c.force * couple(variable);
    if (shear_variables[k] < 0) continue;
    c.shear = x[shear_variables[k]];
    push.force += c.shear * tau;
    push.moment -= c.shear * c.radius.value;
  }
  base.move(x, contacts);
}

SurfacePoint PoseState::surface(int obstacle, Vec2 point) const {
  const auto o = static_cast<std::size_t>(obstacle);
  SurfacePoint p = spec.obstacles[o]->at(point);
  p.distance += loads.shrink[o];
  return p;
}

void PoseState::differentiate() {
  places.differentiate();
  base.differentiate();
}

bool PoseState::ordered(int contact) const { return tendril::ordered(spec, layout, contact); }

void PoseState::add_force_work(int contact, Vec2 displacement) {
  const PoseProgram::ContactState& c = contacts[static_cast<std::size_t>(contact)];
  const BaseIndex::Contact& at = base.index.contacts[static_cast<std::size_t>(contact)];
  const Vec2 sliding = add_push_work(contact, displacement, c.force);
  base.add_symmetric(at.point.x, at.force, sliding.x);
  base.add_symmetric(at.point.y, at.force, sliding.y);
  if (at.lean >= 0) base.add_symmetric(at.force, at.lean, dot(turned(c.surface.normal), displacement));
}

void PoseState::add_shear_work(int contact, Vec2 displacement) {
  const PoseProgram::ContactState& c = contacts[static_cast<std::size_t>(contact)];
  const BaseIndex::Point& point = base.index.contacts[static_cast<std::size_t>(contact)].point;
  const Vec2 sliding = add_normal_work(contact, -turned(displacement), c.shear);
  base.add_symmetric(point.x, base.shear(contact), sliding.x);
  base.add_symmetric(point.y, base.shear(contact), sliding.y);
}

Vec2 PoseState::add_push_work(int contact, Vec2 displacement, double force) {
  const PoseProgram::ContactState& c = contacts[static_cast<std::size_t>(contact)];
  const BaseIndex::Contact& at = base.index.contacts[static_cast<std::size_t>(contact)];
  const Vec2 tau = turned(c.surface.normal);
  if (at.lean >= 0) {
    // Where the point moves tau turns towards -n.
    const double turning = -force * c.surface.curvature * dot(c.surface.normal, displacement);
    base.add_symmetric(at.point.x, at.lean, turning * tau.x);
    base.add_symmetric(at.point.y, at.lean, turning * tau.y);
  }
  // n + lean tau is n turned and stretched: so is what it works along, the other way.
  return add_normal_work(contact, displacement - c.lean * turned(displacement), force);
}

Vec2 PoseState::add_normal_work(int contact, Vec2 displacement, double force) {
  const PoseProgram::ContactState& c = contacts[static_cast<std::size_t>(contact)];
  const BaseIndex::Contact& at = base.index.contacts[static_cast<std::size_t>(contact)];
  const Vec2 tau = turned(c.surface.normal);
  const Vec2 sliding = c.surface.curvature * dot(tau, displacement) * tau;
  base.gradient[at.point.x] += force * sliding.x;
  base.gradient[at.point.y] += force * sliding.y;
  base.add(at.point, normal_hessian(c.surface, force * displacement));
  return sliding;
}

}  // namespace tendril
