#include "search/scan.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>

#include "search/contacts.hpp"
#include "search/parameters.hpp"
#include "statics/loading.hpp"

namespace tendril {
namespace {

constexpr int compared_points = 9;       ///< along two shapes
constexpr double same_curvature = 1e-3;  ///< 1/L, relative above 1: equilibria that are one, reached on two ways
constexpr double same_place = 1e-3;      ///< L, of a contact of both

class Scanner {
 public:
  Scanner(const Task& task, const std::vector<std::size_t>& actuators, int intervals,
          const std::function<bool()>& must_stop)
      : task_(task), actuators_(actuators), intervals_(intervals), must_stop_(must_stop) {
    for (const std::size_t a : actuators_) {
      const Rod::Actuator& actuator = task_.rod.actuators[a];
      found_.steps.push_back((actuator.maximum - actuator.minimum) / intervals_);
    }
  }

  EquilibriumScan run(const std::vector<StartShape>& shapes, const std::vector<Rest>& rests) {
    for (const Rest& rest : rests) {
      if (const auto reached = led(rest, rest.moments, nearest(rest.moments))) add(*reached, nearest(rest.moments));
    }
    for (const std::vector<int>& node : outstanding_nodes()) {
      for (const StartShape& shape : shapes) relax(shape, node);
    }
    while (!waiting_.empty() && !stopped()) {
      const std::size_t from = waiting_.front();
      waiting_.pop_front();
      for (std::size_t i = 0; i < actuators_.size(); ++i) {
        for (const int by : {-1, 1}) follow(from, i, by);
      }
    }
    return std::move(found_);
  }

 private:
  bool stopped() {
    if (must_stop_()) found_.whole = false;
    return !found_.whole;
  }

  std::vector<double> moments_at(const std::vector<int>& node) const {
    std::vector<double> moments;
    for (const Rod::Actuator& a : task_.rod.actuators) moments.push_back(a.minimum);
    for (std::size_t i = 0; i < actuators_.size(); ++i) moments[actuators_[i]] += node[i] * found_.steps[i];
    return moments;
  }

  std::vector<int> nearest(const std::vector<double>& moments) const {
    std::vector<int> node;
    for (std::size_t i = 0; i < actuators_.size(); ++i) {
      const double from = task_.rod.actuators[actuators_[i]].minimum;
      const auto at = static_cast<int>(std::lround((moments[actuators_[i]] - from) / found_.steps[i]));
      node.push_back(std::clamp(at, 0, intervals_));
    }
    return node;
  }

  /// Corners, and the middle.
  std::vector<std::vector<int>> outstanding_nodes() const {
    std::vector<std::vector<int>> nodes{std::vector<int>(actuators_.size(), intervals_ / 2)};
    if (actuators_.empty()) return nodes;
    for (std::size_t corner = 0; corner < (std::size_t{1} << actuators_.size()); ++corner) {
      std::vector<int> node;
      for (std::size_t i = 0; i < actuators_.size(); ++i) node.push_back((corner >> i & 1U) != 0 ? intervals_ : 0);
      nodes.push_back(std::move(node));
    }
    return nodes;
  }

  std::size_t add(const Rest& rest, const std::vector<int>& node) {
    std::vector<std::size_t>& here = at_[node];
    for (const std::size_t known : here) {
      if (same_rest(found_.met[known].rest, rest)) return known;
    }
    here.push_back(found_.met.size());
    waiting_.push_back(found_.met.size());
    found_.met.push_back({rest, node});
    return here.back();
  }

  /// Where a loading comes to rest; nothing: it lies along an obstacle there, or could not be told.
  std::optional<Rest> end_of(Loading& loading, const std::vector<double>& moments) {
    if (loading.without_side() || !loading.run()) return std::nullopt;
    Settled& end = loading.tracker().current();
    return rest_of(task_, moments, end.statics->state(end.z));
  }

  void relax(const StartShape& shape, const std::vector<int>& node) {
    if (stopped()) return;
    const std::vector<double> moments = moments_at(node);
    Loading loading(task_.rod, task_.obstacles, Curvature(shape.curvature), {moments, {}}, must_stop_);
    if (const auto rest = end_of(loading, moments)) add(*rest, node);
  }

  std::optional<Rest> led(const Rest& rest, const std::vector<double>& from, const std::vector<int>& node) {
    const std::vector<double> to = moments_at(node);
    Loading loading(task_.rod, task_.obstacles, {rest.curvature, rest.contacts}, {from, {}}, {to, {}}, must_stop_);
    std::optional<Rest> end = end_of(loading, to);
    jumped_ = !loading.tracker().snaps().empty();
    return end;
  }

  void follow(std::size_t from, std::size_t i, int by) {
    std::vector<int> node = found_.met[from].node;
    const std::vector<double> moments = moments_at(node);
    node[i] += by;
    if (node[i] < 0 || node[i] > intervals_ || stopped()) return;
    // The way back from an equilibrium that was come to without a jump.
    for (const std::size_t known : found_.met[from].neighbours) {
      if (found_.met[known].node == node) return;
    }
    const Rest start = found_.met[from].rest;
    const auto reached = led(start, moments, node);
    if (!reached) {
      ++found_.lost;
      return;
    }
    const std::size_t to = add(*reached, node);
    if (jumped_) return;
    found_.met[from].neighbours.push_back(to);
    found_.met[to].neighbours.push_back(from);
  }

  const Task& task_;
  const std::vector<std::size_t>& actuators_;
  int intervals_;
  const std::function<bool()>& must_stop_;
  EquilibriumScan found_;
  std::map<std::vector<int>, std::vector<std::size_t>> at_;
  std::deque<std::size_t> waiting_;
  bool jumped_ = false;
};

}  // namespace

bool same_rest(const Rest& a, const Rest& b) {
  if (a.contacts.size() != b.contacts.size()) return false;
  for (std::size_t k = 0; k < a.contacts.size(); ++k) {
    const PointContact& p = a.contacts[k];
    const PointContact& q = b.contacts[k];
    const bool same = p.setup.obstacle == q.setup.obstacle && p.setup.at_tip == q.setup.at_tip;
    if (!same || !(std::abs(p.s - q.s) < same_place)) return false;
  }
  for (int i = 0; i < compared_points; ++i) {
    // Off the knots, where the curvature may jump.
    const double s = (i + 0.37) / compared_points;
    const double kappa = a.curvature(s);
    if (!(std::abs(kappa - b.curvature(s)) < same_curvature * (1.0 + std::abs(kappa)))) return false;
  }
  return true;
}

std::optional<std::vector<std::size_t>> scanned_actuators(const Task& task) {
  // With tangential forces that are planned equilibria are not all there is.
  if (task.palm || !task.rod.moves.empty() || !task.friction.empty()) return std::nullopt;
  std::vector<std::size_t> chosen;
  for (std::size_t a = 0; a < task.rod.actuators.size(); ++a) {
    const Rod::Actuator& actuator = task.rod.actuators[a];
    if (!(actuator.minimum < actuator.maximum)) continue;
    if (!std::isfinite(actuator.minimum) || !std::isfinite(actuator.maximum)) return std::nullopt;
    chosen.push_back(a);
  }
  return chosen;
}

EquilibriumScan scan_equilibria(const Task& task, const std::vector<std::size_t>& actuators, int intervals,
                                const std::vector<StartShape>& shapes, const std::vector<Rest>& rests,
                                const std::function<bool()>& must_stop) {
  return Scanner(task, actuators, intervals, must_stop).run(shapes, rests);
}

}  // namespace tendril
