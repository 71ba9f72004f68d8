#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "tendril/obstacle.hpp"
#include "tendril/plan.hpp"
#include "tendril/scene.hpp"

namespace tendril {

/// The forward problem (model.md section 6, "execute"): moments are given, the shape is what comes of them.

/// What ended a stable branch.
enum class SnapKind {
  fold,         ///< the branch turns back: no equilibrium near it carries a higher load
  bifurcation,  ///< the branch goes on but is unstable; both sides of it are equal, the larger tip angle is taken
  release,      ///< the last contact that held the rod let go
  slip,         ///< a contact slid to the tip, where it holds the rod no longer
  start         ///< the shape that was started from is no stable equilibrium of its own loads
};
TENDRIL_API std::string_view to_string(SnapKind kind);  ///< The kind as results write it.

/// A jump to another stable state while loads grow. SI units; `before` and `after` are at the same load, except at a
/// bifurcation, where the new branch grows out of the old one and `after` stands 1e-3 of the loads further.
struct Snap {
  SnapKind kind = SnapKind::fold;               ///< what ended the branch
  double load = 0.0;                            ///< load fraction, 0 at the start shape, 1 at the final loads
  std::vector<double> moments;                  ///< N m, one per actuator, at that load fraction
  std::vector<BackbonePoint> before;            ///< the shape that was left
  std::vector<BackbonePoint> after;             ///< the shape that was reached
  std::vector<PlannedContact> contacts_before;  ///< with the shape that was left
  std::vector<PlannedContact> contacts_after;   ///< with the shape that was reached
  double stability_after = 0.0;                 ///< margin
};

/// What an execution starts from and what may end it.
struct ExecuteControl {
  /// set to true from outside to end it cleanly; null: nothing does
  const std::atomic<bool>* stop = nullptr;
  double time_limit = 60.0;  ///< s
  /// An earlier result to start from: its shape, moments and contacts under all of the scene's other loads; only the
  /// moments then change linearly. Null: the scene's constant-curvature start without loads, all of which then grow.
  const Plan* start = nullptr;
  /// False: as if the scene had no obstacle.
  bool with_obstacles = true;
};

/// What the rod does. `result` reads like a plan: `moments` are those given, `contacts` the active ones only,
/// `coordinates` those of the fine Legendre basis. Its status: `solved` (a stable equilibrium that the certificate
/// accepts), `not_converged` (with the reason: a contact that spreads, a path that could not be followed),
/// `time_limit`, `interrupted`.
struct Execution {
  Plan result;              ///< the state reached
  std::vector<Snap> snaps;  ///< in the order in which they happened
  double load = 0.0;        ///< load fraction reached; 1 unless the message says why not
  int steps = 0;            ///< along the path
  int contact_changes = 0;  ///< contacts made and released on the way
  int pieces = 0;           ///< of the fine basis at the end
};

/// The stable equilibrium that the rod of `scene` reaches under `moments` (N m, one per actuator of the scene, not held
/// to their limits). `obstacles`: dimensionless, one per obstacle of the scene, not null; used whatever the contact
/// mode says. From a start that overlaps obstacles these grow from nothing together with the loads. Throws SceneError
/// for a scene that makes no sense and for a start that runs through an obstacle's core, which has no side; Error for
/// moments of the wrong number or not finite.
TENDRIL_API Execution execute(const Scene& scene, const std::vector<std::unique_ptr<Obstacle>>& obstacles,
                              const std::vector<double>& moments, const ExecuteControl& control = {});

/// Executes a plan's moments and fills its `model_error`, `local_model_error` and `verification`. Where execution ends
/// elsewhere (other contacts, a tip farther off than tolerance::model_error, no certified state) a solved plan becomes
/// `not_converged` and its message says why. Returns the execution from the plan's own start. `control.start`: what the
/// plan was started from, null, or `&plan`: then the rod settles from the plan's own shape and is executed only once.
TENDRIL_API Execution verify(const Scene& scene, const std::vector<std::unique_ptr<Obstacle>>& obstacles, Plan& plan,
                             const ExecuteControl& control = {});

}  // namespace tendril
