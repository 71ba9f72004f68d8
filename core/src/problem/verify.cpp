#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "problem/friction.hpp"
#include "problem/way.hpp"
#include "tendril/execute.hpp"
#include "tendril/leading.hpp"
#include "tendril/numbers.hpp"
#include "tendril/pivot.hpp"
#include "tendril/problem.hpp"
#include "tendril/scale.hpp"
#include "tendril/tolerances.hpp"

namespace tendril {
namespace {

/// Obstacles that hold the rod with more than a trace of force (EI/L^2).
constexpr double trace_of_force = 1e-3;

std::set<std::string> holding(const Plan& plan, double force_unit) {
  std::set<std::string> names;
  for (const PlannedContact& c : plan.contacts) {
    if (c.force > trace_of_force * force_unit) names.insert(c.obstacle_name);
  }
  return names;
}

/// An obstacle that holds the rod in both, from opposite sides; empty if there is none.
std::string other_side(const Plan& plan, const Plan& met, double force_unit) {
  const auto holds = [&](const PlannedContact& c) { return c.force > trace_of_force * force_unit; };
  for (const PlannedContact& a : plan.contacts) {
    const bool opposite = std::any_of(met.contacts.begin(), met.contacts.end(), [&](const PlannedContact& b) {
      return holds(a) && holds(b) && a.obstacle_name == b.obstacle_name && dot(a.normal, b.normal) < 0.0;
    });
    if (opposite) return a.obstacle_name;
  }
  return "";
}

std::string list(const std::set<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "'" : ", '") + name + "'";
  return text.empty() ? "no obstacle" : text;
}

}  // namespace

Execution verify(const Scene& scene, const std::vector<std::unique_ptr<Obstacle>>& obstacles, Plan& plan,
                 const ExecuteControl& control) {
  // From the plan's own shape: what its basis leaves out, apart from how the loads get there.
  ExecuteControl placed = control;
  placed.place = plan.place;
  placed.with_friction = false;
  // The plan holds if its contacts push as it has them.
  if (control.friction.empty()) placed.friction = ratios_of(plan, obstacles.size());
  ExecuteControl local = placed;
  local.start = &plan;
  local.with_obstacles = control.with_obstacles && needs_obstacles(scene);
  bool own = control.start == &plan && local.with_obstacles == control.with_obstacles;
  Execution reached;
  std::string unmade;
  try {
    reached = execute(scene, obstacles, plan, placed);
  } catch (const SceneError& error) {
    // A start that nothing can be loaded from says nothing of the plan, whose own shape is still a start.
    if (own) throw;
    unmade = std::string("it cannot be loaded from the start: ") + error.what() + "; ";
    own = true;
    reached = execute(scene, obstacles, plan, local);
  }
  const char* loaded = control.start == nullptr ? "loaded from the start" : "led on from the earlier result";
  const Scale scale = scale_of(scene);
  const auto distance = [&](const Plan& other) {
    return std::hypot(plan.tip_x - other.tip_x, plan.tip_y - other.tip_y);
  };
  const auto percent = [&](double metres) {
    return shown(metres, 3) + " m (" + shown(100.0 * metres / scale.length, 2) + " % of the length)";
  };
  std::string trouble;
  if (reached.result.status == PlanStatus::solved) {
    plan.model_error = distance(reached.result);
    const std::set<std::string> planned = holding(plan, scale.force());
    const std::set<std::string> met = holding(reached.result, scale.force());
    if (planned != met) {
      trouble = "the plan rests on " + list(planned) + ", execution on " + list(met);
    } else if (const std::string turned = other_side(plan, reached.result, scale.force()); !turned.empty()) {
      trouble = "the plan rests on the other side of '" + turned + "' than execution does";
    } else if (!(*plan.model_error <= tolerance::model_error * scale.length)) {
      trouble = "the tip ends elsewhere";
    }
    plan.verification = unmade + (own ? "settled from the plan's own shape" : loaded) + " the tip comes to rest " +
                        percent(*plan.model_error) + " from the plan's";
    if (!reached.snaps.empty()) plan.verification += ", after " + std::to_string(reached.snaps.size()) + " snap(s)";
  } else {
    trouble = own                        ? "the plan's own shape did not settle: "
              : control.start == nullptr ? "loading from the start did not arrive: "
                                         : "leading on from the earlier result did not arrive: ";
    trouble += reached.result.message;
    plan.verification = unmade + trouble;
  }
  if (own) {
    plan.local_model_error = plan.model_error;
  } else {
    const Execution near = execute(scene, obstacles, plan, local);
    if (near.result.status == PlanStatus::solved) {
      plan.local_model_error = distance(near.result);
      plan.verification += "; settled from the plan's own shape " + percent(*plan.local_model_error);
    } else {
      plan.verification += "; the plan's own shape did not settle: " + near.result.message;
    }
  }
  if (!trouble.empty() && plan.status == PlanStatus::solved) {
    plan.status = PlanStatus::not_converged;
    plan.message = "execution does not confirm the plan: " + trouble;
    if (!plan.verification.empty()) plan.message += " (" + plan.verification + ")";
  }
  return reached;
}

namespace {

/// In so many stretches obstacles are led from one step to the next, at most.
constexpr int most_stretches = 200;

/// How many it takes so that no point of an obstacle goes farther in one than a quarter of its rounding: a rod that
/// lies half of it deep when the obstacle is set there may come to the other side.
int stretches(const Scene& scene, const ObstaclesAt& obstacles, const TargetSpec& from, const TargetSpec& to) {
  if (from.obstacles.empty() || from.obstacles.size() != to.obstacles.size()) return 1;
  const std::vector<std::unique_ptr<Obstacle>> made = obstacles(from);
  const double length = scale_of(scene).length;
  double most = 1.0;
  for (std::size_t i = 0; i < to.obstacles.size(); ++i) {
    const auto o = static_cast<std::size_t>(to.obstacles[i].obstacle);
    // A flat side has no other side.
    if (!std::isfinite(made[o]->smallest_radius())) continue;
    Vec2 low;
    Vec2 high;
    made[o]->bounding_box(low, high);
    const ObstaclePlace& a = from.obstacles[i].place;
    const ObstaclePlace& b = to.obstacles[i].place;
    const Vec2 center = pivot_of(*made[o]);
    const double arm = norm(0.5 * (low + high) - center) + 0.5 * norm(high - low);
    const double way = norm(b.shift - a.shift) / length + std::abs(b.turn - a.turn) * arm;
    most = std::max(most, way / (0.25 * made[o]->rounding()));
  }
  return static_cast<int>(std::ceil(std::min(most, static_cast<double>(most_stretches))));
}

}  // namespace

RodPlace between(const RodPlace& a, const RodPlace& b, double share) {
  RodPlace middle = b;
  if (a.insertion && b.insertion) middle.insertion = *a.insertion + share * (*b.insertion - *a.insertion);
  if (a.base && b.base) {
    middle.base = BasePose{a.base->position + share * (b.base->position - a.base->position),
                           a.base->angle + share * (b.base->angle - a.base->angle)};
  }
  return middle;
}

void add_snaps(const std::vector<Snap>& snaps, double from, double to, std::vector<Snap>& all) {
  for (const Snap& snap : snaps) {
    all.push_back(snap);
    all.back().load = from + snap.load * (to - from);
  }
}

std::optional<Led> led_near(const Scene& scene, const ObstaclesAt& obstacles, const TargetSpec& from,
                            const Plan& before, const TrajectoryStep& step, const ExecuteControl& control) {
  const int count = stretches(scene, obstacles, from, step.target);
  const std::vector<double> first = held_of(scene, before);
  const std::vector<double> last = held_of(scene, step.plan);
  std::optional<Led> led;
  ExecuteControl leading = control;
  for (int i = 1; i < count; ++i) {
    const double share = static_cast<double>(i) / count;
    std::vector<double> held = first;
    for (std::size_t a = 0; a < held.size(); ++a) held[a] += share * (last[a] - first[a]);
    leading.start = led ? &led->at : &before;
    leading.place = between(before.place, step.plan.place, share);
    try {
      Execution next = execute(scene, obstacles(between(from, step.target, share)), held, leading);
      if (next.result.status != PlanStatus::solved) break;
      const double start = led ? led->share : 0.0;
      std::vector<Snap> snaps = led ? std::move(led->snaps) : std::vector<Snap>{};
      add_snaps(next.snaps, start, share, snaps);
      led = Led{std::move(next.result), share, std::move(snaps)};
    } catch (const SceneError&) {
      break;  // an obstacle that is smaller than its stretch: whoever executes the step tells
    }
  }
  return led;
}

std::vector<Snap> snaps_of(const std::optional<Led>& led, const Execution& rest) {
  std::vector<Snap> all = led ? led->snaps : std::vector<Snap>{};
  add_snaps(rest.snaps, led ? led->share : 0.0, 1.0, all);
  return all;
}

void verify(const Scene& scene, const ObstaclesAt& obstacles, Trajectory& trajectory, const ExecuteControl& control) {
  std::optional<Plan> before;
  const TargetSpec* from = nullptr;
  for (TrajectoryStep& step : trajectory.steps) {
    Plan& plan = step.plan;
    if (plan.backbone.empty()) {
      plan.verification = "not executed: the plan came to no shape";
      continue;
    }
    ExecuteControl from_before = control;
    // Contacts push as they do in the plan, or along their normals on the way to it.
    ExecuteControl leading = control;
    leading.with_friction = false;
    std::optional<Led> led;
    if (before) led = led_near(scene, obstacles, *from, *before, step, leading);
    if (before) from_before.start = led ? &led->at : &*before;
    Execution reached = verify(scene, obstacles(step.target), plan, from_before);
    step.snaps = snaps_of(led, reached);
    if (led && !led->snaps.empty()) {
      plan.verification += "; " + std::to_string(led->snaps.size()) + " snap(s) while obstacles were led along";
    }
    // After a step that did not come to rest the next one starts from where the plan has it.
    before = reached.result.status == PlanStatus::solved ? std::move(reached.result) : plan;
    from = &step.target;
  }
}

}  // namespace tendril
