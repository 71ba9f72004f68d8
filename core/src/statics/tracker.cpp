#include "statics/tracker.hpp"

#include <algorithm>
#include <cmath>

#include "tendril/tolerances.hpp"

namespace tendril {
namespace {

constexpr double longest_step = 0.15;  ///< along the path, in the metric of bending energy and load
constexpr double shortest_step = 1e-8;
constexpr double straightness = 0.9;          ///< cosine between the tangents at both ends of a step
constexpr double deviation = 0.25;            ///< of the corrected from the predicted point, per step length
constexpr double beyond_bifurcation = 1e-3;   ///< load fraction; see Snap
constexpr double not_critical = 1e-3;         ///< margin that a fold of the equilibrium cannot have
constexpr double vanishing_convexity = 1e-2;  ///< d_ss (per L) at a turn of the path that a spreading contact explains
constexpr double pinched_length = 1e-4;       ///< between opposite contacts (L)
constexpr double pinching_force = 1e4;        ///< of each; a moment of one over the length above (EI/L^2)
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
    RodState state = now_.statics->state(now_.z);
    PointContact& c = state.contacts[static_cast<std::size_t>(here.leaning)];
    const std::vector<double> knots = path_.rod().fixed_knots();
    const int region = c.setup.region + (here.upward ? 1 : -1);
    if (region >= 0 && region + 1 < static_cast<int>(knots.size())) {
      c.s = knots[static_cast<std::size_t>(here.upward ? region : region + 1)] +
            (here.upward ? 0.1 : -0.1) * knot_distance;
      c.setup.region = region;
      std::unique_ptr<Statics> beside = make(state.contacts);
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
      if (!must_stop_() && spreads(vanishing_convexity)) return false;
      trouble_ = "the path could not be followed beyond load fraction " + shown(now_.z[now_.statics->size()], 9);
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
    double before = step->tau;
    for (const Event& e : *found) before = std::min(before, e.tau);
    if (passes_through(*step, tangent, before)) continue;
    if (found->empty()) {
      now_.z = step->z;
      length_ = std::min(longest_step, 1.5 * length);
      return true;
    }
    Event& first =
        *std::min_element(found->begin(), found->end(), [](const Event& a, const Event& b) { return a.tau < b.tau; });
    // Nothing may be violated there that the step's end did not show.
    Statics& at_event = first.statics ? *first.statics : *now_.statics;
    if (!at_event.penetrations(first.z).empty()) continue;
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
      if (!(sign * (step.z[index] - handed_over(k, up)) > 0.0) || !(sign * (step.z[index] - now_.z[index]) > 0.0))
        continue;
      leaning = k;
      upward = up;
    }
  }
  if (leaning >= 0) {
    // The contact reaches the end of its stretch first: that point is the step's end.
    const int index = s.arc_length_index(leaning);
    const double target = handed_over(leaning, upward);
    if (std::abs(step.z[index] - target) > 10.0 * knot_distance) return std::nullopt;
    step.slide = Event{};
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
      if (turns_by_spreading() || pinched()) return false;
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
      now_.z = event.z;
      if (turns_by_spreading() || pinched()) return false;
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
