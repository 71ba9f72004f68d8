#pragma once

#include <functional>
#include <string_view>
#include <vector>

#include "tendril/execute.hpp"
#include "tendril/problem.hpp"

namespace tendril {

/// How a step of a trajectory was reached.
enum class StepMethod {
  followed,    ///< by Newton from the step before; no solver was called
  solved,      ///< by a full plan from the step before
  subdivided,  ///< over intermediate targets
  failed,      ///< not at all; the plan is the nearest one
  executed     ///< not planned: moments that were given were carried out
};
TENDRIL_API std::string_view to_string(StepMethod method);  ///< The method as results write it.

/// What a plan took.
struct Effort {
  int solver_calls = 0;          ///< runs of the solver
  int polishes = 0;              ///< runs of Newton on an active set
  EvaluationCounts evaluations;  ///< of all programs
};
TENDRIL_API Effort effort_of(const Plan& plan);                   ///< What one plan took, over all its modes.
TENDRIL_API Effort& operator+=(Effort& sum, const Effort& more);  ///< Adds up.

/// What was planned for one target.
struct TrajectoryStep {
  TargetSpec target;                       ///< what was asked for
  Plan plan;                               ///< what was found
  StepMethod method = StepMethod::failed;  ///< how it was reached
  int intermediate = 0;                    ///< targets that were put between this one and the one before
  Effort effort;                           ///< of everything planned for this step
  Effort cold;  ///< of a plan for this target from the scene's own start, if it was asked for
  /// Of its execution, obstacles that were led along included. `load`: share of the way from the step before.
  std::vector<Snap> snaps{};
};

/// Plans for a row of targets.
struct TENDRIL_API Trajectory {
  std::vector<TrajectoryStep> steps;  ///< one per target, fewer only if it was interrupted
  bool interrupted = false;           ///< stopped from outside
  bool solved() const;                ///< All targets were planned for, each with a certified plan.
};

/// How to plan for one target. `start` is null for a plan from the scene's own start. `follow` as in PlanControl.
using PlanStep = std::function<Plan(const TargetSpec& target, const Plan* start, bool follow)>;

/// How a trajectory is planned.
struct TrajectoryOptions {
  /// Every so many steps a full plan in place of Newton alone, which sees whether another way of being in contact has
  /// become better; it may jump there. 0: only when a contact comes or goes, or Newton fails.
  int replan_every = 0;
  bool cold_starts = false;  ///< plan each target from the scene's own start as well, to compare
  /// Called after every step with how many are finished and how many there are; must not throw. Empty: nobody is told.
  std::function<void(int finished, int steps)> progress{};
};

/// Targets between two of a trajectory that may be tried where a step fails: halves of halves, so steps down to 1/64.
inline constexpr int most_halvings = 6;
/// Most targets that are put between two before a step counts as failed.
inline constexpr int most_intermediate = 32;

/// Plans one target after the other, each from the one before (docs/model.md section 6): Newton on the previous active
/// set first, a full plan where that does not do, intermediate targets where that fails too. After a target that cannot
/// be reached the next one starts from the last that was.
TENDRIL_API Trajectory plan_trajectory(const std::vector<TargetSpec>& targets, const TrajectoryOptions& options,
                                       const PlanStep& plan);

/// The scene with those obstacles that move where a step has them.
TENDRIL_API Scene with_obstacles(Scene scene, const TargetSpec& step);
/// Makes the obstacles of a scene as they are at a step.
using ObstaclesAt = std::function<std::vector<std::unique_ptr<Obstacle>>(const TargetSpec& step)>;

/// Executes every step from where the one before came to rest, the first one from `control.start` or the scene's start,
/// and fills and judges its plan as verify() of one plan does; snaps on the way are the step's. After a step that does
/// not come to rest the next one starts from that step's own shape.
TENDRIL_API void verify(const Scene& scene, const ObstaclesAt& obstacles, Trajectory& trajectory,
                        const ExecuteControl& control = {});

}  // namespace tendril
