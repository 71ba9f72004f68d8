#include "search/sides.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <tuple>
#include <utility>

#include "obstacle/region.hpp"
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

/// What is seen of a shape, `line` being memory for it.
SideStart look_at(const Task& task, StartShape shape, std::vector<OutlinePoint>& line) {
  outline(task.rod, shape.curvature, search_parameters().outline_steps, line);
  const std::size_t count = task.obstacles.size();
  SideStart seen{std::move(shape), Sides(count, 0), std::vector<int>(count, 0), std::vector<double>(count, infinity)};
  seen.tip = line.back().position;
  for (const OutlinePoint& p : line) seen.bend += p.curvature * p.curvature / static_cast<double>(line.size());
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

double merit_of(const Task& task, const SideStart& seen) {
  double sum = 0.0;
  if (task.target.has_position) {
    const Vec2 miss = seen.tip - task.target.position;
    sum += dot(miss, miss);
  }
  sum += search_parameters().cost_of_bend * seen.bend;
  for (const double d : seen.distances) sum += search_parameters().cost_of_depth * std::max(0.0, -d);
  return sum;
}

bool same_sides(const SideStart& a, const SideStart& b) { return a.sides == b.sides && a.patches == b.patches; }

/// Shows shapes of two arcs that meet at `bend`, or of one where that is 1, to `see`, from one side to the other or in
/// turn from both, as long as it returns true.
template <class See>
void look_at_arcs(const Task& task, double bend, bool in_turn, const See& see) {
  const SearchParameters& p = search_parameters();
  const bool two = bend < 1.0;
  const int count = two ? p.arcs_of_two : p.arcs_of_one;
  std::vector<OutlinePoint> line;
  const auto angle = [&](int i) { return (2.0 * i / (count - 1) - 1.0) * (two ? p.widest_of_two : p.widest_of_one); };
  for (int number = 0; number < count; ++number) {
    const int i = !in_turn ? number : number % 2 == 0 ? number / 2 : count - 1 - number / 2;
    for (int k = 0; k < (two ? count : 1); ++k) {
      const double first = two ? angle(i) / bend : angle(i);
      const double second = two ? angle(k) / (1.0 - bend) : first;
      const auto curvature = [=](double s) { return s < bend ? first : second; };
      if (!see(look_at(task, {curvature}, line))) return;
    }
  }
}

bool any_has_sides(const Task& task) {
  bool any = false;
  for (std::size_t o = 0; o < task.obstacles.size(); ++o) any = any || has_sides(task, o);
  return any;
}

}  // namespace

bool has_pockets(const Obstacle& obstacle, Vec2 base) {
  constexpr double narrow = 0.01, flat = 1e-4;  // units of L
  constexpr std::size_t count = 2048;
  if (obstacle.convex()) return false;
  std::vector<Vec2> line(count);
  obstacle.outline(line, base - Vec2{2.0, 2.0}, base + Vec2{2.0, 2.0});
  if (!std::all_of(line.begin(), line.end(), [](Vec2 p) { return std::isfinite(p.x) && std::isfinite(p.y); }))
    return true;
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::pair(line[a].x, line[a].y) < std::pair(line[b].x, line[b].y);
  });
  // Its lower half from left to right, and its upper half back.
  std::vector<std::size_t> hull;
  for (int half = 0; half < 2; ++half) {
    const std::size_t begin = hull.size();
    for (const std::size_t i : order) {
      const auto turns = [&](std::size_t a, std::size_t b) {
        return cross(line[b] - line[a], line[i] - line[b]) > 0.0;
      };
      while (hull.size() > begin + 1 && !turns(hull[hull.size() - 2], hull.back())) hull.pop_back();
      hull.push_back(i);
    }
    hull.pop_back();
    std::reverse(order.begin(), order.end());
  }
  ClosedLine around;
  for (const std::size_t i : hull) around.push_back(line[i]);
  if (lies_inside(around, base)) return true;
  std::sort(hull.begin(), hull.end());
  for (std::size_t k = 0; k < hull.size(); ++k) {
    const std::size_t last = k + 1 < hull.size() ? hull[k + 1] : hull[0] + count;
    const Vec2 from = line[hull[k]];
    const Vec2 along = line[last % count] - from;
    if (!(norm(along) > narrow)) continue;
    for (std::size_t i = hull[k] + 1; i < last; ++i) {
      if (std::abs(cross(along, line[i % count] - from)) > flat * norm(along)) return true;
    }
  }
  return false;
}

bool has_sides(const Task& task, std::size_t o) {
  const Obstacle& obstacle = *task.obstacles[o];
  return std::isfinite(obstacle.smallest_radius()) &&
         (obstacle.at(task.rod.base).distance < 1.0 || !task.rod.moves.empty());
}

Sides sides_of(const Task& task, const StartShape& shape) {
  std::vector<OutlinePoint> line;
  return look_at(task, shape, line).sides;
}

SideStart start_by_sides(const Task& task, StartShape shape) {
  std::vector<OutlinePoint> line;
  SideStart start = look_at(task, std::move(shape), line);
  start.merit = merit_of(task, start);
  return start;
}

bool several_sides(const Task& task) {
  if (!any_has_sides(task)) return false;
  if (!task.arcs.empty()) {
    return std::any_of(task.arcs.begin(), task.arcs.begin() + static_cast<std::ptrdiff_t>(task.unbent_arcs),
                       [&](const SideStart& arc) { return !same_sides(arc, task.arcs.front()); });
  }
  std::optional<SideStart> first;
  bool several = false;
  look_at_arcs(task, knee(task.rod), true, [&](SideStart seen) {
    several = first && !same_sides(seen, *first);
    if (!first) first = std::move(seen);
    return !several;
  });
  return several;
}

std::vector<SideStart> starts_by_sides(Task& task, bool bent) {
  const auto add = [&](SideStart seen) {
    task.arcs.push_back(std::move(seen));
    task.arcs.back().number = static_cast<int>(task.arcs.size());
    return true;
  };
  if (task.arcs.empty() && any_has_sides(task)) {
    look_at_arcs(task, knee(task.rod), false, add);
    task.unbent_arcs = task.arcs.size();
  }
  if (bent && task.arcs.size() == task.unbent_arcs && knee(task.rod) == 1.0) {
    for (const double bend : {0.25, 0.5}) {
      look_at_arcs(task, bend, false, [&](SideStart seen) {
        seen.bent_at = bend;
        return add(std::move(seen));
      });
    }
  }
  std::map<std::tuple<Sides, std::vector<int>, double>, const SideStart*> best;
  const auto begin = bent ? task.unbent_arcs : 0;
  const auto end = bent ? task.arcs.size() : task.unbent_arcs;
  for (std::size_t i = begin; i < end; ++i) {
    SideStart& arc = task.arcs[i];
    arc.merit = merit_of(task, arc);
    const auto [known, added] = best.try_emplace({arc.sides, arc.patches, arc.bent_at}, &arc);
    if (!added && arc.merit < known->second->merit) known->second = &arc;
  }
  std::vector<SideStart> all;
  all.reserve(best.size());
  for (const auto& entry : best) all.push_back(*entry.second);
  std::stable_sort(all.begin(), all.end(), [](const SideStart& a, const SideStart& b) { return a.merit < b.merit; });
  return all;
}

}  // namespace tendril
