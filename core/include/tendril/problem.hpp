#pragma once

#include <atomic>
#include <memory>

#include "tendril/plan.hpp"
#include "tendril/registrar.hpp"
#include "tendril/scene.hpp"
#include "tendril/sensitivity.hpp"

namespace tendril {

struct Task;

/// A scene made dimensionless and assembled: only the blocks that it needs. Throws SceneError where a component meets a
/// scene that it cannot serve (an obstacle around the base, a target that is missing).
class TENDRIL_API Problem {
 public:
  /// Takes the components that make_components() or the caller made for `scene`. Throws Error where one is missing.
  Problem(const Scene& scene, Components components);
  Problem(Problem&&) noexcept;             ///< Leaves the other one unusable.
  Problem& operator=(Problem&&) noexcept;  ///< Leaves the other one unusable.
  ~Problem();

  Description describe() const;  ///< What was built, and what was left out and why. Plans nothing.
  /// Asks for another pose from now on. Throws SceneError if `target` lacks what an objective reads.
  void set_target(const TargetSpec& target);
  /// Solves every mode that can win and returns the best certified plan; else the one that comes nearest, with its
  /// status.
  Plan plan(const PlanControl& control = {});
  /// Replaces `plan`, made by this problem, by one for another target, as set_target() and plan() would with `plan` to
  /// follow; for loops at a steady rate. Where Newton on the plan's own active set is certified, or on that with the
  /// contact that comes or without the one that goes, no solver is called, and from the second such step in a row
  /// nothing is allocated as long as the active set stays; otherwise everything is planned. `stop` as in PlanControl.
  void follow(const TargetSpec& target, Plan& plan, const std::atomic<bool>* stop = nullptr);
  /// The part of follow() that calls no solver. Returns whether that does; else the target is set and `plan` is as it
  /// was.
  bool step(const TargetSpec& target, Plan& plan, const std::atomic<bool>* stop = nullptr);
  /// The derivatives of a plan of this scene by its numbers, by the implicit function theorem
  /// (docs/model.md section 15): one factorization, a right-hand side per number. `keys`: of scene_numbers() (or, of
  /// held plans, "moments[i]"); none: all of them. Where there is no derivative the trouble says why. Throws Error for
  /// an unknown key.
  Sensitivity sensitivity(const Plan& plan, SensitivityKind kind, const std::vector<std::string>& keys = {});

 private:
  bool follow_without_solver(Plan& plan, bool contacts_may_change);

  std::unique_ptr<Task> task_;
};

}  // namespace tendril
