#include <algorithm>
#include <cmath>

#include "program/equations.hpp"
#include "search/parameters.hpp"
#include "search/planner.hpp"
#include "search/scan.hpp"
#include "search/sides.hpp"
#include "search/task.hpp"
#include "statics/descent.hpp"

namespace tendril {

std::vector<StartShape> Planner::scanned_shapes() const {
  std::vector<StartShape> shapes{d_.scene_start()};
  if (loaded()) shapes.insert(shapes.end(), {hanging(false), hanging(true)});
  for (SideStart& start : starts_by_sides(d_)) {
    if (shapes.size() > static_cast<std::size_t>(search_parameters().scanned_sides)) break;
    shapes.push_back(std::move(start.shape));
  }
  return shapes;
}

Rest Planner::rest_at(const ModeState& state) const {
  const Candidate& best = state.best;
  const StartShape shape = best.program->shape_of(best.x);
  Rest rest{Curvature(shape.curvature, shape.stretch), moments_of(&best), {}, shape.moves};
  const std::vector<ContactSetup>& contacts = modes_[static_cast<std::size_t>(state.mode)].contacts;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    if (shape.forces[k] > tolerance::force)
      rest.contacts.push_back({contacts[k], shape.arc_lengths[k], shape.forces[k]});
  }
  return rest;
}

double Planner::cost_of(const Rest& rest) const {
  const auto contacts = contacts_of_rest(rest);
  if (!contacts) return infinity;
  const auto pressed = [this](const PointContact& c) { return c.force >= d_.min_force && c.force <= d_.max_force; };
  if (!std::all_of(rest.contacts.begin(), rest.contacts.end(), pressed)) return infinity;
  const Mode mode = d_.mode(*contacts);
  if (!mode.skip.empty()) return infinity;
  const StartShape shape = shape_of(rest, mode);
  PoseProgram program(Equations::alone(d_.spec(mode, regions_near(mode, shape), d_.nodes)));
  return program.cost(program.start_from(shape));
}

std::vector<Rest> Planner::rests_of_arcs() {
  std::vector<std::vector<double>> inputs = sampled_moments();
  inputs.resize(std::min(inputs.size(), search_parameters().inputs_of_relaxed));
  const std::vector<double> moves = d_.rod.starts();
  CountedLooks allowance(steps_.tally, steps_.deadline(), search_parameters().looks_at_arcs, d_.coordinate_count({}));
  std::vector<Rest> rests;
  for (const std::vector<double>& moments : inputs) {
    const LoadPath path(d_.rod, d_.obstacles, {moments, moments, false, false, moves, moves});
    for (const Descent& down :
         descend_from_arcs(path, 1.0, search_parameters().widest_of_one, search_parameters().most_relaxed_arcs,
                           [&] { return allowance.spent(); })) {
      if (auto rest = settled(down, moments)) rests.push_back(std::move(*rest));
    }
  }
  return rests;
}

bool Planner::is_off_target() const {
  if (winner_ < 0) return true;
  // In narrow notches a contact holds where it would slide on along a smooth body.
  bool notched = false;
  for (std::size_t o = 0; o < d_.pocketed.size(); ++o) {
    notched = notched || (!d_.pocketed[o] && !d_.obstacles[o]->convex());
  }
  const double there = notched ? search_parameters().off_notched : search_parameters().off_target;
  // As far as the objective tells what that costs.
  if (d_.least_cost(there) > d_.least_cost()) return best_objective() > d_.least_cost(there);
  const Backbone& backbone = backbone_of_best();
  const bool beside = d_.target.has_position && norm(backbone.tip() - d_.target.position) > there;
  const bool turned = d_.target.has_angle && std::abs(backbone.tip_angle() - d_.target.angle) > there;
  return beside || turned || !(d_.target.has_position || d_.target.has_angle);
}

void Planner::start_from_relaxed_arcs() {
  // Where nothing buckles there is one equilibrium, and where the tip is at its target no other can bring much.
  const bool one = d_.obstacles.empty() && !loaded();
  if (!search_parameters().relaxed_arcs || one || d_.palm || must_stop() || !is_off_target()) return;
  const std::vector<Rest> rests = rests_of_arcs();
  std::vector<std::pair<double, std::size_t>> costs;
  for (std::size_t i = 0; i < rests.size(); ++i) costs.emplace_back(cost_of(rests[i]), i);
  std::sort(costs.begin(), costs.end());
  // From each contact and side one start leads to the best moments near, also where these rests cost more than the
  // plan.
  std::vector<std::pair<std::size_t, Sides>> seen;
  const double most_work = steps_.tally.work + generosity() * search_parameters().side_work;
  for (std::size_t k = 0; k < costs.size() && std::isfinite(costs[k].first) && !must_stop(); ++k) {
    if (steps_.tally.work > most_work) return;
    const Rest& rest = rests[costs[k].second];
    const std::size_t way = state_of(*contacts_of_rest(rest));
    const std::pair of{way, sides_of(d_, shape_of(rest, modes_[way]))};
    const bool known = std::find(seen.begin(), seen.end(), of) != seen.end();
    const bool dearer = costs[k].first >= best_objective() + search_parameters().dearer;
    if (dearer && (known || !chooses() || seen.size() >= search_parameters().dearer_relaxed)) continue;
    if (!known) seen.push_back(of);
    consider_rest(rest);
  }
}

void Planner::scan() {
  const auto actuators = scanned_actuators(d_);
  if (!search_parameters().scan || !thorough() || !actuators || actuators->size() > 2 || must_stop()) return;
  const int intervals = actuators->size() == 2 ? search_parameters().plane_scan : search_parameters().fine_scan;
  std::vector<Rest> known;
  for (const ModeState& state : states_) {
    if (state.best.certified()) known.push_back(rest_at(state));
  }
  // Equilibria that lean on an obstacle from elsewhere are no neighbours of those that are reached from beside it.
  for (Rest& rest : rests_of_arcs()) known.push_back(std::move(rest));
  const EquilibriumScan found =
      scan_equilibria(d_, *actuators, intervals, scanned_shapes(), known, [this] { return must_stop(); });
  std::vector<double> costs;
  for (const ScannedRest& rest : found.met) costs.push_back(cost_of(rest.rest));
  std::vector<std::size_t> lowest;
  for (std::size_t i = 0; i < found.met.size(); ++i) {
    const std::vector<std::size_t>& beside = found.met[i].neighbours;
    if (std::all_of(beside.begin(), beside.end(), [&](std::size_t k) { return costs[i] <= costs[k]; }))
      lowest.push_back(i);
  }
  std::stable_sort(lowest.begin(), lowest.end(), [&](std::size_t a, std::size_t b) { return costs[a] < costs[b]; });
  PlanScan told;
  told.equilibria = static_cast<int>(found.met.size());
  told.lost = found.lost;
  told.whole = found.whole;
  for (const double step : found.steps) told.steps.push_back(step * d_.scale.moment());
  for (const std::size_t i : lowest) {
    const auto beaten = [&](double cost) { return best_objective() < cost + search_parameters().dearer; };
    if (beaten(costs[i])) break;
    told.whole = told.whole && !must_stop();
    if (!told.whole) break;
    const double feasible = consider_rest(found.met[i].rest);
    if (!beaten(feasible)) ++told.unresolved;
  }
  scan_ = std::move(told);
}

}  // namespace tendril
