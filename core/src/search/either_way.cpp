#include "search/either_way.hpp"

#include <algorithm>
#include <cmath>

#include "base/clock.hpp"
#include "search/parameters.hpp"
#include "search/planner.hpp"

namespace tendril {
namespace {

bool reads_direction(const Task& task) {
  return std::any_of(task.terms.begin(), task.terms.end(), [](const PoseProgramTerm& t) {
    const Reads reads = t.term->reads();
    return reads.target && reads.tip_angle;
  });
}

/// Whether no other turn of the tip can bring much: it is where the target is.
bool is_there(const Plan& plan, const Task& task) {
  const double near = search_parameters().there;
  return plan.status == PlanStatus::solved && std::abs(plan.tip_angle - task.target.angle) <= near &&
         plan.target_error.value_or(0.0) <= near * task.scale.length;
}

}  // namespace

Plan plan_either_way(Task& task, const PlanControl& control) {
  /// The scene keeps its limit, whatever a solver throws.
  struct Limit {
    double& of;
    const double scene = of;
    ~Limit() { of = scene; }
  } limit{task.scene.solver.time_limit};
  const double begin = now();
  const double reference = control.start != nullptr ? control.start->tip_angle : task.start_tip_angle();
  std::vector<double> angles = task.angles_near(reference);
  if (angles.empty() || !reads_direction(task)) return Planner(task, control).run();
  Plan best;
  for (std::size_t i = 0; i < angles.size(); ++i) {
    task.target.angle = angles[i];
    limit.of = limit.scene - (now() - begin);
    if (i > 0 && limit.of <= 0.0) {
      best.search_cut = true;
      break;
    }
    Plan next = Planner(task, control).run();
    const bool there = is_there(next, task);
    const bool better =
        next.status == PlanStatus::solved && (best.status != PlanStatus::solved || next.objective < best.objective);
    const bool stopped = next.status == PlanStatus::interrupted;
    if (i == 0 || better) std::swap(best, next);
    if (i > 0) {
      best.evaluations += next.evaluations;
      best.seconds_certify += next.seconds_certify;
    }
    if (there || stopped) break;
  }
  task.face(best.tip_angle);
  return best;
}

}  // namespace tendril
