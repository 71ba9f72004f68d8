#include "search/sides.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "rod/outline.hpp"
#include "search/parameters.hpp"

namespace tendril {
namespace {

/// Where moments can bend one half of the rod against the other: the knot nearest to its middle; 1 if there is none.
double knee(const Rod& rod) {
  double best = 1.0;
  for (const Rod::Actuator& a : rod.actuators) {
    if (a.minimum == a.maximum) continue;
    for (const double s : {a.from, a.to}) {
      if (s > 0.0 && s < 1.0 && std::abs(s - 0.5) < std::abs(best - 0.5)) best = s;
    }
  }
  return best;
}

/// What is seen of a shape: its sides, and how near it comes to obstacles.
struct Seen {
  Sides sides;
  std::vector<int> patches;
  std::vector<double> distances;
};

Seen look_at(const Task& task, const std::vector<OutlinePoint>& line) {
  const std::size_t count = task.obstacles.size();
  Seen seen{Sides(count, 0), std::vector<int>(count, 0), std::vector<double>(count, infinity)};
  // From point to point no distance changes by more than that.
  double most = 0.0;
  for (std::size_t i = 1; i < line.size(); ++i) {
    most =
        std::max(most, norm(line[i].position - line[i - 1].position) + std::abs(line[i].radius - line[i - 1].radius));
  }
  for (std::size_t o = 0; o < task.obstacles.size(); ++o) {
    if (!has_sides(task, o)) continue;
    const Obstacle& obstacle = *task.obstacles[o];
    double least = infinity;
    double turn = 0.0;
    Vec2 where{};
    for (std::size_t i = 0; i < line.size();) {
      const OutlinePoint& p = line[i];
      const SurfacePoint surface = obstacle.at(p.position);
      const double distance = surface.distance - p.radius;
      if (distance < least) {
        least = distance;
        turn = cross(p.tangent, surface.normal);
        where = p.position;
      }
      const double points = std::min((distance - least) / most, static_cast<double>(line.size()));
      i += points >= 1.0 ? static_cast<std::size_t>(points) : 1;
    }
    if (!obstacle.convex()) seen.patches[o] = obstacle.patch_at(where);
    seen.distances[o] = least;
    seen.sides[o] = (turn < 0.0 ? 1 : -1) * (std::abs(turn) > search_parameters().beside ? 1 : 2);
  }
  return seen;
}

double merit_of(const Task& task, const std::vector<OutlinePoint>& line, const Seen& seen) {
  const OutlinePoint& tip = line.back();
  double sum = 0.0;
  if (task.target.has_position) {
    const Vec2 miss = tip.position - task.target.position;
    sum += dot(miss, miss);
  }
  double bent = 0.0;
  for (const OutlinePoint& p : line) bent += p.curvature * p.curvature / static_cast<double>(line.size());
  sum += search_parameters().cost_of_bend * bent;
  for (const double d : seen.distances) sum += search_parameters().cost_of_depth * std::max(0.0, -d);
  return sum;
}

}  // namespace

bool has_sides(const Task& task, std::size_t o) {
  const Obstacle& obstacle = *task.obstacles[o];
  return std::isfinite(obstacle.smallest_radius()) &&
         (obstacle.at(task.rod.base).distance < 1.0 || !task.rod.moves.empty());
}

Sides sides_of(const Task& task, const StartShape& shape) {
  std::vector<OutlinePoint> line;
  outline(task.rod, shape.curvature, search_parameters().outline_steps, line);
  return look_at(task, line).sides;
}

SideStart start_by_sides(const Task& task, StartShape shape) {
  std::vector<OutlinePoint> line;
  outline(task.rod, shape.curvature, search_parameters().outline_steps, line);
  Seen seen = look_at(task, line);
  const double merit = merit_of(task, line, seen);
  return {std::move(shape), std::move(seen.sides), std::move(seen.patches), std::move(seen.distances), merit};
}

std::vector<SideStart> starts_by_sides(const Task& task) {
  bool any = false;
  for (std::size_t o = 0; o < task.obstacles.size(); ++o) any = any || has_sides(task, o);
  if (!any) return {};
  const SearchParameters& p = search_parameters();
  const double bend = knee(task.rod);
  const bool two = bend < 1.0;
  const int count = two ? p.arcs_of_two : p.arcs_of_one;
  std::map<std::pair<Sides, std::vector<int>>, SideStart> best;
  std::vector<OutlinePoint> line;
  const auto angle = [&](int i) { return (2.0 * i / (count - 1) - 1.0) * (two ? p.widest_of_two : p.widest_of_one); };
  for (int i = 0; i < count; ++i) {
    for (int k = 0; k < (two ? count : 1); ++k) {
      const double first = two ? angle(i) / bend : angle(i);
      const double second = two ? angle(k) / (1.0 - bend) : first;
      const auto curvature = [=](double s) { return s < bend ? first : second; };
      outline(task.rod, curvature, p.outline_steps, line);
      Seen seen = look_at(task, line);
      const double merit = merit_of(task, line, seen);
      auto key = std::pair(seen.sides, seen.patches);
      const auto known = best.find(key);
      if (known != best.end() && known->second.merit <= merit) continue;
      best[std::move(key)] = {
          {curvature}, std::move(seen.sides), std::move(seen.patches), std::move(seen.distances), merit};
    }
  }
  std::vector<SideStart> all;
  all.reserve(best.size());
  for (auto& entry : best) all.push_back(std::move(entry.second));
  std::stable_sort(all.begin(), all.end(), [](const SideStart& a, const SideStart& b) { return a.merit < b.merit; });
  return all;
}

}  // namespace tendril
