#include "statics/loading.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "certificate/clearance.hpp"
#include "tendril/tolerances.hpp"

namespace tendril {
namespace {

/// A start nearer to an obstacle's core than this (in L) lies on neither side of it.
constexpr double core_side = 1e-6;
/// Load fraction by which a rod that lies along an obstacle is carried on at a time.
constexpr double longest_load_step = 0.1;

/// Moments that hold a constant curvature against the rod's own stiffness, and what they leave over: one more actuator
/// per stretch whose moment fades as the loads grow.
LoadPath::Ends ends_from_rest(Rod& rod, double curvature, const std::vector<double>& last, bool holds_lengths) {
  const std::vector<double> knots = rod.fixed_knots();
  const auto stretches = static_cast<Eigen::Index>(knots.size()) - 1;
  const auto count = static_cast<Eigen::Index>(last.size());
  Eigen::MatrixXd spans = Eigen::MatrixXd::Zero(stretches, count);
  Eigen::VectorXd wanted(stretches);
  for (Eigen::Index r = 0; r < stretches; ++r) {
    const double middle = 0.5 * (knots[static_cast<std::size_t>(r)] + knots[static_cast<std::size_t>(r) + 1]);
    const Rod::Segment& segment = rod.segment_at(middle);
    wanted[r] =
        segment.holding_moment(knots[static_cast<std::size_t>(r)], knots[static_cast<std::size_t>(r) + 1], curvature);
    for (Eigen::Index a = 0; a < count; ++a) {
      // A profile that varies leaves no constant moment to be held by others: such an actuator starts without one.
      const Rod::Actuator& actuator = rod.actuators[static_cast<std::size_t>(a)];
      const bool follows = holds_lengths && actuator.by_length;
      if (!actuator.varies() && !follows) spans(r, a) = actuator.at(middle);
    }
  }
  LoadPath::Ends ends;
  ends.holds_lengths = holds_lengths;
  Eigen::VectorXd left = wanted;
  if (count > 0) {
    const Eigen::VectorXd u = spans.completeOrthogonalDecomposition().solve(wanted);
    ends.first.assign(u.data(), u.data() + count);
    left -= spans * u;
  }
  ends.last = last;
  for (Eigen::Index r = 0; r < stretches; ++r) {
    if (std::abs(left[r]) <= 1e-14 * (1.0 + wanted.cwiseAbs().maxCoeff())) continue;
    rod.actuators.push_back(
        {knots[static_cast<std::size_t>(r)], knots[static_cast<std::size_t>(r) + 1], -infinity, infinity});
    ends.first.push_back(left[r]);
    ends.last.push_back(0.0);
  }
  return ends;
}

/// The shape that these moments hold: the constant curvature, or where a rod bends unevenly one with the same turn over
/// every stretch.
Curvature held_shape(const Rod& rod, double curvature) {
  const auto even = [](const Rod::Segment& s) { return s.bends_evenly(); };
  if (std::all_of(rod.segments.begin(), rod.segments.end(), even)) return [curvature](double) { return curvature; };
  const std::vector<double> knots = rod.fixed_knots();
  std::vector<double> moments;
  moments.reserve(knots.size());
  for (std::size_t r = 0; r + 1 < knots.size(); ++r) {
    const Rod::Segment& segment = rod.segment_at(0.5 * (knots[r] + knots[r + 1]));
    moments.push_back(segment.holding_moment(knots[r], knots[r + 1], curvature));
  }
  return [segments = rod.segments, knots, moments](double s) {
    std::size_t r = 0;
    while (r + 2 < knots.size() && s > knots[r + 1]) ++r;
    std::size_t i = 0;
    while (i + 1 < segments.size() && segments[i].to < 0.5 * (knots[r] + knots[r + 1])) ++i;
    return segments[i].rest_curvature_at(s).value + moments[r] / segments[i].stiffness_at(s).value;
  };
}

}  // namespace

Loading::Set Loading::set_from_rest(Rod rod, const std::vector<const Obstacle*>& obstacles, double curvature,
                                    const Held& held, bool holds_lengths) {
  LoadPath::Ends ends = ends_from_rest(rod, curvature, held.moments, holds_lengths);
  ends.first_moves = ends.last_moves = held.moves;
  const Curvature shape = held_shape(rod, curvature);
  return {LoadPath(std::move(rod), obstacles, ends), {shape, {}, 0.0}, Tracker::Start::exact, true};
}

Loading::Loading(const Rod& rod, const std::vector<const Obstacle*>& obstacles, double curvature, const Held& held,
                 std::function<bool()> must_stop, bool holds_lengths)
    : Loading(set_from_rest(rod, obstacles, curvature, held, holds_lengths), obstacles, std::move(must_stop)) {
  draw_tendons();
}

Loading::Loading(const Rod& rod, const std::vector<const Obstacle*>& obstacles, State earlier, const Held& first,
                 const Held& last, std::function<bool()> must_stop, bool holds_lengths)
    : Loading({LoadPath(rod, obstacles, {first.moments, last.moments, false, holds_lengths, first.moves, last.moves}),
               std::move(earlier), Tracker::Start::near, first != last},
              obstacles, std::move(must_stop)) {}

Loading::Loading(const Rod& rod, const std::vector<const Obstacle*>& obstacles, Curvature shape, const Held& held,
                 std::function<bool()> must_stop, bool holds_lengths)
    : Loading({LoadPath(rod, obstacles, {held.moments, held.moments, false, holds_lengths, held.moves, held.moves}),
               {std::move(shape), {}, 0.0},
               Tracker::Start::relax,
               false},
              obstacles, std::move(must_stop)) {}

Loading::Loading(Set set, const std::vector<const Obstacle*>& obstacles, std::function<bool()> must_stop)
    : path_(std::move(set.path)),
      start_(std::move(set.start)),
      from_(set.from),
      moves_(set.moves),
      must_stop_(std::move(must_stop)),
      tracker_(path_, must_stop_) {
  grow_overlapped(obstacles);
}

/// Tendons that are held by their length begin as long as they have to be at the start.
void Loading::draw_tendons() {
  const std::vector<Rod::Actuator>& all = path_.rod().actuators;
  if (std::none_of(all.begin(), all.end(), [](const Rod::Actuator& a) { return a.by_length; })) return;
  Statics free(path_, std::make_shared<LegendreBasis>(12, 1), {}, suggested_nodes(12, 4.0));
  const PoseProgram& program = free.at(free.point(start_));
  for (std::size_t a = 0; a < all.size(); ++a) {
    if (all[a].by_length) path_.begin_at(a, all[a].side() * program.turn_along(static_cast<int>(a)));
  }
}

void Loading::grow_overlapped(const std::vector<const Obstacle*>& obstacles) {
  Statics free(path_, std::make_shared<LegendreBasis>(12, 4), {}, suggested_nodes(12, 4.0));
  // Where the rod is moved to along the path it is not yet.
  const Eigen::VectorXd z = free.point({start_.curvature, {}, 0.0});
  Curve curve(free.at(z).chain().curve_tables());
  curve.follow(free.at(z).backbone());
  for (std::size_t o = 0; o < obstacles.size(); ++o) {
    const Obstacle& obstacle = *obstacles[o];
    double deepest = 0.0;
    double core = infinity;
    for (const ClosestApproach& at : closest_approaches(curve, obstacle, 0.0)) {
      deepest = std::min(deepest, at.distance);
      core =
          std::min(core, obstacle.core_distance(curve.position(at.piece, at.sigma)) - curve.radius(at.piece, at.sigma));
    }
    // A contact of an earlier result is closed to rounding, or to the accuracy of its basis.
    const bool touched = std::any_of(start_.contacts.begin(), start_.contacts.end(),
                                     [&](const PointContact& c) { return c.setup.obstacle == static_cast<int>(o); });
    if (!(deepest < (touched ? -0.02 : -tolerance::penetration))) continue;
    overlaps_.push_back({o, -deepest});
    if (!std::isfinite(obstacle.smallest_radius())) {
      path_.grow(o, -deepest);
      continue;
    }
    if (!(core > core_side)) {
      without_side_ = o;
      return;
    }
    path_.grow(o, obstacle.rounding());
  }
  if (overlaps_.empty()) return;
  std::erase_if(start_.contacts, [&](const PointContact& c) { return path_.distance_rate(c.setup.obstacle) != 0.0; });
}

void Loading::rub(const std::vector<double>& friction, const std::vector<double>& first) {
  for (std::size_t o = 0; o < friction.size(); ++o) path_.rub(o, first.empty() ? 0.0 : first[o], friction[o]);
  moves_ = true;
}

void Loading::roughen(const std::vector<double>& coefficients) {
  for (std::size_t o = 0; o < coefficients.size(); ++o) {
    if (coefficients[o] > 0.0 && path_.distance_rate(static_cast<int>(o)) == 0.0) path_.roughen(o, coefficients[o]);
  }
}

bool Loading::run() {
  if (!tracker_.begin(start_, from_)) return false;
  if (moves_ || !overlaps_.empty()) return tracker_.follow();
  // Nothing changes along this path: its beginning is its end.
  Settled& s = tracker_.current();
  s.z[s.statics->size()] = 1.0;
  return true;
}

std::optional<Loading::Lying> Loading::lie() {
  Settled& end = tracker_.current();
  if (!tracker_.spread() || end.statics == nullptr || must_stop_()) return std::nullopt;
  const double from = end.z[end.statics->size()];
  const int steps = std::max(1, static_cast<int>(std::ceil((1.0 - from) / longest_load_step)));
  Curvature curvature = end.statics->curvature(end.z, end.z);
  Lying found;
  for (int i = 1; i <= steps; ++i) {
    const double load = i == steps ? 1.0 : from + (1.0 - from) * i / steps;
    found.down = descend(path_, load, curvature, must_stop_, i == steps);
    if (!found.down.converged) return std::nullopt;
    curvature = found.down.state.curvature;
  }
  for (const PointContact& c : found.down.state.contacts) {
    if (!c.extended) continue;
    found.first = std::min(found.first, c.s);
    found.last = std::max(found.last, c.s);
  }
  if (!(found.last > found.first)) return std::nullopt;
  return found;
}

}  // namespace tendril
