#include "tracker.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tendril/tolerances.hpp"

namespace tendril {
namespace {

constexpr double longest_step = 0.15;    ///< along the path, in the metric of bending energy and load
constexpr double shortest_step = 1e-8;
constexpr double straightness = 0.9;     ///< cosine between the tangents at both ends of a step
constexpr double deviation = 0.25;       ///< of the corrected from the predicted point, per step length
constexpr double knot_distance = 1e-6;   ///< where a contact is handed over to the next stretch or the tip
constexpr double beyond_bifurcation = 1e-3;  ///< load fraction; see Snap
constexpr int most_steps = 20000;
constexpr int most_snaps = 50;

}  // namespace

bool Tracker::follow() {
  while (!done_) {
    if (must_stop_()) {
      trouble_ = "stopped";
      return false;
    }
    if (++steps_ > most_steps || static_cast<int>(snaps_.size()) > most_snaps) {
      trouble_ = "the path does not end";
      return false;
    }
    if (spreads() || !advance()) return false;
    if (coarse() && !resolve(1e-8) && coarse()) {
      trouble_ = "the shape cannot be resolved by the fine basis";
      return false;
    }
  }
  return true;
}

bool Tracker::advance() {
  const Eigen::VectorXd tangent = now_.statics->tangent(now_.z);
  if (!tangent.allFinite()) {
    trouble_ = "the equilibrium is singular";
    return false;
  }
  for (double length = length_;; length *= 0.5) {
    if (length < shortest_step || must_stop_()) {
      char text[120];
      std::snprintf(text, sizeof text, "the path could not be followed beyond load fraction %.9f",
                    now_.z[now_.statics->size()]);
      trouble_ = text;
      return false;
    }
    const std::optional<Step> step = try_step(tangent, length);
    if (!step) continue;
    std::optional<std::vector<Event>> found = events(*step, tangent);
    if (!found) continue;
    if (step->slide) {
      Event slide;
      slide.kind = EventKind::slide;
      slide.tau = step->tau;
      slide.contact = step->slide->contact;
      slide.upward = step->slide->upward;
      slide.z = step->z;
      found->push_back(std::move(slide));
    }
    if (found->empty()) {
      now_.z = step->z;
      length_ = std::min(longest_step, 1.5 * length);
      return true;
    }
    Event& first = *std::min_element(found->begin(), found->end(),
                                     [](const Event& a, const Event& b) { return a.tau < b.tau; });
    if (first.kind == EventKind::end) {
      // Nothing may be violated at the end that the step did not show.
      if (!now_.statics->penetrations(first.z).empty()) continue;
      now_.z = first.z;
      done_ = true;
      return true;
    }
    length_ = std::max(0.5 * length, 1e-3);
    return take(first);
  }
}

std::optional<Tracker::Step> Tracker::try_step(const Eigen::VectorXd& tangent, double length) {
  Statics& s = *now_.statics;
  Step step;
  step.row = s.metric(now_.z, tangent);
  step.z = now_.z + length * tangent;
  const Eigen::VectorXd predicted = step.z;
  const Statics::NewtonResult r = s.solve(step.z, step.row, step.row.dot(predicted), knot_distance);
  const std::vector<double> knots = path_.rod().fixed_knots();
  const auto handed_over = [&](int k, bool upward) {
    const auto region = static_cast<std::size_t>(s.contact(k).region);
    return upward ? knots[region + 1] - knot_distance : knots[region] + knot_distance;
  };
  int leaning = r.leaning;
  bool upward = r.upward;
  for (int k = 0; r.converged && k < s.contact_count(); ++k) {
    const int index = s.arc_length_index(k);
    if (index < 0) continue;
    for (const bool up : {false, true}) {
      const double sign = up ? 1.0 : -1.0;
      if (!(sign * (step.z[index] - handed_over(k, up)) > 0.0) || !(sign * (step.z[index] - now_.z[index]) > 0.0)) continue;
      leaning = k;
      upward = up;
    }
  }
  if (leaning >= 0) {
    // The contact reaches the end of its stretch first: that point is the step's end.
    const int index = s.arc_length_index(leaning);
    const double target = handed_over(leaning, upward);
    if (std::abs(step.z[index] - target) > 10.0 * knot_distance) return std::nullopt;
    step.slide.emplace();
    step.slide->contact = leaning;
    step.slide->upward = upward;
    Eigen::VectorXd row = Eigen::VectorXd::Zero(s.size() + 1);
    row[index] = 1.0;
    if ((upward ? now_.z[index] - target : target - now_.z[index]) >= 0.0) {
      step.z = now_.z;
    } else {
      const double share = (target - now_.z[index]) / (tangent[index] != 0.0 ? tangent[index] : 1.0);
      step.z = now_.z + std::clamp(share, 0.0, length) * tangent;
      step.z[index] = target;
      if (!s.solve(step.z, row, target, 0.5 * knot_distance).converged) return std::nullopt;
    }
  } else if (!r.converged) {
    return std::nullopt;
  }
  const Eigen::VectorXd off = step.z - now_.z;
  step.tau = step.row.dot(off);
  if (step.slide) {
    if (!(step.tau >= -1e-9 && step.tau <= 1.5 * length)) return std::nullopt;
  } else {
    const Eigen::VectorXd wrong = step.z - predicted;
    if (std::sqrt(std::max(0.0, s.metric(now_.z, wrong).dot(wrong))) > deviation * length) return std::nullopt;
  }
  step.tangent = s.tangent(step.z);
  if (!step.tangent.allFinite()) return std::nullopt;
  double cosine = step.row.dot(step.tangent);
  step.turned = cosine < 0.0;
  if (step.turned) {
    step.tangent = -step.tangent;
    cosine = -cosine;
  }
  if (cosine < straightness) return std::nullopt;
  return step;
}

std::optional<Eigen::VectorXd> Tracker::corrected(const Step& step, const Eigen::VectorXd& tangent, double tau) {
  Eigen::VectorXd z = now_.z + tau * tangent;
  if (step.tau > 0.0) z += (tau / step.tau) * (step.z - now_.z - step.tau * tangent);
  if (!now_.statics->solve(z, step.row, step.row.dot(now_.z) + tau, 1e-9).converged) return std::nullopt;
  return z;
}

std::optional<std::vector<Tracker::Event>> Tracker::events(const Step& step, const Eigen::VectorXd& tangent) {
  std::vector<Event> found;
  Statics& s = *now_.statics;
  const int load = s.size();
  const bool good = add_releases(step, found) && add_touches(step, found) && add_tip(step, tangent, found) &&
                    add_instability(step, tangent, found);
  if (!good) return std::nullopt;
  // The final loads may lie before the step's end, or between here and a fold at still higher ones.
  double beyond = step.z[load] >= 1.0 ? step.tau : infinity;
  for (const Event& e : found) {
    if (e.kind == EventKind::fold && e.z[load] >= 1.0) beyond = std::min(beyond, e.tau);
  }
  if (!std::isfinite(beyond)) return found;
  Event end;
  double low = 0.0;
  double high = beyond;
  end.z = now_.z;
  for (int i = 0; i < 60 && high - low > 1e-6 * beyond; ++i) {
    const double middle = 0.5 * (low + high);
    const std::optional<Eigen::VectorXd> z = corrected(step, tangent, middle);
    if (!z) return std::nullopt;
    const bool past = (*z)[load] > 1.0;
    (past ? high : low) = middle;
    if (!past) end.z = *z;
  }
  if (!s.solve_at_load(end.z, 1.0, 1e-9).converged) return std::nullopt;
  end.tau = step.row.dot(end.z - now_.z);
  if (!(end.tau >= -1e-9 && end.tau <= beyond + 1e-9)) return std::nullopt;
  found.push_back(std::move(end));
  return found;
}

bool Tracker::add_releases(const Step& step, std::vector<Event>& found) {
  Statics& s = *now_.statics;
  for (int k = 0; k < s.contact_count(); ++k) {
    const int i = s.force_index(k);
    if (!(step.z[i] < -1e-12)) continue;
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
    RodState state = s.state(step.z);
    PointContact c;
    c.setup.obstacle = valley.obstacle;
    c.s = valley.at.arc_length;
    c.setup.at_tip = c.s > 1.0 - knot_distance;
    if (c.setup.at_tip) {
      c.s = 1.0;
    } else {
      while (c.setup.region + 2 < static_cast<int>(knots.size()) &&
             c.s >= knots[static_cast<std::size_t>(c.setup.region) + 1]) {
        ++c.setup.region;
      }
      const auto r = static_cast<std::size_t>(c.setup.region);
      c.s = std::clamp(c.s, knots[r] + 2.0 * knot_distance, knots[r + 1] - 2.0 * knot_distance);
    }
    for (const PointContact& other : state.contacts) {
      if (other.setup.obstacle == c.setup.obstacle && std::abs(other.s - c.s) < 1e-3) return false;
    }
    state.contacts.push_back(c);
    sort_contacts(state.contacts);
    Event e;
    e.kind = EventKind::touch;
    e.statics = make(state.contacts);
    e.z = e.statics->point(state);
    for (int k = 0; k < e.statics->contact_count(); ++k) {
      const PointContact& at = state.contacts[static_cast<std::size_t>(k)];
      if (at.s == c.s && at.setup.obstacle == c.setup.obstacle) e.contact = k;
    }
    Eigen::VectorXd row = Eigen::VectorXd::Zero(e.statics->size() + 1);
    row[e.statics->force_index(e.contact)] = 1.0;
    if (!e.statics->solve(e.z, row, 0.0, 1e-9).converged) return false;
    // The new contact has no force yet: without it this is a point of the current system.
    RodState before = e.statics->state(e.z);
    before.contacts.erase(before.contacts.begin() + e.contact);
    const Eigen::VectorXd here = s.point(before);
    e.tau = step.row.dot(here - now_.z);
    if (!(e.tau >= -1e-6 && e.tau <= step.tau + 1e-6)) return false;
    found.push_back(std::move(e));
  }
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
      if (s.metric(e.z, e.direction).dot(tangent) < 0.0) e.direction = -e.direction;
      found.push_back(std::move(e));
      return true;
    }
    return first < step.tau;
  }
  Event e;
  e.kind = EventKind::bifurcation;
  double low = 0.0;
  double high = step.tau;
  e.z = now_.z;
  for (int i = 0; i < 40 && high - low > 1e-10; ++i) {
    const double middle = 0.5 * (low + high);
    const std::optional<Eigen::VectorXd> z = corrected(step, tangent, middle);
    if (!z) return false;
    const bool past = !(s.margin(*z) > 0.0);
    (past ? high : low) = middle;
    if (!past) e.z = *z;
  }
  e.tau = low;
  found.push_back(std::move(e));
  return true;
}

bool Tracker::take(Event& event) {
  switch (event.kind) {
    case EventKind::release:
      return release(event);
    case EventKind::touch: {
      ++contact_changes_;
      now_ = {std::move(event.statics), std::move(event.z)};
      return true;
    }
    case EventKind::slide:
      return slide(event);
    case EventKind::tip_leaves:
      return leave_tip(event);
    case EventKind::fold: {
      now_.z = event.z;
      // The place of the fold is a result: as exact as the basis can be.
      const int order = order_;
      const int pieces = pieces_;
      Eigen::VectorXd z = event.z;
      while (now_.statics->moment_balance(z) > 1e-9 && order_ < 40) {
        order_ += 8;
        const RodState state = now_.statics->state(z);
        std::unique_ptr<Statics> finer = make(state.contacts);
        Eigen::VectorXd there = finer->point(state);
        const Shape along = now_.statics->direction(z, event.direction);
        RodState direction = state;
        direction.curvature = [along](double s) { return along.curvature(s); };
        const Eigen::VectorXd travelled = finer->point(direction);
        Eigen::VectorXd found;
        if (!finer->solve_fold(there, found)) {
          order_ = order;
          pieces_ = pieces;
          break;
        }
        const double sign = finer->metric(there, found).dot(travelled) < 0.0 ? -1.0 : 1.0;
        event.direction = sign * found;
        z = there;
        now_ = {std::move(finer), there};
      }
      return snap(SnapKind::fold, z, &event.direction, z[now_.statics->size()]);
    }
    case EventKind::bifurcation: {
      Statics& s = *now_.statics;
      const double at = event.z[s.size()];
      const double load = std::min(1.0, at + beyond_bifurcation);
      if (at >= 1.0 - 1e-9) {
        trouble_ = "the final loads are the critical ones";
        return false;
      }
      const Eigen::VectorXd direction = s.weakest_direction(event.z);
      return snap(SnapKind::bifurcation, event.z, direction.allFinite() ? &direction : nullptr, load);
    }
    case EventKind::end:
      break;
  }
  return false;
}

bool Tracker::release(Event& event) {
  RodState state = now_.statics->state(event.z);
  state.contacts.erase(state.contacts.begin() + event.contact);
  std::unique_ptr<Statics> statics = make(state.contacts);
  Eigen::VectorXd z = statics->point(state);
  ++contact_changes_;
  const Statics::NewtonResult r = statics->solve_at_load(z, state.load, 1e-9);
  if (r.converged && statics->margin(z) > tolerance::stability) {
    now_ = {std::move(statics), std::move(z)};
    return true;
  }
  // Without this contact the state is not stable.
  now_.z = event.z;
  if (!r.converged) z = statics->point(state);
  now_ = {std::move(statics), z};
  return snap(SnapKind::release, z, nullptr, state.load);
}

bool Tracker::slide(Event& event) {
  RodState state = now_.statics->state(event.z);
  PointContact& c = state.contacts[static_cast<std::size_t>(event.contact)];
  const std::vector<double> knots = path_.rod().fixed_knots();
  const auto region = static_cast<std::size_t>(c.setup.region);
  if (!event.upward && region == 0) {
    trouble_ = "a contact slides to the base";
    return false;
  }
  const bool to_tip = event.upward && region + 2 == knots.size();
  const double knot = event.upward ? knots[region + 1] : knots[region];
  const double s = knot + (event.upward ? knot_distance : -knot_distance);
  if (to_tip) {
    c.setup.at_tip = true;
    c.setup.region = 0;
    c.s = 1.0;
  } else {
    c.setup.region += event.upward ? 1 : -1;
    c.s = s;
  }
  std::unique_ptr<Statics> statics = make(state.contacts);
  Eigen::VectorXd z = statics->point(state);
  Eigen::VectorXd row = Eigen::VectorXd::Zero(statics->size() + 1);
  double value = state.load;
  if (to_tip) {
    row[statics->size()] = 1.0;
  } else {
    row[statics->arc_length_index(event.contact)] = 1.0;
    value = s;
  }
  if (!statics->solve(z, row, value, 0.1 * knot_distance).converged) {
    trouble_ = "a contact could not be followed over the end of a stretch";
    return false;
  }
  now_ = {std::move(statics), std::move(z)};
  return true;
}

bool Tracker::leave_tip(Event& event) {
  RodState state = now_.statics->state(event.z);
  PointContact& c = state.contacts[static_cast<std::size_t>(event.contact)];
  const std::vector<double> knots = path_.rod().fixed_knots();
  c.setup.at_tip = false;
  c.setup.region = static_cast<int>(knots.size()) - 2;
  c.s = 1.0 - knot_distance;
  std::unique_ptr<Statics> statics = make(state.contacts);
  // Sorted: the contact is now the last interior one.
  sort_contacts(state.contacts);
  int k = 0;
  while (k + 1 < statics->contact_count() && state.contacts[static_cast<std::size_t>(k)].s != 1.0 - knot_distance) ++k;
  Eigen::VectorXd z = statics->point(state);
  Eigen::VectorXd row = Eigen::VectorXd::Zero(statics->size() + 1);
  row[statics->arc_length_index(k)] = 1.0;
  if (!statics->solve(z, row, 1.0 - knot_distance, 0.1 * knot_distance).converged) {
    trouble_ = "a contact could not be followed from the tip into the rod";
    return false;
  }
  now_ = {std::move(statics), std::move(z)};
  return true;
}

}  // namespace tendril
