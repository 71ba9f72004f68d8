#include <algorithm>
#include <cmath>

#include "statics/tracker.hpp"
#include "tendril/tolerances.hpp"

namespace tendril {
namespace {

constexpr double coarse_balance = 1e-7;  ///< defect of the moment balance at which the basis is refined on the way
constexpr double fine_balance = 1e-11;   ///< ... and below which it is fine enough at the end and at folds
constexpr int orders[] = {12, 16, 22, 30, 40};
constexpr int most_pieces = 16;
constexpr int most_misses = 5;  ///< refinements in a row that gain nothing before the best basis is kept
constexpr int most_repairs = 40;
constexpr double pull = -1e-10;      ///< a force below it would have to pull
constexpr double past_knot = 2e-6;   ///< where a contact that slid over a knot starts on the other side
constexpr double same_place = 2e-3;  ///< a penetration this near to a contact on the same obstacle is its own
/// First move along a critical direction, in the metric, and how much further the load is while the rod falls: where
/// contacts hold it, the soft contacts of the descent give way a little later than the rigid ones.
struct Push {
  double along, extra;
};
constexpr Push pushes[] = {{0.03, 0.0}, {0.1, 0.0}, {0.1, 1e-3}, {0.3, 1e-3}, {0.3, 1e-2}, {0.3, 3e-2}};

}  // namespace

std::unique_ptr<Statics> Tracker::make(const State& state) {
  return std::make_unique<Statics>(path_, std::make_shared<LegendreBasis>(order_, pieces_), state.contacts, nodes_,
                                   state.tendons);
}

void Tracker::remove_contact(State& state, int k) {
  const int contacts = static_cast<int>(state.contacts.size());
  if (k < contacts) {
    state.contacts.erase(state.contacts.begin() + k);
  } else {
    state.tendons.erase(state.tendons.begin() + (k - contacts));
  }
}

/// Enough nodes for the angle that the rod turns through now, and some more.
void Tracker::choose_nodes() {
  const PoseProgram& program = now_.statics->at(now_.z);
  const Backbone& shape = program.backbone();
  double turn = 1.0;
  for (int j = 0; j < program.chain().piece_count(); ++j) {
    double along = 0.0;
    const int n = program.chain().bends();
    for (int i = 0; i < n; ++i) along += std::abs(shape.coordinates(j)[i]) / (i == 0 ? 1.0 : 2.0 * i + 1.0);
    turn = std::max(turn, along);
  }
  const int wanted = suggested_nodes(order_, std::min(turn, 60.0) + 2.0);
  nodes_ = std::max(wanted, nodes_ * 2 / 3);
}

bool Tracker::rebuild() {
  choose_nodes();
  const State state = now_.statics->state(now_.z);
  std::unique_ptr<Statics> statics = make(state);
  Eigen::VectorXd z = statics->point(state);
  if (!statics->solve_at_load(z, state.load, 1e-9).converged) return false;
  now_ = {std::move(statics), std::move(z)};
  return true;
}

bool Tracker::resolve(double enough) {
  double balance = now_.statics->moment_balance(now_.z);
  int order = order_;
  int pieces = pieces_;
  int misses = 0;
  while (!(balance <= enough)) {
    const auto* const next = std::find_if(std::begin(orders), std::end(orders), [&](int o) { return o > order_; });
    if (next != std::end(orders)) {
      order_ = *next;
    } else if (pieces_ < most_pieces) {
      pieces_ *= 2;
      order_ = orders[1];
    } else {
      misses = most_misses;
    }
    const double finer = misses < most_misses && rebuild() ? now_.statics->moment_balance(now_.z) : infinity;
    if (finer <= 0.5 * balance) {
      balance = finer;
      order = order_;
      pieces = pieces_;
      misses = 0;
      continue;
    }
    // Near rounding one refinement without gain tells enough. Far above it the shape may not be resolved at all yet: a
    // series gains nothing until it has a few functions per turn, or per boundary layer.
    if (++misses < (balance <= tolerance::moment_balance ? 1 : most_misses) && !must_stop_()) continue;
    order_ = order;
    pieces_ = pieces;
    rebuild();
    return false;
  }
  return true;
}

bool Tracker::coarse() const { return now_.statics->moment_balance(now_.z) > coarse_balance; }

void Tracker::refine_fully() { resolve(fine_balance); }

bool Tracker::begin(const State& guess, Start start) {
  std::optional<Settled> near = start == Start::relax ? std::nullopt : settle(guess, 0.0);
  const auto stable = [](Settled& s) { return s.statics->margin(s.z) > tolerance::stability; };
  if (near && start == Start::near && stable(*near)) {
    // Newton's method may have gone to another equilibrium than the one below the guess.
    State there = near->statics->state(near->z);
    there.curvature = guess.curvature;
    Eigen::VectorXd from = near->statics->point(there);
    from -= near->z;
    from[near->statics->size()] = 0.0;
    if (std::sqrt(near->statics->metric(near->z, from).dot(from)) > 1.0) near.reset();
  }
  if (near && stable(*near)) {
    now_ = std::move(*near);
  } else {
    double energy = 0.0;
    std::optional<Settled> below = fall(guess.curvature, 0.0, 0.0, energy);
    if (!below) {
      trouble_ = "no stable equilibrium was found near the start" + (trouble_.empty() ? "" : ": " + trouble_);
      return false;
    }
    TrackedSnap jump;
    jump.kind = SnapKind::start;
    jump.before.statics = make({});
    jump.before.z = jump.before.statics->point({guess.curvature, {}, 0.0});
    jump.after.statics = make(below->statics->state(below->z));
    jump.after.z = below->z;
    jump.margin = below->statics->margin(below->z);
    snaps_.push_back(std::move(jump));
    now_ = std::move(*below);
  }
  trouble_.clear();
  spread_ = false;
  rebuild();
  resolve(coarse_balance);
  return choose_friction();
}

std::optional<Settled> Tracker::settle(State guess, double load) {
  guess.load = load;
  const std::vector<double> knots = path_.rod().fixed_knots();
  for (PointContact& c : guess.contacts) {
    if (!c.setup.at_tip) place_inside(c, c.s, knots, past_knot);
  }
  for (int attempt = 0; attempt < most_repairs && !must_stop_(); ++attempt) {
    sort_contacts(guess.contacts);
    Settled s{make(guess), {}};
    s.z = s.statics->point(guess);
    // Of tendons whose lengths are one the lengths decide one tension.
    const auto held = std::find_if(guess.tendons.rbegin(), guess.tendons.rend(),
                                   [&](const TautTendon& t) { return s.statics->lengths_hold(s.z, t.actuator); });
    if (held != guess.tendons.rend()) {
      guess.tendons.erase(std::prev(held.base()));
      continue;
    }
    const Statics::NewtonResult r = s.statics->solve_at_load(s.z, load);
    if (r.leaning >= 0) {
      PointContact& c = guess.contacts[static_cast<std::size_t>(r.leaning)];
      const double knot = knots[static_cast<std::size_t>(c.setup.region) + (r.upward ? 1U : 0U)];
      const double at = s.z[s.statics->arc_length_index(r.leaning)];
      if (std::abs(at - knot) > 1e-4 || !hand_over(c, r.upward, knots, past_knot)) {
        trouble_ = "two contacts meet, or one slides to the base";
        return std::nullopt;
      }
      continue;
    }
    if (!r.converged) {
      trouble_ = "Newton's method did not converge";
      return std::nullopt;
    }
    switch (repair(guess, s)) {
      case Repair::needless:
        return s;
      case Repair::impossible:
        return std::nullopt;
      case Repair::made:
        break;
    }
  }
  trouble_ = must_stop_() ? "stopped" : "the contacts that hold the rod could not be found";
  return std::nullopt;
}

Tracker::Repair Tracker::repair(State& guess, Settled& s) {
  const State found = s.statics->state(s.z);
  int weakest = 0;
  bool at_tip = false;
  for (int k = 0; k < s.statics->hold_count(); ++k) {
    if (s.statics->hold_force(s.z, k) < s.statics->hold_force(s.z, weakest)) weakest = k;
    at_tip = at_tip || (k < s.statics->contact_count() && s.statics->contact(k).at_tip);
  }
  if (s.statics->hold_count() > 0 && s.statics->hold_force(s.z, weakest) < pull) {
    guess = found;
    remove_contact(guess, weakest);
    return Repair::made;
  }
  const double tip_slope = at_tip ? s.statics->tip_slope(s.z) : -1.0;
  if (tip_slope > tolerance::closest_point) {
    guess = found;
    const std::vector<double> knots = path_.rod().fixed_knots();
    const double last = knots[knots.size() - 2];
    for (PointContact& c : guess.contacts) {
      if (c.setup.at_tip) place_inside(c, std::max(last, 1.0 - 0.1 * tip_slope), knots, past_knot);
    }
    return Repair::made;
  }
  const Repair repaired = repair_penetration(guess, s);
  return repaired == Repair::needless ? repair_slack(guess, s) : repaired;
}

int Tracker::longest_tendon(Statics& statics, const Eigen::VectorXd& z) const {
  int longest = -1;
  double most = drawn;
  for (int a = 0; a < static_cast<int>(path_.rod().actuators.size()); ++a) {
    const double slack = statics.slack(z, a);
    if (!(slack < most)) continue;
    most = slack;
    longest = a;
  }
  return longest;
}

Tracker::Repair Tracker::repair_slack(State& guess, Settled& s) {
  const int longest = longest_tendon(*s.statics, s.z);
  if (longest < 0) return Repair::needless;
  guess = s.statics->state(s.z);
  guess.tendons.push_back({longest, 0.0});
  return Repair::made;
}

Tracker::Repair Tracker::repair_penetration(State& guess, Settled& s) {
  const std::vector<Certifier::Approach> deep = s.statics->penetrations(s.z);
  if (deep.empty()) return Repair::needless;
  const Certifier::Approach& worst = *std::min_element(
      deep.begin(), deep.end(),
      [](const Certifier::Approach& a, const Certifier::Approach& b) { return a.at.distance < b.at.distance; });
  guess = s.statics->state(s.z);
  const bool own = std::any_of(guess.contacts.begin(), guess.contacts.end(), [&](const PointContact& c) {
    return c.setup.obstacle == worst.obstacle && std::abs(c.s - worst.at.arc_length) < same_place;
  });
  if (own) {
    spread_ = true;
    trouble_ = "contact spreads: beside the contact at " + shown(worst.at.arc_length, 4) +
               " L the rod lies along the obstacle";
    return Repair::impossible;
  }
  PointContact c;
  c.setup.obstacle = worst.obstacle;
  c.s = worst.at.arc_length;
  c.setup.at_tip = c.s > 1.0 - 1e-7;
  if (!c.setup.at_tip) place_inside(c, c.s, path_.rod().fixed_knots(), past_knot);
  guess.contacts.push_back(c);
  return Repair::made;
}

bool Tracker::spreads(double least) {
  for (int k = 0; k < now_.statics->contact_count(); ++k) {
    if (!(now_.z[now_.statics->force_index(k)] > tolerance::force)) continue;
    if (now_.statics->convexity(now_.z, k) > least) continue;
    spread_ = true;
    trouble_ = "contact spreads at load fraction " + shown(now_.z[now_.statics->size()]) + ": from the point at " +
               shown(now_.statics->state(now_.z).contacts[static_cast<std::size_t>(k)].s, 4) +
               " L on the rod lies along the obstacle, a point contact does not hold it";
    return true;
  }
  return false;
}

std::optional<Settled> Tracker::fall(const Curvature& curvature, double load, double extra, double& energy) {
  const Descent down = descend(path_, load + extra, curvature, must_stop_);
  if (!down.converged) {
    trouble_ = down.reason;
    return std::nullopt;
  }
  energy = down.energy;
  std::optional<Settled> found = settle(down.state, load);
  if (!found) return std::nullopt;
  if (!(found->statics->margin(found->z) > tolerance::stability)) {
    trouble_ = "the state below is not stable";
    return std::nullopt;
  }
  return found;
}

std::optional<Settled> Tracker::below(SnapKind kind, const Curvature& from, const Curvature& along, double load,
                                      std::string& reason) {
  std::optional<Settled> best;
  for (const auto& [push, extra] : pushes) {
    double lowest = infinity;
    for (const double sign : {1.0, -1.0}) {
      // A fold is left the way it was entered; elsewhere both sides are tried.
      if (kind == SnapKind::fold && sign < 0.0) continue;
      double energy = infinity;
      std::optional<Settled> found = fall(moved(from, sign * push, along), load, extra, energy);
      if (!found) {
        reason = trouble_;
        continue;
      }
      // Back on the state that was left.
      if (kind == SnapKind::fold && found->statics->margin(found->z) < 1e-4) continue;
      const double higher = 1e-9 * (1.0 + std::abs(energy));
      if (best && energy > lowest - higher) {
        const double tip = best->statics->at(best->z).backbone().tip_angle();
        const bool tie = energy < lowest + higher;
        if (!tie || found->statics->at(found->z).backbone().tip_angle() <= tip) continue;
      }
      lowest = energy;
      best = std::move(found);
    }
    if (best || must_stop_()) break;
  }
  return best;
}

bool Tracker::snap(SnapKind kind, const Eigen::VectorXd& critical, const Eigen::VectorXd* direction, double load) {
  Statics& here = *now_.statics;
  const State before = here.state(critical);
  const bool rubs = std::any_of(before.contacts.begin(), before.contacts.end(),
                                [](const PointContact& c) { return c.setup.sticks || c.setup.lean != 0.0; });
  if (path_.has_friction() || rubs) {
    // Slipping contacts have no energy that a fall could follow.
    trouble_ = "the rod gives way at load fraction " + shown(critical[here.size()], 9);
    return false;
  }
  const Curvature along =
      here.curvature(critical, direction != nullptr ? *direction : here.weakest_direction(critical));
  std::string reason;
  std::optional<Settled> best = below(kind, here.curvature(critical, critical), along, load, reason);
  TrackedSnap jump;
  jump.kind = kind;
  jump.load = critical[here.size()];
  // Systems are rebuilt for the record: the originals go on.
  jump.before = {make(before), {}};
  jump.before.z = jump.before.statics->point(before);
  if (!best) {
    trouble_ = "the rod snaps at load fraction " + shown(jump.load, 9) + ", and the state after that was not found" +
               (reason.empty() ? "" : ": " + reason);
    jump.after = {make(before), jump.before.z};
    jump.margin = 0.0;
    snaps_.push_back(std::move(jump));
    return false;
  }
  now_ = std::move(*best);
  rebuild();
  resolve(coarse_balance);
  const State after = now_.statics->state(now_.z);
  jump.after = {make(after), {}};
  jump.after.z = jump.after.statics->point(after);
  jump.margin = now_.statics->margin(now_.z);
  snaps_.push_back(std::move(jump));
  length_ = 0.02;
  trouble_.clear();
  spread_ = false;
  return true;
}

}  // namespace tendril
