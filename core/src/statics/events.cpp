#include <algorithm>
#include <cmath>

#include "statics/tracker.hpp"
#include "tendril/tolerances.hpp"

namespace tendril {
namespace {

constexpr double glancing = 1e-3;       ///< passing by within so much of a rod's motion is not looked into (L) ...
constexpr double interpolation = 1e-6;  ///< depth between the ends of a step that the cubic may be wrong by (L) ...
/// ... but within these shares of an obstacle's radius, where that is less, down to the least of them (L).
constexpr double glancing_share = 0.5, interpolation_share = 0.1, least_share = 1e-8;
/// Where stability is lost, points right before and behind are on one branch if no farther apart than this (metric of
/// the bending energy). Beside a symmetric rod's bifurcation two branches pass each other at the cube root of what the
/// rod lacks of symmetry: what is rounding counts as symmetric, a lean of 1e-10 rad does not.
constexpr double same_branch = 1e-4;
/// A margin that changes this little over this part of a step is smooth there; where a contact spreads it jumps.
constexpr double bracket = 1e-5, smooth_change = 1e-2;
constexpr double jump_bracket = 1e-10;

/// The cubic through both ends of a step with their tangents.
Eigen::VectorXd between(const Eigen::VectorXd& first, const Eigen::VectorXd& first_rate, const Eigen::VectorXd& last,
                        const Eigen::VectorXd& last_rate, double t) {
  const double r = 1.0 - t;
  return r * r * ((1.0 + 2.0 * t) * first + t * first_rate) + t * t * ((1.0 + 2.0 * r) * last - r * last_rate);
}

}  // namespace

std::optional<std::vector<Tracker::Event>> Tracker::events(const Step& step, const Eigen::VectorXd& tangent) {
  std::vector<Event> found;
  Statics& s = *now_.statics;
  const int load = s.size();
  const bool good = add_releases(step, found) && add_touches(step, found) && add_taut(step, found) &&
                    add_tip(step, tangent, found) && add_friction(step, tangent, found) &&
                    add_instability(step, tangent, found);
  if (!good) return std::nullopt;
  // The final loads may lie before the step's end, or between here and a fold at still higher ones.
  double beyond = step.z[load] >= 1.0 ? step.tau : infinity;
  for (const Event& e : found) {
    if (e.kind == EventKind::fold && e.z[load] >= 1.0) beyond = std::min(beyond, e.tau);
  }
  if (!std::isfinite(beyond)) return found;
  const auto ends_at = [&](const Eigen::VectorXd& near) {
    Event end;
    end.z = near;
    if (!s.solve_at_load(end.z, 1.0, 1e-9).converged) return false;
    end.tau = step.row.dot(end.z - now_.z);
    if (!(end.tau >= -1e-9 && end.tau <= beyond + 1e-9)) return false;
    found.push_back(std::move(end));
    return true;
  };
  // Where the load only grows along the step, it is reached at one place, which the step's ends tell.
  if (beyond == step.tau && tangent[load] > 0.0 && step.tangent[load] > 0.0 && !step.turned) {
    const double share = (1.0 - now_.z[load]) / (step.z[load] - now_.z[load]);
    const std::optional<Eigen::VectorXd> near = corrected(step, tangent, share * step.tau);
    if (near && ends_at(*near)) return found;
  }
  Eigen::VectorXd before = now_.z;
  double low = 0.0;
  double high = beyond;
  for (int i = 0; i < 60 && high - low > 1e-6 * beyond; ++i) {
    const double middle = 0.5 * (low + high);
    const std::optional<Eigen::VectorXd> z = corrected(step, tangent, middle);
    if (!z) return std::nullopt;
    const bool past = (*z)[load] > 1.0;
    (past ? high : low) = middle;
    if (!past) before = *z;
  }
  if (!ends_at(before)) return std::nullopt;
  return found;
}

bool Tracker::add_releases(const Step& step, std::vector<Event>& found) {
  Statics& s = *now_.statics;
  for (int k = 0; k < s.hold_count(); ++k) {
    const int i = s.force_index(k);
    if (!(s.hold_force(step.z, k) < -1e-12)) continue;
    Event e;
    e.kind = EventKind::release;
    e.contact = k;
    const double share = std::clamp(now_.z[i] / (now_.z[i] - step.z[i]), 0.0, 1.0);
    e.z = now_.z + share * (step.z - now_.z);
    Eigen::VectorXd row = Eigen::VectorXd::Zero(s.size() + 1);
    row[i] = 1.0;
    if (!s.solve(e.z, row, 0.0, 1e-9).converged) return false;
    e.tau = step.row.dot(e.z - now_.z);
    if (!(e.tau >= -1e-7 && e.tau <= step.tau + 1e-7)) return false;
    found.push_back(std::move(e));
  }
  return true;
}

bool Tracker::add_touches(const Step& step, std::vector<Event>& found) {
  Statics& s = *now_.statics;
  const std::vector<double> knots = path_.rod().fixed_knots();
  for (const Certifier::Approach& valley : s.penetrations(step.z)) {
    State state = s.state(step.z);
    PointContact c;
    c.setup.obstacle = valley.obstacle;
    c.setup.at_tip = valley.at.arc_length > 1.0 - knot_distance;
    if (!c.setup.at_tip) place_inside(c, valley.at.arc_length, knots, 2.0 * knot_distance);
    for (const PointContact& other : state.contacts) {
      if (other.setup.obstacle == c.setup.obstacle && std::abs(other.s - c.s) < 1e-3) return false;
    }
    state.contacts.push_back(c);
    sort_contacts(state.contacts);
    int made = -1;
    for (std::size_t k = 0; k < state.contacts.size(); ++k) {
      const PointContact& at = state.contacts[k];
      if (at.s == c.s && at.setup.obstacle == c.setup.obstacle) made = static_cast<int>(k);
    }
    if (!add_hold(step, state, made, found)) return false;
  }
  return true;
}

bool Tracker::add_taut(const Step& step, std::vector<Event>& found) {
  Statics& s = *now_.statics;
  for (int a = 0; a < static_cast<int>(path_.rod().actuators.size()); ++a) {
    if (!(s.slack(step.z, a) < drawn)) continue;
    if (s.lengths_hold(step.z, a)) return false;
    State state = s.state(step.z);
    state.tendons.push_back({a, 0.0});
    if (!add_hold(step, state, s.hold_count(), found)) return false;
  }
  return true;
}

bool Tracker::add_hold(const Step& step, const State& state, int k, std::vector<Event>& found) {
  Statics& s = *now_.statics;
  Event e;
  e.kind = EventKind::touch;
  e.contact = k;
  e.statics = make(state);
  e.z = e.statics->point(state);
  const Eigen::VectorXd row = Eigen::VectorXd::Unit(e.statics->size() + 1, e.statics->force_index(k));
  if (!e.statics->solve(e.z, row, 0.0, 1e-9).converged) return false;
  // What is new has no force yet: without it this is a point of the current system.
  State before = e.statics->state(e.z);
  remove_contact(before, k);
  const Eigen::VectorXd here = s.point(before);
  e.tau = step.row.dot(here - now_.z);
  if (!(e.tau >= -1e-6 && e.tau <= step.tau + 1e-6)) return false;
  found.push_back(std::move(e));
  return true;
}

bool Tracker::add_tip(const Step& step, const Eigen::VectorXd& tangent, std::vector<Event>& found) {
  Statics& s = *now_.statics;
  const double after = s.tip_slope(step.z);
  const double before = s.tip_slope(now_.z);
  if (!(after > 1e-9 && after > before)) return true;
  Event e;
  e.kind = EventKind::tip_leaves;
  double low = 0.0;
  double high = step.tau;
  e.z = now_.z;
  if (before < 0.0) {
    for (int i = 0; i < 60 && high - low > 1e-12; ++i) {
      const double middle = 0.5 * (low + high);
      const std::optional<Eigen::VectorXd> z = corrected(step, tangent, middle);
      if (!z) return false;
      const bool past = s.tip_slope(*z) > 0.0;
      (past ? high : low) = middle;
      if (!past) e.z = *z;
    }
  }
  e.tau = low;
  for (int k = 0; k < s.contact_count(); ++k) {
    if (s.contact(k).at_tip) e.contact = k;
  }
  found.push_back(std::move(e));
  return true;
}

bool Tracker::add_instability(const Step& step, const Eigen::VectorXd& tangent, std::vector<Event>& found) {
  Statics& s = *now_.statics;
  if (!step.turned && s.margin(step.z) > 0.0) return true;
  // What was found before this: beyond it the system is another one, and its margin means nothing.
  double first = infinity;
  for (const Event& e : found) first = std::min(first, e.tau);
  if (step.turned) {
    Event e;
    e.kind = EventKind::fold;
    for (const Eigen::VectorXd* start : {&step.z, static_cast<const Eigen::VectorXd*>(&now_.z)}) {
      e.z = *start;
      if (!s.solve_fold(e.z, e.direction)) continue;
      e.tau = step.row.dot(e.z - now_.z);
      if (!(e.tau >= -1e-7 && e.tau <= step.tau + 1e-7)) continue;
      const double along = s.metric(e.z, e.direction).dot(tangent);
      // Another branch may turn nearby.
      if (!(std::abs(along) >= straightness)) continue;
      if (along < 0.0) e.direction = -e.direction;
      found.push_back(std::move(e));
      return true;
    }
    return first < step.tau;
  }
  Event e;
  e.kind = EventKind::bifurcation;
  // Beside the singular point equilibria are ill-conditioned, but the margin is smooth: bracketed from a little farther
  // off, its root is exact enough.
  double low = 0.0;
  double high = step.tau;
  double above = s.margin(now_.z);
  double below = s.margin(step.z);
  e.z = now_.z;
  Eigen::VectorXd unstable = step.z;
  while (high - low > (above - below < smooth_change ? bracket : jump_bracket)) {
    const double middle = 0.5 * (low + high);
    const std::optional<Eigen::VectorXd> z = corrected(step, tangent, middle);
    if (!z) return false;
    const double margin = s.margin(*z);
    const bool past = !(margin > 0.0);
    (past ? high : low) = middle;
    (past ? unstable : e.z) = *z;
    (past ? below : above) = margin;
  }
  const Eigen::VectorXd gap = unstable - e.z;
  const bool apart = std::sqrt(std::max(0.0, s.metric(e.z, gap).dot(gap))) > same_branch;
  if (apart) return first < low;
  const double share = above > 0.0 ? above / (above - below) : 0.0;
  e.z += share * gap;
  e.tau = low + share * (high - low);
  found.push_back(std::move(e));
  return true;
}

/// A contact made and left within a step shows at neither end. No point of the rod moves farther than the step is long,
/// so an obstacle that is nearer than that at both ends is looked at in between, ever closer.
bool Tracker::passes_through(const Step& step, const Eigen::VectorXd& tangent, double until) {
  Statics& s = *now_.statics;
  if (path_.obstacles().empty() || !(step.tau > 0.0) || !(until > 0.0)) return false;
  const Eigen::VectorXd off = step.z - now_.z;
  double growth = 0.0;
  for (std::size_t o = 0; o < path_.obstacles().size(); ++o) {
    growth = std::max(growth, std::abs(path_.distance_rate(static_cast<int>(o))));
  }
  const double motion = std::sqrt(std::max(0.0, s.metric(now_.z, off).dot(off))) + growth * std::abs(off[s.size()]);
  std::vector<bool> closed(path_.obstacles().size(), false);
  for (int k = 0; k < s.contact_count(); ++k) closed[static_cast<std::size_t>(s.contact(k).obstacle)] = true;
  const auto distances = [&](double t) {
    const Eigen::VectorXd z = between(now_.z, step.tau * tangent, step.z, step.tau * step.tangent, t);
    std::vector<double> d(path_.obstacles().size(), motion);
    for (const Certifier::Approach& a : s.approaches(z, motion)) {
      double& nearest = d[static_cast<std::size_t>(a.obstacle)];
      if (!closed[static_cast<std::size_t>(a.obstacle)]) nearest = std::min(nearest, a.at.distance);
    }
    return d;
  };
  std::vector<double> fine(closed.size());
  std::vector<double> deep(closed.size());
  for (std::size_t o = 0; o < closed.size(); ++o) {
    const double radius = path_.smallest_radius(o, now_.z[s.size()]);
    fine[o] = std::clamp(glancing_share * radius, least_share, glancing);
    deep[o] = std::clamp(interpolation_share * radius, least_share, interpolation);
  }
  struct Span {
    double from, to;
    std::vector<double> at_from, at_to;
  };
  std::vector<Span> spans;
  const double end = std::min(1.0, until / step.tau);
  spans.push_back({0.0, end, distances(0.0), distances(end)});
  while (!spans.empty()) {
    const Span span = std::move(spans.back());
    spans.pop_back();
    const double moved = motion * (span.to - span.from);
    bool near = false;
    for (std::size_t o = 0; o < closed.size(); ++o) {
      near = near || (span.at_from[o] + span.at_to[o] < moved && moved >= fine[o]);
    }
    if (!near) continue;
    const double middle = 0.5 * (span.from + span.to);
    const std::vector<double> d = distances(middle);
    for (std::size_t o = 0; o < closed.size(); ++o) {
      if (d[o] < -deep[o]) return true;
    }
    spans.push_back({middle, span.to, d, span.at_to});
    spans.push_back({span.from, middle, span.at_from, d});
  }
  return false;
}

}  // namespace tendril
