#include <algorithm>
#include <cmath>
#include <optional>

#include "search/contacts.hpp"
#include "search/parameters.hpp"
#include "search/planner.hpp"
#include "search/task.hpp"

namespace tendril {
namespace {

/// Numbers that steer the search. They decide how a plan is found, never whether it is accepted.
constexpr double towards_limit[] = {0.25, 1.0, 0.5, 0.1};  ///< of a limit, in the order in which they are tried

}  // namespace

const Candidate* Planner::best_unstable() const {
  const Candidate* unstable = nullptr;
  for (const ModeState& state : states_) {
    const bool usable = state.best.has_point && !(state.best.certificate.stability > tolerance::stability);
    if (usable && (unstable == nullptr || state.best.objective < unstable->objective)) unstable = &state.best;
  }
  return unstable;
}

std::vector<double> Planner::moments_of(const Candidate* point) const {
  std::vector<double> moments;
  for (std::size_t a = 0; a < d_.rod.actuators.size(); ++a) {
    if (point == nullptr) {
      const Rod::Actuator& actuator = d_.rod.actuators[a];
      moments.push_back(std::clamp(0.0, actuator.minimum, actuator.maximum));
      continue;
    }
    const int variable = point->program->moment_variable(static_cast<int>(a));
    moments.push_back(variable < 0 ? 0.0 : point->x[variable]);
  }
  return moments;
}

std::vector<std::vector<double>> Planner::sampled_moments() const {
  const std::vector<double> least = moments_of(nullptr);
  std::vector<std::vector<double>> samples{least};
  const auto add = [&samples](std::vector<double> moments) {
    const bool known = std::find(samples.begin(), samples.end(), moments) != samples.end();
    if (!known && samples.size() < search_parameters().most_samples) samples.push_back(std::move(moments));
  };
  // What the loads do with a lever of the rod's length, moments may have to hold.
  const double largest = search_parameters().unlimited_moment + (d_.palm ? 0.0 : load_size());
  const auto value = [&](std::size_t a, double share) {
    const Rod::Actuator& actuator = d_.rod.actuators[a];
    const double limit = share < 0.0 ? std::max(actuator.minimum, -largest) : std::min(actuator.maximum, largest);
    return std::clamp(std::abs(share) * limit, actuator.minimum, actuator.maximum);
  };
  const std::size_t actuators = d_.rod.actuators.size();
  const auto alone = [&](std::size_t from, std::size_t to) {
    for (std::size_t i = from; i < to; ++i) {
      for (std::size_t a = 0; a < actuators; ++a) {
        for (const double sign : {-1.0, 1.0}) {
          std::vector<double> moments = least;
          moments[a] = value(a, sign * towards_limit[i]);
          add(std::move(moments));
        }
      }
    }
  };
  alone(0, search_parameters().sampled_alone);
  for (std::size_t a = 0; a < actuators; ++a) {
    for (std::size_t b = a + 1; b < actuators; ++b) {
      for (const double share : {towards_limit[0], towards_limit[1]}) {
        for (const double sign : {-1.0, 1.0}) {
          for (const double other : {-1.0, 1.0}) {
            std::vector<double> moments = least;
            moments[a] = value(a, sign * share);
            moments[b] = value(b, other * share);
            add(std::move(moments));
          }
        }
      }
    }
  }
  alone(search_parameters().sampled_alone, std::size(towards_limit));
  return samples;
}

void Planner::settle(const std::vector<std::size_t>& order) {
  if (d_.palm) return;  // a palm moves with the finger's loads; what a finger does with its palm held says nothing here
  std::vector<Rest> rests;
  const std::size_t modes = modes_.size();
  if (winner_ < 0 && !rested_ && !must_stop()) start_from_rests();
  // A coarse model rests elsewhere than the rod, unless it has a knot where the rod touches.
  const std::vector<double> least = moments_of(nullptr);
  const auto execution = [this](const std::vector<double>& moments) {
    return executed(moments, search_parameters().looks_at_unstable);
  };
  std::optional<Rest> of_least;
  if (winner_ < 0 && !must_stop()) of_least = execution(least);
  if (of_least) consider_rest(*of_least);
  for (int attempt = 0; attempt < search_parameters().most_settlings && winner_ < 0 && !must_stop(); ++attempt) {
    const Candidate* unstable = best_unstable();
    const bool nothing =
        std::none_of(states_.begin(), states_.end(), [](const ModeState& s) { return s.best.has_point; });
    // Where no search came to any point at all, what the rod does under the least moments shows one.
    if (unstable == nullptr && !(nothing && attempt == 0)) break;
    const std::vector<double> moments = moments_of(unstable);
    const bool known =
        std::any_of(rests.begin(), rests.end(), [&](const Rest& rest) { return rest.moments == moments; });
    if (known) break;
    const std::optional<Rest> rest = moments == least ? of_least : execution(moments);
    if (!rest) break;
    if (moments != least) consider_rest(*rest);
    for (std::size_t i = 0; i < modes; ++i) consider(states_[i], shape_of(*rest, modes_[i]));
    rests.push_back(*rest);
  }
  if (winner_ < 0 && !must_stop()) hold_stable(rests, order);
}

void Planner::hold_stable(const std::vector<Rest>& rests, const std::vector<std::size_t>& order) {
  if (!search_parameters().hold || best_unstable() == nullptr) return;
  const HeldStable held(d_);
  for (const Rest& rest : rests) {
    for (const std::size_t i : order) consider(states_[i], shape_of(rest, modes_[i]));
  }
  bool first = true;
  for (const std::vector<double>& moments : sampled_moments()) {
    if (must_stop()) return;
    const std::optional<Rest> rest = come_to_rest(moments, d_.scene_start());
    if (!rest) continue;
    consider_rest(*rest);
    // Every mode is worth the shape of the rod without moments; the others start those whose contacts they have.
    const std::optional<std::vector<ContactSetup>> own = contacts_of_rest(*rest);
    for (const std::size_t i : order) {
      if (first || (own && same_contacts(modes_[i].contacts, *own))) consider(states_[i], shape_of(*rest, modes_[i]));
    }
    first = false;
  }
}

void Planner::look_for_stable(const std::vector<std::size_t>& order) {
  if (d_.palm || winner_ >= 0) return;
  // Those that the search added, too.
  std::vector<std::size_t> all = order;
  for (std::size_t i = 0; i < states_.size(); ++i) {
    if (states_[i].starts_used > 0 && std::find(order.begin(), order.end(), i) == order.end()) all.push_back(i);
  }
  const auto unfinished = [this](std::size_t i) { return !states_[i].infeasible(); };
  if (std::none_of(all.begin(), all.end(), unfinished)) return;
  const HeldStable held(d_);
  proving_ = true;
  for (int start = -1;
       start < search_parameters().most_starts + search_parameters().further_starts && winner_ < 0 && !must_stop();
       ++start) {
    for (const std::size_t i : all) {
      if (winner_ >= 0 || must_stop() || !unfinished(i)) continue;
      const Candidate& best = states_[i].best;
      if (start < 0 && !best.has_point) continue;
      consider(states_[i], start < 0 ? best.program->shape_of(best.x) : start_shape(start, modes_[i]));
    }
  }
  proving_ = false;
}

}  // namespace tendril
