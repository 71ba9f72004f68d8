#include "statics/tracker.hpp"

#include <algorithm>
#include <cmath>

#include "tendril/tolerances.hpp"

namespace tendril {
namespace {

constexpr double longest_path_step = 0.15;  ///< along the path, in the metric of bending energy and load
constexpr double shortest_step = 1e-8;
constexpr double over_seam = 100.0 * shortest_step;  ///< a seam of an obstacle that stops the path is nearer than that
constexpr double deviation = 0.25;                   ///< of the corrected from the predicted point, per step length
constexpr double beyond_bifurcation = 1e-3;          ///< load fraction; see Snap
constexpr double not_critical = 1e-3;                ///< margin that a fold of the equilibrium cannot have
constexpr double vanishing_convexity = 1e-2;  ///< d_ss (per L) at a turn of the path that a spreading contact explains
constexpr double pinched_length = 1e-4;       ///< between opposite contacts (L)
constexpr double pinching_force = 1e4;        ///< of each; a moment of one over the length above (EI/L^2)
constexpr double overdrawn_slack = 1e-6;      ///< of a tendon that is about to be taut
constexpr int most_path_steps = 20000;
constexpr int most_snaps = 50;

}  // namespace

bool Tracker::follow() {
  while (!done_) {
    if (must_stop_()) {
      trouble_ = "stopped";
      return false;
    }
    if (++steps_ > most_path_steps || static_cast<int>(snaps_.size()) > most_snaps) {
      trouble_ = "the path does not end";
      return false;
    }
    if (spreads(0.0)) return false;
    const bool passed = now_.z[now_.statics->size()] > 1.0;
    if (!(passed ? go_back_to_end() : advance())) {
      pinched();
      return false;
    }
    if (coarse() && !resolve(1e-8) && coarse()) {
      trouble_ = "the shape cannot be resolved by the fine basis";
      return false;
    }
  }
  return true;
}

bool Tracker::go_back_to_end() {
  constexpr double at_knot = 1e-10;  // (L) as short as a piece may be
  Eigen::VectorXd z = now_.z;
  const Statics::NewtonResult here = now_.statics->solve_at_load(z, 1.0, at_knot);
  if (!here.converged && here.leaning >= 0) {
    State state = now_.statics->state(now_.z);
    PointContact& c = state.contacts[static_cast<std::size_t>(here.leaning)];
    if (hand_over(c, here.upward, path_.rod().fixed_knots(), 0.1 * knot_distance) && !c.setup.at_tip) {
      std::unique_ptr<Statics> beside = make(state);
      z = beside->point(state);
      if (beside->solve_at_load(z, 1.0, at_knot).converged) {
        now_ = {std::move(beside), std::move(z)};
        done_ = true;
        return true;
      }
    }
  }
  if (!here.converged) {
    trouble_ = "the final loads could not be reached from just beyond them";
    return false;
  }
  now_.z = z;
  done_ = true;
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
      // Where d_ss vanishes the contact has no place of its own.
      if (!must_stop_() && (spreads(vanishing_convexity) || overdrawn())) return false;
      if (!must_stop_() && ends_at_seam(tangent)) {
        Eigen::VectorXd direction = tangent;
        direction[now_.statics->size()] = 0.0;
        const Eigen::VectorXd last = now_.z;
        return snap(SnapKind::fold, last, &direction, last[now_.statics->size()]);
      }
      trouble_ = "the path could not be followed beyond load fraction " + shown(now_.z[now_.statics->size()], 9);
      return false;
    }
    const std::optional<Step> step = try_step(tangent, length);
    if (!step) continue;
    std::optional<std::vector<Event>> found = events(*step, tangent);
    if (!found) continue;
    if (step->handover) {
      Event handover;
      handover.kind = EventKind::handover;
      handover.tau = step->tau;
      handover.contact = step->handover->contact;
      handover.upward = step->handover->upward;
      handover.z = step->z;
      found->push_back(std::move(handover));
    }
    double before = step->tau;
    for (const Event& e : *found) before = std::min(before, e.tau);
    if (passes_through(*step, tangent, before)) continue;
    if (found->empty()) {
      now_.z = step->z;
      now_.statics->anchor(now_.z);
      length_ = std::min(longest_path_step, 1.5 * length);
      return true;
    }
    Event& first =
        *std::min_element(found->begin(), found->end(), [](const Event& a, const Event& b) { return a.tau < b.tau; });
    // Nothing may be violated there that the step's end did not show.
    Statics& at_event = first.statics ? *first.statics : *now_.statics;
    if (!at_event.penetrations(first.z).empty() || longest_tendon(at_event, first.z) >= 0) continue;
    if (first.kind == EventKind::touch && at_event.tip_slope(first.z) > tolerance::closest_point) continue;
    if (first.kind == EventKind::end) {
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
  if (!end_at_knot(step, tangent, length, r)) return std::nullopt;
  if (!r.converged && !step.handover) return std::nullopt;
  const Eigen::VectorXd off = step.z - now_.z;
  step.tau = step.row.dot(off);
  if (step.handover) {
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

bool Tracker::end_at_knot(Step& step, const Eigen::VectorXd& tangent, double length, const Statics::NewtonResult& r) {
  Statics& s = *now_.statics;
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
      const bool beyond = sign * (step.z[index] - handed_over(k, up)) > 0.0;
      if (!beyond || !(sign * (step.z[index] - now_.z[index]) > 0.0)) continue;
      leaning = k;
      upward = up;
    }
  }
  if (leaning < 0) return true;
  // The contact reaches the end of its stretch first: that point is the step's end.
  const int index = s.arc_length_index(leaning);
  const double target = handed_over(leaning, upward);
  if (std::abs(step.z[index] - target) > 10.0 * knot_distance) return false;
  step.handover = {leaning, upward};
  if ((upward ? now_.z[index] - target : target - now_.z[index]) >= 0.0) {
    step.z = now_.z;
    return true;
  }
  const double share = (target - now_.z[index]) / (tangent[index] != 0.0 ? tangent[index] : 1.0);
  step.z = now_.z + std::clamp(share, 0.0, length) * tangent;
  step.z[index] = target;
  return s.solve(step.z, Eigen::VectorXd::Unit(s.size() + 1, index), target, 0.5 * knot_distance).converged;
}

std::optional<Eigen::VectorXd> Tracker::corrected(const Step& step, const Eigen::VectorXd& tangent, double tau) {
  Eigen::VectorXd z = now_.z + tau * tangent;
  if (step.tau > 0.0) z += (tau / step.tau) * (step.z - now_.z - step.tau * tangent);
  if (!now_.statics->solve(z, step.row, step.row.dot(now_.z) + tau, 1e-9).converged) return std::nullopt;
  return z;
}

bool Tracker::take(Event& event) { return take_first(event) && choose_friction(); }

bool Tracker::take_first(Event& event) {
  switch (event.kind) {
    case EventKind::release:
      return release(event);
    case EventKind::touch: {
      count_change(event.contact < event.statics->contact_count());
      now_ = {std::move(event.statics), std::move(event.z)};
      return true;
    }
    case EventKind::handover:
      return pass_knot(event);
    case EventKind::tip_leaves:
      return leave_tip(event);
    case EventKind::slip:
    case EventKind::stick:
      now_.z = event.z;
      return set_friction(event.contact, event.lean);
    case EventKind::fold:
      return take_fold(event);
    case EventKind::bifurcation:
      return take_bifurcation(event);
    case EventKind::end:
      break;
  }
  return false;
}

bool Tracker::take_fold(Event& event) {
  now_.z = event.z;
  if (turns_by_spreading() || pinched()) return false;
  // The place of the fold is a result: as exact as the basis can be.
  const int order = order_;
  Eigen::VectorXd z = event.z;
  while (now_.statics->moment_balance(z) > 1e-9 && order_ < 40) {
    order_ += 8;
    const State state = now_.statics->state(z);
    std::unique_ptr<Statics> finer = make(state);
    Eigen::VectorXd there = finer->point(state);
    State direction = state;
    direction.curvature = now_.statics->curvature(z, event.direction);
    const Eigen::VectorXd travelled = finer->point(direction);
    Eigen::VectorXd found;
    if (!finer->solve_fold(there, found)) {
      order_ = order;
      break;
    }
    const double sign = finer->metric(there, found).dot(travelled) < 0.0 ? -1.0 : 1.0;
    event.direction = sign * found;
    z = there;
    now_ = {std::move(finer), there};
  }
  return snap(SnapKind::fold, z, &event.direction, z[now_.statics->size()]);
}

bool Tracker::take_bifurcation(const Event& event) {
  now_.z = event.z;
  if (turns_by_spreading() || pinched()) return false;
  Statics& s = *now_.statics;
  const double at = event.z[s.size()];
  if (at >= 1.0 - 1e-9) {
    trouble_ = "the final loads are the critical ones";
    return false;
  }
  const Eigen::VectorXd direction = s.weakest_direction(event.z);
  return snap(SnapKind::bifurcation, event.z, direction.allFinite() ? &direction : nullptr,
              std::min(1.0, at + beyond_bifurcation));
}

/// Where a contact slides from one patch of an obstacle to another its curvature jumps, and the margin with it: the
/// path turns there without a fold that either patch has.
bool Tracker::ends_at_seam(const Eigen::VectorXd& tangent) {
  Statics& s = *now_.statics;
  const Eigen::VectorXd behind = now_.z + over_seam * tangent;
  const auto patches = [&](const Eigen::VectorXd& z) {
    const std::vector<PoseProgram::ContactState>& contacts = s.at(z).contacts();
    std::vector<int> on;
    for (int k = 0; k < s.contact_count(); ++k) {
      const auto o = static_cast<std::size_t>(s.contact(k).obstacle);
      on.push_back(path_.obstacles()[o]->patch_at(contacts[static_cast<std::size_t>(k)].point));
    }
    return on;
  };
  if (patches(now_.z) == patches(behind)) return false;
  return s.margin(now_.z) > not_critical && s.margin(behind) < -not_critical;
}

/// A path also turns, and its margin jumps, where a contact's d_ss passes zero; nothing gives way there.
bool Tracker::turns_by_spreading() {
  return now_.statics->margin(now_.z) > not_critical && spreads(vanishing_convexity);
}

/// Two obstacles that close on the rod press ever harder at one point of it, until nothing can be followed any more.
bool Tracker::pinched() {
  const std::vector<PointContact> contacts = now_.statics->state(now_.z).contacts;
  for (std::size_t k = 0; k + 1 < contacts.size(); ++k) {
    const PointContact& a = contacts[k];
    const PointContact& b = contacts[k + 1];
    if (!(std::abs(a.s - b.s) < pinched_length && std::min(a.force, b.force) > pinching_force)) continue;
    trouble_ = "two obstacles close on the rod at " + shown(a.s, 4) + " L and load fraction " +
               shown(now_.z[now_.statics->size()]) + ": there is no room between them";
    return true;
  }
  return false;
}

bool Tracker::overdrawn() {
  Statics& s = *now_.statics;
  for (int a = 0; a < static_cast<int>(path_.rod().actuators.size()); ++a) {
    if (!(s.slack(now_.z, a) < overdrawn_slack) || !s.lengths_hold(now_.z, a)) continue;
    trouble_ = "the lengths of tendons contradict each other at load fraction " +
               shown(std::max(0.0, now_.z[s.size()]), 9) + ": the others hold that of actuator " +
               std::to_string(a + 1) + ", which cannot be as short";
    return true;
  }
  return false;
}

bool Tracker::release(Event& event) {
  State state = now_.statics->state(event.z);
  remove_contact(state, event.contact);
  count_change(event.contact < now_.statics->contact_count());
  std::unique_ptr<Statics> statics = make(state);
  Eigen::VectorXd z = statics->point(state);
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

bool Tracker::pass_knot(Event& event) {
  State state = now_.statics->state(event.z);
  PointContact& c = state.contacts[static_cast<std::size_t>(event.contact)];
  if (!hand_over(c, event.upward, path_.rod().fixed_knots(), knot_distance)) {
    trouble_ = "a contact slides to the base";
    return false;
  }
  const bool to_tip = c.setup.at_tip;
  const double s = c.s;
  std::unique_ptr<Statics> statics = make(state);
  Eigen::VectorXd z = statics->point(state);
  Eigen::VectorXd row = Eigen::VectorXd::Zero(statics->size() + 1);
  double value = state.load;
  if (to_tip) {
    row[statics->size()] = 1.0;
  } else {
    row[statics->arc_length_index(event.contact)] = 1.0;
    value = s;
  }
  const Eigen::VectorXd guess = z;
  const bool followed = statics->solve(z, row, value, 0.1 * knot_distance).converged;
  if (to_tip && (!followed || !(statics->margin(z) > 0.0))) {
    // Inside the rod a contact can give by sliding; at the tip there is no further place to slide to.
    now_ = {std::move(statics), guess};
    return snap(SnapKind::slip, guess, nullptr, state.load);
  }
  if (!followed) {
    trouble_ = "a contact could not be followed over the end of a stretch";
    return false;
  }
  now_ = {std::move(statics), std::move(z)};
  return true;
}

bool Tracker::leave_tip(Event& event) {
  State state = now_.statics->state(event.z);
  PointContact& c = state.contacts[static_cast<std::size_t>(event.contact)];
  place_inside(c, 1.0, path_.rod().fixed_knots(), knot_distance);
  std::unique_ptr<Statics> statics = make(state);
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
