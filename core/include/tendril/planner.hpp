#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "tendril/coordinate_model.hpp"
#include "tendril/objective_term.hpp"
#include "tendril/obstacle.hpp"
#include "tendril/plan.hpp"
#include "tendril/scale.hpp"
#include "tendril/scene.hpp"
#include "tendril/solver.hpp"

namespace tendril {

/// The components that a scene names, made by whoever can load them. Order as in the scene.
struct Components {
  std::unique_ptr<CoordinateModel> coordinates;       ///< never null
  std::vector<std::unique_ptr<Obstacle>> obstacles;   ///< all of them, or none if needs_obstacles() is false
  std::vector<std::unique_ptr<ObjectiveTerm>> terms;  ///< one per objective of the scene; null where its weight is 0
  std::unique_ptr<Solver> solver;                     ///< never null
};

/// Which of a scene's components have to be opened at all (a weight of 0 opens nothing).
TENDRIL_API bool needs_term(const ObjectiveSpec& objective);
/// Whether the obstacles have to be made: not with contact mode "ignore".
TENDRIL_API bool needs_obstacles(const Scene& scene);

/// Refuses a scene that makes no sense (lengths, limits, ranges). Throws SceneError with the key's path. Call it before
/// anything else.
TENDRIL_API void validate(const Scene& scene);

/// The scale of a valid scene: L and the first segment's EI.
TENDRIL_API Scale scale_of(const Scene& scene);

/// What was built and what was left out, for `describe`.
struct Description {
  /// How many variables or rows of one name there are.
  struct Count {
    std::string name;    ///< as in results
    int count = 0;       ///< how many
    std::string kind{};  ///< rows: "equality" or "inequality"
  };
  /// The program of one way of being in contact.
  struct Mode {
    std::string name;              ///< as in ModeRecord
    std::vector<Count> variables;  ///< by name
    std::vector<Count> rows;       ///< by name
  };
  std::vector<Count> variables;       ///< of the largest mode
  std::vector<Count> rows;            ///< of the largest mode
  std::vector<std::string> terms;     ///< objective terms that count
  std::vector<std::string> energies;  ///< "bending", "gravity", ...
  std::vector<Mode> modes;            ///< the small programs, one per way of being in contact
  std::vector<LeftOut> left_out;      ///< and why
  double length_unit = 0.0;           ///< L, m
  double force_unit = 0.0;            ///< EI0/L^2, N
};

/// What a plan starts from and what may end it.
struct PlanControl {
  /// set to true from outside to end planning cleanly; null: nothing does
  const std::atomic<bool>* stop = nullptr;
  const Plan* start = nullptr;  ///< warm start: shape, moments and contacts of an earlier plan
  /// Try Newton on the earlier plan's active set first. If that is certified and no contact is about to come or go, no
  /// solver is called.
  bool follow = false;
  std::vector<std::string> without{};  ///< ways of being in contact (ModeRecord::mode) that are not tried
};

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
  /// follow; for loops at a steady rate. Where Newton on the plan's own active set is certified no solver is called,
  /// and from the second such step in a row nothing is allocated as long as the active set stays; otherwise everything
  /// is planned. `stop` as in PlanControl.
  void follow(const TargetSpec& target, Plan& plan, const std::atomic<bool>* stop = nullptr);

  struct Data;  ///< core's own

 private:
  bool follow_without_solver(Plan& plan);

  std::unique_ptr<Data> data_;
};

}  // namespace tendril
