#include <algorithm>
#include <optional>

#include "contact_search.hpp"
#include "earlier_plan.hpp"
#include "planner.hpp"
#include "problem_data.hpp"
#include "tendril/error.hpp"
#include "tendril/execute.hpp"

namespace tendril {
namespace {

/// Numbers that steer the search. They decide how a plan is found, never whether it is accepted.
constexpr int most_settlings = 3;         ///< executions of unstable plans, for a stable shape to start from
constexpr double settling_time = 0.4;     ///< of what is left, for one of these
constexpr double sampling_time = 0.1;     ///< the same for one of the executions that look for stable shapes
constexpr double unlimited_moment = 6.3;  ///< (EI/L) stands for no limit: it bends the rod to a circle
constexpr double towards_limit = 0.25;    ///< of a limit

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
      moments.push_back(std::clamp(0.0, actuator.minimum, actuator.maximum) * d_.scale.moment());
      continue;
    }
    const int variable = point->program->moment_variable(static_cast<int>(a));
    moments.push_back(variable < 0 ? 0.0 : point->x[variable] * d_.scale.moment());
  }
  return moments;
}

std::vector<std::vector<double>> Planner::sampled_moments() const {
  const std::vector<double> least = moments_of(nullptr);
  std::vector<std::vector<double>> samples{least};
  for (std::size_t a = 0; a < d_.rod.actuators.size(); ++a) {
    const Rod::Actuator& actuator = d_.rod.actuators[a];
    for (const double limit :
         {std::max(actuator.minimum, -unlimited_moment), std::min(actuator.maximum, unlimited_moment)}) {
      for (const double share : {towards_limit, 1.0}) {
        std::vector<double> moments = least;
        moments[a] = std::clamp(share * limit, actuator.minimum, actuator.maximum) * d_.scale.moment();
        if (moments != least) samples.push_back(std::move(moments));
      }
    }
  }
  return samples;
}

bool Planner::come_to_rest(const std::vector<double>& moments, double share, Plan& rest) const {
  ExecuteControl control;
  control.stop = control_.stop;
  control.time_limit = std::max(1e-3, share * (steps_.deadline() - now()));
  control.with_obstacles = !d_.obstacles.empty();
  // A start through the middle of an obstacle leads nowhere: the rod is bent out of the way.
  Scene scene = d_.scene;
  for (const double bent : {0.0, 1.0, -1.0, 2.0, -2.0}) {
    scene.start_tip_angle = d_.scene.start_tip_angle + bent;
    try {
      rest = execute(scene, d_.components.obstacles, moments, control).result;
      break;
    } catch (const SceneError&) {
      rest = {};
    }
  }
  return !rest.backbone.empty();
}

void Planner::settle(const std::vector<std::size_t>& order) {
  if (d_.palm) return;  // a palm moves with the finger's loads; what a finger does with its palm held says nothing here
  std::vector<Plan> rests;
  const std::size_t modes = modes_.size();
  for (int attempt = 0; attempt < most_settlings && winner_ < 0 && !must_stop(); ++attempt) {
    const Candidate* unstable = best_unstable();
    const bool nothing =
        std::none_of(states_.begin(), states_.end(), [](const ModeState& s) { return s.best.has_point; });
    // Where no search came to any point at all, what the rod does under the least moments shows one.
    if (unstable == nullptr && !(nothing && attempt == 0)) break;
    const std::vector<double> moments = moments_of(unstable);
    const bool known =
        std::any_of(rests.begin(), rests.end(), [&](const Plan& rest) { return rest.moments == moments; });
    if (known) break;
    Plan rest;
    if (!come_to_rest(moments, settling_time, rest)) break;
    for (std::size_t i = 0; i < modes; ++i) consider(states_[i], shape_of(d_, rest, modes_[i]));
    rests.push_back(std::move(rest));
  }
  if (winner_ < 0 && !must_stop()) hold_stable(rests, order);
}

void Planner::hold_stable(const std::vector<Plan>& rests, const std::vector<std::size_t>& order) {
  if (best_unstable() == nullptr) return;
  struct Held {
    Problem::Data& data;
    explicit Held(Problem::Data& of) : data(of) { data.least_margin = tolerance::held_margin; }
    ~Held() { data.least_margin.reset(); }
    Held(const Held&) = delete;
    Held& operator=(const Held&) = delete;
  };
  const Held held(d_);
  for (const Plan& rest : rests) {
    for (const std::size_t i : order) consider(states_[i], shape_of(d_, rest, modes_[i]));
  }
  bool first = true;
  for (const std::vector<double>& moments : sampled_moments()) {
    Plan rest;
    if (must_stop() || !come_to_rest(moments, sampling_time, rest)) continue;
    // Every mode is worth the shape of the rod without moments; the others start those whose contacts they have.
    const std::optional<std::vector<ContactSetup>> own = contacts_of(d_, rest);
    for (const std::size_t i : order) {
      if (first || (own && same_contacts(modes_[i].contacts, *own)))
        consider(states_[i], shape_of(d_, rest, modes_[i]));
    }
    first = false;
  }
}

}  // namespace tendril
