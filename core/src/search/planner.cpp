#include "search/planner.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "scene/plan_report.hpp"
#include "search/contacts.hpp"
#include "search/earlier_plan.hpp"
#include "search/follower.hpp"
#include "search/free_reach.hpp"
#include "search/limit.hpp"
#include "search/parameters.hpp"
#include "search/sides.hpp"
#include "search/task.hpp"

namespace tendril {
void Planner::consider(ModeState& state, const StartShape& shape) {
  if (rest_is_due(modes_[static_cast<std::size_t>(state.mode)])) start_from_rests();
  consider(state, [&] { try_start(state, shape); });
}

void Planner::consider(ModeState& state, const std::function<void()>& trial) {
  if (state.left_out || !modes_[static_cast<std::size_t>(state.mode)].skip.empty() || must_stop()) return;
  if (cannot_win(state)) return;
  const int before = state.stationary_violations;
  const double begin = now();
  trial();
  state.record.seconds += now() - begin;
  // One start is one piece of evidence, however many programs it led to.
  state.stationary_violations = std::min(state.stationary_violations, before + 1);
  if (d_.least_margin && state.stationary_violations > before) {
    state.stationary_violations = before;
    ++state.stationary_with_margins;
  }
  // A grown mode whose new contact does not press is the smaller one with one more knot: no better a plan.
  const bool grown = static_cast<std::size_t>(state.mode) >= d_.modes.size();
  const bool repeats = grown && winner_ >= 0 && state.best.has_point && !all_press(state);
  if (state.best.certified() && !repeats && state.best.objective < best_objective() - search_parameters().beats)
    winner_ = state.mode;
  have_plan_ = winner_ >= 0;
}

bool Planner::cannot_win(ModeState& state) {
  if (winner_ < 0) return false;
  const auto beaten = [&](double distance) {
    return best_objective() <= d_.least_cost(distance) + search_parameters().beats;
  };
  double distance = 0.0;
  if (!beaten(distance)) {
    distance = least_distance(static_cast<std::size_t>(state.mode), beaten);
    if (!beaten(distance)) return false;
  }
  if (state.starts_used == 0) {
    state.record.outcome =
        "skipped: cannot win: it costs at least " + shown(d_.least_cost(distance) * d_.objective_scale);
  }
  return true;
}

double Planner::least_distance(std::size_t mode, const std::function<bool(double)>& enough) {
  if (!search_parameters().bound) return 0.0;
  const EvaluationCounts before = d_.reach ? d_.reach->program().counts() : EvaluationCounts{};
  const double least = d_.least_distance(modes_[mode], enough);
  if (d_.reach) steps_.tally.add_outside(d_.reach->program(), before);
  return least;
}

std::size_t Planner::state_of(const std::vector<ContactSetup>& contacts) {
  for (std::size_t i = 0; i < modes_.size(); ++i) {
    if (same_contacts(modes_[i].contacts, contacts)) return i;
  }
  modes_.push_back(d_.mode(contacts));
  states_.emplace_back();
  name_state(modes_.size() - 1);
  return modes_.size() - 1;
}

void Planner::name_state(std::size_t i) {
  ModeState& state = states_[i];
  state.mode = static_cast<int>(i);
  state.record.mode = modes_[i].name;
  state.skip = modes_[i].skip;
  state.left_out =
      std::find(control_.without.begin(), control_.without.end(), modes_[i].name) != control_.without.end();
  if (state.left_out) state.record.outcome = left_out_outcome;
}

std::vector<std::size_t> Planner::parents(int contacts) const {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < states_.size(); ++i) {
    const ModeState& state = states_[i];
    if (static_cast<int>(modes_[i].contacts.size()) != contacts) continue;
    if (!state.best.has_point && !std::isfinite(state.violation)) continue;
    // With a contact that does not press the mode is the smaller one without it, which was grown already.
    if (state.best.has_point && !all_press(state)) continue;
    found.push_back(i);
  }
  const auto rank = [&](std::size_t i) {
    const Candidate& best = states_[i].best;
    const double value = best.has_point ? best.objective : states_[i].violation;
    return std::tuple(best.certified() ? 0 : best.has_point ? 1 : 2, value);
  };
  std::stable_sort(found.begin(), found.end(), [&](std::size_t a, std::size_t b) { return rank(a) < rank(b); });
  if (found.size() > search_parameters().beam_width) found.resize(search_parameters().beam_width);
  return found;
}

void Planner::grow() {
  for (int size = 1; size < d_.scene.contact.count && !must_stop(); ++size) {
    for (const std::size_t parent : parents(size)) {
      const ModeState& from = states_[parent];
      const StartShape shape = from.best.has_point ? from.best.program->shape_of(from.best.x) : from.nearest;
      std::size_t added = 0;
      for (const Extension& extension : extensions(d_, modes_[parent].contacts, shape)) {
        if (added == search_parameters().most_extensions || must_stop()) break;
        if (!d_.mode(extension.contacts).skip.empty()) continue;
        ++added;
        const std::size_t known = states_.size();
        const std::size_t i = state_of(extension.contacts);
        // Another parent led here before; it is tried again only while there is no plan at all.
        if (i < known && (have_plan_ || states_[i].best.certified())) continue;
        consider(states_[i], extension.start);
      }
    }
  }
}

int Planner::follow() {
  const std::optional<FollowedPoint> from = followed_point(d_, *control_.start);
  if (!from) return -1;
  ModeState& state = states_[state_of(from->mode.contacts)];
  if (state.left_out || !modes_[static_cast<std::size_t>(state.mode)].skip.empty()) return -1;
  std::vector<CheckPoint> checks = from->checks;
  following_ = true;
  complete(state, from->regions, checks, from->x, std::vector<Branch>(from->mode.contacts.size(), Branch::touching));
  following_ = false;
  if (state.best.certified() && contacts_unchanged(d_, *state.best.program, state.best.x)) {
    state.record.outcome = followed_outcome;
    return state.mode;
  }
  state.best = {};
  return -1;
}

bool Planner::chooses() const {
  return !d_.rod.moves.empty() || std::any_of(d_.rod.actuators.begin(), d_.rod.actuators.end(),
                                              [](const Rod::Actuator& a) { return a.minimum < a.maximum; });
}

Plan Planner::run() {
  states_.resize(modes_.size());
  for (std::size_t i = 0; i < states_.size(); ++i) name_state(i);
  std::vector<std::size_t> order;
  if (control_.start != nullptr) {
    // With an earlier plan the mode that won there comes first.
    const auto won = contacts_of(d_, *control_.start);
    if (won && (won->empty() ? d_.min_force == 0.0 : d_.contact_planned())) order.push_back(state_of(*won));
  }
  const std::size_t modes = modes_.size();
  const std::size_t won_before = order.empty() ? modes : order.front();
  for (std::size_t i = 0; i < modes; ++i) {
    if (order.empty() || order.front() != i) order.push_back(i);
  }
  std::erase_if(order, [this](std::size_t i) { return states_[i].left_out; });
  if (control_.follow && control_.start != nullptr) winner_ = follow();
  if (winner_ >= 0) return report();
  // Ways whose tip has to stay away from the target may be none to solve once others have a plan.
  if (d_.enumerated) {
    const auto off = [](double distance) { return distance > 0.0; };
    std::stable_partition(order.begin(), order.end(),
                          [&](std::size_t i) { return i == won_before || !off(least_distance(i, off)); });
  }
  if (search_parameters().balance_first && d_.palm && !d_.palm->balance) start_from_balance(order);
  search(order);
  if (fast()) return report();
  if (search_parameters().ask_rests && !rested_ && misses_among_sides()) start_from_rests();
  if (winner_ >= 0 || d_.palm) hold_cheaper();
  search_further(starts(), order);
  search_bent(order);
  start_from_relaxed_arcs();
  scan();
  if (search_parameters().settle) settle(order);
  if (search_parameters().prove) look_for_stable(order);
  // Where moments can be chosen and every search ended stationary, there is no plan; where none can, what the rod does
  // is worth telling.
  if (search_parameters().tell_spread && winner_ < 0 && !(chooses() && all_infeasible())) look_for_spread();
  return report();
}

void Planner::search(const std::vector<std::size_t>& order) {
  const int earlier = control_.start != nullptr ? 1 : 0;
  // Where assignments are too many to be listed, those that grow come first.
  if (d_.enumerated) search_all_sides(order);
  for (int round = 0; round < starts() && !must_stop(); ++round) {
    // One start per mode finds most plans; only if no mode is certified are more starts spent. A grasp comes in
    // families with several valleys of the effort; what follows its own starts is no equilibrium.
    // No free moment: equilibria are isolated, and every start is tried.
    if (winner_ >= 0 && !thorough() &&
        (balanced_by_row() ? round >= earlier + d_.grip->starts() : round > 0 && !d_.palm && chooses()))
      break;
    round_ = round;
    // Before the second start per mode the rod itself shows where it can be.
    if (search_parameters().ask_rests && round > 0 && !d_.palm && !rested_ && (winner_ < 0 || thorough())) {
      start_from_rests();
      if (winner_ >= 0 && chooses() && !thorough()) break;
    }
    deferring_ = balanced_by_row();
    for (const std::size_t i : order) {
      states_[i].deferred = false;
      const StartShape shape = start_shape(round, modes_[i]);
      if (!looked_at(states_[i])) consider(states_[i], shape);
    }
    deferring_ = false;
    for (const std::size_t i : order) {
      if (states_[i].deferred && winner_ < 0) consider(states_[i], start_shape(round, modes_[i]));
    }
    if (!d_.enumerated && search_parameters().grow_contacts) grow();
  }
  if (!d_.enumerated) search_all_sides(order);
}

void Planner::search_all_sides(const std::vector<std::size_t>& order) {
  // With more contacts allowed nothing is lost that fewer would find: these come first, each with their own work.
  std::size_t most = 1;
  for (const std::size_t i : order) most = std::max(most, modes_[i].contacts.size());
  for (std::size_t contacts = 1; contacts <= most; ++contacts) {
    std::vector<std::size_t> ways;
    for (const std::size_t i : order) {
      if (std::max<std::size_t>(1, modes_[i].contacts.size()) == contacts) ways.push_back(i);
    }
    search_sides(ways);
  }
}

void Planner::search_bent(const std::vector<std::size_t>& order) {
  if (!search_parameters().bent_at_contacts || d_.palm || !d_.contact_planned() || must_stop() || !is_off_target())
    return;
  const Kept<bool> bent{bent_};
  bent_ = true;
  search_all_sides(order);
}

void Planner::search_sides(const std::vector<std::size_t>& order) {
  if (d_.palm || !search_parameters().sides) return;
  // A fast search is the beginning of a normal one: the scene's own start alone.
  const std::size_t most_sides = fast() ? 0 : search_parameters().most_sides * static_cast<std::size_t>(generosity());
  if (!several_sides(d_)) return;
  std::vector<SideStart> starts;
  if (most_sides > 0) starts = starts_by_sides(d_, bent_);
  SideStart own = start_by_sides(d_, d_.scene_start());
  own.number = 0;
  struct Trial {
    double merit;
    std::size_t way;
    const SideStart* start;
  };
  // The scene's own start comes before all others; where there are many ways, not with all of them.
  const std::size_t most_trials = search_parameters().most_trials * static_cast<std::size_t>(generosity());
  std::vector<Trial> trials;
  std::vector<Trial> last;
  std::size_t first_ways = 0;
  for (const std::size_t i : order) {
    if (!modes_[i].skip.empty()) continue;
    std::vector<Trial> of_way;
    for (const SideStart& start : starts) {
      double merit = start.merit;
      for (const ContactSetup& c : modes_[i].contacts) {
        merit += search_parameters().cost_of_distance * std::abs(start.distances[static_cast<std::size_t>(c.obstacle)]);
      }
      of_way.push_back({merit, i, &start});
    }
    std::stable_sort(of_way.begin(), of_way.end(), [](const Trial& a, const Trial& b) { return a.merit < b.merit; });
    if (of_way.size() > most_sides) of_way.resize(most_sides);
    if (!bent_) (first_ways < most_trials ? trials : last).push_back({0.0, i, &own});
    ++first_ways;
    trials.insert(trials.end(), of_way.begin(), of_way.end());
  }
  std::stable_sort(trials.begin(), trials.end(), [](const Trial& a, const Trial& b) { return a.merit < b.merit; });
  const std::size_t most = std::max(most_trials, std::min(first_ways, most_trials) + most_trials / 2);
  if (trials.size() > most) trials.resize(most);
  trials.insert(trials.end(), last.begin(), last.end());
  const double most_work = steps_.tally.work + generosity() * search_parameters().side_work;
  for (const Trial& trial : trials) {
    ModeState& state = states_[trial.way];
    if (must_stop() || steps_.tally.work > most_work) return;
    if (!thorough() && state.best.has_point) {
      // A plan from another side may lie on this one, as near to what is asked for as a start can be.
      const SideStart found = start_by_sides(d_, state.best.program->shape_of(state.best.x));
      const bool same = found.sides == trial.start->sides && found.patches == trial.start->patches;
      if (same && found.merit <= trial.start->merit) continue;
    }
    state.sided = true;
    // Not split, a contact may have to go on into the next piece.
    const bool hops = !d_.scene.coordinates.split_at_contact && !modes_[trial.way].contacts.empty();
    consider(state, [&] {
      if (hops) try_start(state, trial.start->shape);
      // A backend that was left to itself may have passed through an obstacle to the other side.
      const bool stayed = hops && state.best.has_point &&
                          start_by_sides(d_, state.best.program->shape_of(state.best.x)).sides == trial.start->sides;
      if (!stayed || bent_) refine(state, *beginning_at(modes_[trial.way], *trial.start));
    });
  }
}

bool Planner::looked_at(const ModeState& state) const { return have_plan_ && state.sided && !thorough(); }

void Planner::hold_cheaper() {
  if (!search_parameters().hold_cheaper) return;
  std::vector<std::pair<double, std::size_t>> cheaper;
  for (std::size_t i = 0; i < states_.size(); ++i) {
    if (states_[i].unstable_objective < best_objective() - search_parameters().beats) {
      cheaper.emplace_back(states_[i].unstable_objective, i);
    }
  }
  std::sort(cheaper.begin(), cheaper.end());
  const HeldStable held(d_);
  for (const auto& found : cheaper) {
    if (must_stop() || !(found.first < best_objective() - search_parameters().beats)) continue;
    ModeState& state = states_[found.second];
    consider(state, [&] { refine(state, state.unstable); });
  }
}

void Planner::start_from_balance(const std::vector<std::size_t>& order) {
  {
    struct WithBalance {
      PalmSetup& palm;
      explicit WithBalance(PalmSetup& of) : palm(of) { palm.balance = true; }
      ~WithBalance() { palm.balance = false; }
      WithBalance(const WithBalance&) = delete;
      WithBalance& operator=(const WithBalance&) = delete;
    } with(*d_.palm);
    search(order);
  }
  if (winner_ < 0) return;
  const Candidate& balanced = states_[static_cast<std::size_t>(winner_)].best;
  const StartShape shape = balanced.program->shape_of(balanced.x);
  const int mode = winner_;
  balanced_objective_ = balanced.objective;
  // What was found with the row is a start for what follows and nothing else.
  for (ModeState& state : states_) {
    state.best = {};
    state.starts_used = state.stationary_violations = 0;
    state.violation = infinity;
    state.trouble.clear();
    state.limits.clear();
  }
  winner_ = -1;
  have_plan_ = false;
  minima_.clear();
  consider(states_[static_cast<std::size_t>(mode)], shape);
}

bool Planner::all_infeasible() const {
  return std::all_of(states_.begin(), states_.end(), [](const ModeState& state) { return state.infeasible(); });
}

void Planner::search_further(int starts, const std::vector<std::size_t>& order) {
  if (d_.palm) return;
  for (int round = starts; round < starts + search_parameters().further_starts && winner_ < 0 && !all_infeasible();
       ++round) {
    for (const std::size_t i : order) consider(states_[i], start_shape(round, modes_[i]));
    if (!d_.enumerated && search_parameters().grow_contacts) grow();
  }
  if (d_.enumerated || winner_ >= 0) return;
  std::vector<ContactSetup> slots =
      contact_slots(static_cast<int>(d_.rod.fixed_knots().size()) - 1, d_.contact_obstacles);
  // A contact out of reach stays out of reach beside others.
  slots.erase(std::remove_if(slots.begin(), slots.end(),
                             [this](const ContactSetup& slot) { return !d_.mode({slot}).skip.empty(); }),
              slots.end());
  const auto every = every_assignment(d_, slots, d_.scene.contact.count, search_parameters().most_enumerated_at_last);
  if (!every) return;
  for (int round = 0; round < search_parameters().most_starts && winner_ < 0 && !must_stop(); ++round) {
    for (const std::vector<ContactSetup>& contacts : *every) {
      ModeState& state = states_[state_of(contacts)];
      if (state.starts_used <= round) consider(state, start_shape(round, modes_[static_cast<std::size_t>(state.mode)]));
    }
  }
  every_assignment_tried_ = !must_stop();
}

}  // namespace tendril
