#include "search/friction_states.hpp"

#include <algorithm>

namespace tendril {
namespace {

/// Share of a way within the cones that a straight one may bend by.
constexpr double straight = 0.05;
/// Bends that are not seen: states are found to less.
constexpr double settled = 1e-9;

/// Whether states at opposite corners lie so on both sides of the one without friction that those between are told.
bool lie_straight(const SeenState& one, const SeenState& without, const SeenState& other) {
  if (one.point.size() == 0 || one.point.size() != without.point.size() || other.point.size() != one.point.size())
    return false;
  const double way = (one.point - other.point).cwiseAbs().maxCoeff() / 2.0;
  const double bend = ((one.point + other.point) / 2.0 - without.point).cwiseAbs().maxCoeff();
  return bend <= straight * way + settled;
}

/// What an interval is told of.
std::vector<double> numbers_of(const SeenState& seen) {
  const FrictionRange& state = seen.range;
  std::vector<double> numbers{state.tip_x, state.tip_y, state.tip_angle, state.stability,
                              state.target_error.value_or(0.0)};
  for (const PlannedContact& c : state.contacts) numbers.push_back(c.force);
  return numbers;
}

/// Corners to which the effects of single contacts point. `singles`: of each contact the states at its limit below and
/// above.
std::vector<Eigen::VectorXd> pointed_corners(const Eigen::VectorXd& limits, const std::vector<SeenState>& singles) {
  std::vector<std::vector<double>> effects;
  std::size_t count = numbers_of(singles.front()).size();
  for (std::size_t i = 0; i < singles.size(); i += 2) {
    const std::vector<double> below = numbers_of(singles[i]);
    std::vector<double>& effect = effects.emplace_back(numbers_of(singles[i + 1]));
    // Where a contact was lost or made, forces are not those of the same contacts.
    count = std::min({count, below.size(), effect.size()});
    for (std::size_t n = 0; n < std::min(below.size(), effect.size()); ++n) effect[n] -= below[n];
  }
  std::vector<Eigen::VectorXd> found;
  for (std::size_t n = 0; n < count; ++n) {
    Eigen::VectorXd corner = limits;
    for (Eigen::Index i = 0; i < limits.size(); ++i) {
      if (effects[static_cast<std::size_t>(i)][n] < 0.0) corner[i] = -corner[i];
    }
    for (const Eigen::VectorXd& each : {Eigen::VectorXd(-corner), corner}) {
      if (std::find(found.begin(), found.end(), each) == found.end()) found.push_back(each);
    }
  }
  return found;
}

}  // namespace

std::vector<Eigen::VectorXd> corners(const Eigen::VectorXd& limits) {
  std::vector<Eigen::VectorXd> all;
  for (int corner = 0; corner < 1 << limits.size(); ++corner) {
    Eigen::VectorXd ratios = limits;
    for (Eigen::Index k = 0; k < limits.size(); ++k) ratios[k] *= (corner >> k & 1) != 0 ? 1.0 : -1.0;
    all.push_back(std::move(ratios));
  }
  return all;
}

FrictionStates follow_states(const Eigen::VectorXd& limits, const StateAt& state, bool halves) {
  FrictionStates out;
  // With each corner the opposite one is asked for.
  const auto add_all = [&](const std::vector<Eigen::VectorXd>& asked) {
    const std::size_t first = out.states.size();
    for (const Eigen::VectorXd& ratios : asked) {
      std::optional<SeenState> found = state(ratios);
      if (!found) out.lost = ratios;
      if (!found) return false;
      out.states.push_back(std::move(*found));
    }
    for (std::size_t i = 0; halves && i < asked.size(); ++i) {
      const auto opposite = static_cast<std::size_t>(std::find(asked.begin(), asked.end(), -asked[i]) - asked.begin());
      if (lie_straight(out.states[first + i], out.states.front(), out.states[first + opposite])) continue;
      if (state(0.5 * asked[i])) continue;
      out.lost = asked[i];
      return false;
    }
    return true;
  };
  std::optional<SeenState> without = state(Eigen::VectorXd::Zero(limits.size()));
  if (!without) out.lost = Eigen::VectorXd::Zero(limits.size());
  if (!without) return out;
  out.states.push_back(std::move(*without));
  if (limits.size() <= most_rubbing) {
    add_all(corners(limits));
    return out;
  }
  std::vector<Eigen::VectorXd> alone;
  for (Eigen::Index i = 0; i < limits.size(); ++i) {
    for (const double side : {-1.0, 1.0}) alone.push_back(side * limits[i] * Eigen::VectorXd::Unit(limits.size(), i));
  }
  if (!add_all(alone)) return out;
  const std::vector<Eigen::VectorXd> pointed =
      pointed_corners(limits, {out.states.begin() + 1, out.states.begin() + 1 + 2 * limits.size()});
  add_all(pointed);
  out.note = "friction at " + std::to_string(limits.size()) +
             " contacts: each was followed to both edges of its cone, and " + std::to_string(pointed.size()) +
             " corners of all, at which a number is extreme if their effects add up; " +
             "others of the corners may lie farther";
  return out;
}

}  // namespace tendril
