#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "tendril/obstacle.hpp"
#include "tendril/plan.hpp"
#include "tendril/scene.hpp"

namespace tendril {

/// The forward problem (docs/model.md section 6, "execute"): moments are given, the shape is what comes of them.

/// What an execution starts from and what may end it.
struct ExecuteControl {
  /// set to true from outside to end it cleanly; null: nothing does
  const std::atomic<bool>* stop = nullptr;
  double time_limit = 60.0;  ///< s
  /// An earlier result to start from: its shape, moments, place and contacts under all of the scene's other loads; only
  /// moments and place then change, linearly. Null: the scene's constant-curvature start without loads, all of which
  /// then grow.
  const Plan* start = nullptr;
  /// Where the rod is moved to, also one that no scene moves; what is absent is as `start` has it, or as the scene has
  /// it. From a `start` elsewhere it is moved on the way, linearly.
  RodPlace place{};
  /// The same of the lower finger of a grasp where both are planned, in the world.
  RodPlace lower_place{};
  /// One number per obstacle: the tangential part of its contact forces, along the rod, for each unit of the normal
  /// part; it grows from 0 along the path, whatever coefficients the scene has. Empty: contacts stick and slip at
  /// these. The path ends where the rod gives way.
  std::vector<double> friction{};
  /// False: as if no obstacle had a coefficient of friction.
  bool with_friction = true;
  /// False: as if the scene had no obstacle.
  bool with_obstacles = true;
};

/// What the rod does. `result` reads like a plan: `moments` are those given, of tendons told their length those that
/// follow, 0 where they are slack (its certificate's `bounds` and its message
/// say which of them are beyond their limits, which fails no certificate here), `contacts` the active ones only,
/// `coordinates` those of the fine Legendre basis. Its status: `solved` (a stable equilibrium that the certificate
/// accepts), `not_converged` (with the reason: a contact that spreads, a path that could not be followed),
/// `time_limit`, `interrupted`.
struct Execution {
  Plan result;              ///< the state reached
  std::vector<Snap> snaps;  ///< in the order in which they happened
  double load = 0.0;        ///< load fraction reached; 1 unless the message says why not
  int steps = 0;            ///< along the path
  int contact_changes = 0;  ///< contacts made and released on the way
  int tendon_changes = 0;   ///< tendons told their length that were drawn taut or went slack on the way
  int pieces = 0;           ///< of the fine basis at the end
};

/// What execute() holds so that the rod does what it does in `plan`: of each actuator its moment (N m), or the
/// shortening (m) of a tendon told its length.
TENDRIL_API std::vector<double> held_of(const Scene& scene, const Plan& plan);

/// What ExecuteControl::friction has to be so that contacts push as they do in `plan`, for so many obstacles; empty:
/// along their normals.
TENDRIL_API std::vector<double> ratios_of(const Plan& plan, std::size_t obstacles);

/// The stable equilibrium that the rod of `scene` reaches under what its actuators are held at: moments (N m), or
/// shortenings (m) of tendons told their length, one per actuator of the scene, not held to their limits. `obstacles`:
/// dimensionless, one per obstacle of the scene, not null; used whatever the contact mode says. From a start that
/// overlaps obstacles these grow from nothing together with the loads. Contacts with friction stick as they are made,
/// or where they come from a result without it, and slip where they have to (model.md section 11). Throws SceneError
/// for a scene that makes no sense and for a start that runs through an obstacle's core, which has no side; Error for
/// moments of the wrong number or not finite.
TENDRIL_API Execution execute(const Scene& scene, const std::vector<std::unique_ptr<Obstacle>>& obstacles,
                              const std::vector<double>& held, const ExecuteControl& control = {});
/// The same of what a plan holds.
TENDRIL_API Execution execute(const Scene& scene, const std::vector<std::unique_ptr<Obstacle>>& obstacles,
                              const Plan& plan, const ExecuteControl& control = {});

/// Executes a plan's moments and fills its `model_error`, `local_model_error` and `verification`. Where execution ends
/// elsewhere (other contacts, a tip farther off than tolerance::model_error, no certified state) a solved plan becomes
/// `not_converged` and its message says why. Returns the execution from the plan's own start. `control.start`: what the
/// plan was started from, null, or `&plan`: then the rod settles from the plan's own shape and is executed only once,
/// as it is from a start that has no side of an obstacle. Contacts push as they do in the plan:
/// along their normals unless tangential forces were planned.
TENDRIL_API Execution verify(const Scene& scene, const std::vector<std::unique_ptr<Obstacle>>& obstacles, Plan& plan,
                             const ExecuteControl& control = {});

/// execute() and verify() for a scene whose two fingers are both planned (plans_both_fingers()). Each finger is carried
/// out on its own, with the object held where it is. What is reached reads like a plan of both: the upper finger's
/// state, the lower one's in `grasp`, the worse of both certificates, snaps of both. Fingers that end up crossing are
/// `not_converged`: contact between them is not computed.

/// `held`: as of execute(), of the upper finger and then of the lower one, closing moments negative. `palm_distance`:
/// m. `control.start` may be a plan of one mirrored finger too. Throws as execute() does.
TENDRIL_API Execution execute_both_fingers(const Scene& scene, double palm_distance, const std::vector<double>& held,
                                           const ExecuteControl& control = {});

/// `control.start`: null or `&plan`: from the plan's own shape. `model_error` and `local_model_error` are the larger of
/// both fingers'.
TENDRIL_API Execution verify_both_fingers(const Scene& scene, Plan& plan, const ExecuteControl& control = {});

}  // namespace tendril
