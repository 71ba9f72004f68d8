#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tendril/backbone_point.hpp"
#include "tendril/certificate.hpp"
#include "tendril/geometry.hpp"
#include "tendril/scene.hpp"
#include "tendril/solver.hpp"

namespace tendril {

/// How a plan ended.
enum class PlanStatus { solved, infeasible, unstable, not_converged, diverged, time_limit, interrupted, failed };
TENDRIL_API std::string_view to_string(PlanStatus status);  ///< The status as results write it.

/// A contact of a plan, SI units.
struct PlannedContact {
  int obstacle = 0;           ///< index in the scene
  std::string obstacle_name;  ///< as the scene names it
  bool at_tip = false;        ///< at the rod's end; else inside
  double arc_length = 0.0;    ///< m
  Vec2 point{};               ///< m
  Vec2 normal{};              ///< unit vector out of the obstacle
  double force = 0.0;         ///< N, along the normal
  double gap = 0.0;           ///< m
  /// The rod lies along the obstacle here: one of a run of contacts that stands for the stretch, or, in a plan that is
  /// not solved for that reason, the point whose force would be spread.
  bool extended = false;
  Vec2 tangent{};           ///< unit vector across the normal, in the direction in which arc lengths grow
  double tangential = 0.0;  ///< N, along the tangent
  bool sticks = false;      ///< it does not slip, whatever is tangential
};

/// One program that the planner solved, and how it ended.
struct ModeRecord {
  std::string mode;              ///< "no contact", "interior contact with 'peg' on segment 1", "tip contact with 'peg'"
  std::string outcome;           ///< "certified, objective 0.0123", "skipped: out of reach", ...
  int solves = 0;                ///< runs of the solver
  int polishes = 0;              ///< runs of Newton on an active set
  int iterations = 0;            ///< of the solver, over all solves
  std::int64_t evaluations = 0;  ///< of values inside the solves
  double seconds = 0.0;          ///< wall time spent on this mode, certificate included
  double seconds_evaluating = 0.0;  ///< of it, inside the program while a solver ran
  bool certified = false;           ///< its best point passed the certificate
  double objective = infinity;      ///< dimensionless, of the best point found
};

/// A certified plan that the search came to.
struct PlanMinimum {
  std::string mode;  ///< as in ModeRecord
  /// On which side each obstacle lies, seen along the rod: "left", "right", or "ahead" where the rod ends before it;
  /// empty for one that has no sides, as a wall, or is out of reach.
  std::vector<std::string> sides;
  double objective = 0.0;       ///< dimensionless
  std::vector<double> moments;  ///< N m, one per actuator
};

/// What was seen of the stable equilibria over the box of moments that can be chosen (one or two of them): evidence to
/// a resolution, no proof.
struct PlanScan {
  std::vector<double> steps;  ///< N m, between neighbouring moments, one per actuator that can be chosen
  int equilibria = 0;         ///< that were met
  int lost = 0;               ///< ways to neighbouring moments that could not be followed to their end
  int unresolved = 0;         ///< equilibria that cost less than the plan, and led to none
  bool whole = true;          ///< the search was not over before
  /// No equilibrium that was met leads to a better plan.
  bool complete() const { return whole && lost == 0 && unresolved == 0; }
};

/// What a small error does to a grasp at held moments. NaN: the equilibrium has no derivative there.
struct GraspQuality {
  /// N/m: force that drives the object back, per distance that it is moved along the axis (negative: it drives it on),
  /// and across it.
  double axial_stiffness = 0.0;    ///< N/m
  double lateral_stiffness = 0.0;  ///< N/m
  /// N, for each actuator of the upper finger: change of the force on the object (along the axis, across it) if that
  /// moment alone is 1 % larger. Where both fingers are planned those of the lower one follow.
  std::vector<Vec2> force_by_moment;
  std::vector<double> force_margins;  ///< N, distance of each contact force to its limit; of the lower finger as above
};

/// What friction does for a grasp: the disturbances of the object that its contacts can hold where they are, whatever
/// the state of their friction. Fingers are rigid: contact forces may be any within their cones and limits.
struct GraspHold {
  double friction = 0.0;          ///< coefficient
  double closure_friction = 0.0;  ///< above it contacts at these places hold any disturbance if pressed hard enough
  bool closure = false;           ///< the coefficient is above it
  /// N, in the world: corners, in order, of the forces on the object's centre that are held beside the object's own
  /// load. Empty where contact forces have no limit, and where that load alone is not held.
  std::vector<Vec2> held_forces;
  Vec2 breaking_force{};        ///< N, the smallest force that breaks the hold: a contact slips, leaves, or gives way
  double least_moment = 0.0;    ///< N m, about the object's centre, held without such a force
  double largest_moment = 0.0;  ///< N m, likewise
};

/// Where a rod is clamped.
struct BasePose {
  Vec2 position{};     ///< m
  double angle = 0.0;  ///< rad
};

/// Where a rod was moved to as a whole. Arc lengths count along the rod as it is where it is out of its port farthest.
struct RodPlace {
  std::optional<double> insertion{};  ///< m of it that are out of its port; absent: it is not drawn in or out
  std::optional<BasePose> base{};     ///< absent: its base does not move
};

/// The lower finger of a grasp where it is planned on its own, in the world.
struct FingerPlan {
  std::vector<double> coordinates;  ///< dimensionless, of the finger's mirror image
  /// N m, one per actuator. Like their limits those of the mirror image: a closing moment is negative for both fingers.
  std::vector<double> moments;
  std::vector<PlannedContact> contacts;  ///< all planned ones
  std::vector<BackbonePoint> backbone;   ///< from the base on
  double tip_x = 0.0;                    ///< m
  double tip_y = 0.0;                    ///< m
  double tip_angle = 0.0;                ///< rad
  /// As Plan::self_overlap.
  std::optional<std::pair<double, double>> self_overlap;
  std::vector<double> turns{};  ///< As Plan::turns.
  RodPlace place{};             ///< of its base, where that may be moved
};

/// What only a grasp has. The plan's rod and contacts are those of the upper finger.
struct GraspPlan {
  std::optional<FingerPlan> lower;      ///< none: the lower finger is the mirror image of the upper one
  double palm_distance = 0.0;           ///< m
  Vec2 object_center{};                 ///< m
  double object_radius = 0.0;           ///< m
  Vec2 load{};                          ///< N, on the object: its weight, and the force that the scene gives
  Vec2 net_force{};                     ///< N, of both fingers on the object
  double axial_force = 0.0;             ///< N, the same along the axis; positive: away from the palm
  double lateral_force = 0.0;           ///< N, with which each finger presses across the axis; the mean of both
  std::optional<GraspQuality> quality;  ///< of plans; an execution has none
  std::optional<GraspHold> hold;        ///< of solved plans, where contacts have friction
};

/// Where a plan's moments hold the rod if contacts push so far off their normals. SI units.
struct FrictionRange {
  /// Tangential force for each unit of the normal one, per contact of the plan; 0 for those without force.
  std::vector<double> ratios;
  double tip_x = 0.0;                    ///< m
  double tip_y = 0.0;                    ///< m
  double tip_angle = 0.0;                ///< rad
  std::optional<double> target_error;    ///< m
  double stability = 0.0;                ///< margin; under friction of slipping contacts
  std::vector<PlannedContact> contacts;  ///< the active ones
};

/// A plan in SI units, except where said.
struct Plan {
  PlanStatus status = PlanStatus::failed;  ///< how it ended
  std::string message;                     ///< why it is not solved; empty if it is
  bool search_cut = false;                 ///< time ended the search before it was done: a better plan may exist
  std::string coordinates_name;            ///< the coordinate model
  int order = 0;                           ///< functions per piece
  bool split_at_contact = false;           ///< interior contacts have knots of their own
  std::vector<double> coordinates;         ///< dimensionless
  std::vector<double> moments;             ///< N m, one per actuator of the scene
  /// int p kappa ds along each actuator (rad), of a tendon less int eps ds over its largest offset: a tendon is shorter
  /// by this times that offset.
  std::vector<double> turns;
  RodPlace place{};                    ///< of what may be moved of the rod
  double tip_x = 0.0;                  ///< m
  double tip_y = 0.0;                  ///< m
  double tip_angle = 0.0;              ///< rad
  std::optional<double> target_error;  ///< m
  /// Distance of the tip to where executing the moments takes it (verify() in execute.hpp), m, loaded from the start.
  std::optional<double> model_error;
  /// The same, settled from the plan's own shape, m.
  std::optional<double> local_model_error;
  std::string verification;  ///< what execution found, in words; empty: not asked for
  /// Without friction, then for every state of contacts that are about to slip; empty: there is no friction.
  std::vector<FrictionRange> friction;
  std::optional<GraspPlan> grasp;                     ///< of a grasp
  double objective = 0.0;                             ///< dimensionless, without penalty
  std::vector<std::pair<std::string, double>> terms;  ///< weighted, dimensionless; they sum to the objective
  std::vector<PlannedContact> contacts;               ///< all planned ones, with force or without
  Certificate certificate;                            ///< of the coordinates above
  std::string solver_name;                            ///< the backend
  OptimalityReport solver;  ///< of the winning mode's last solve; iterations and evaluations are sums over all modes
  EvaluationCounts evaluations;         ///< of all programs: by solvers, polishes and restorations
  std::vector<ModeRecord> modes;        ///< every program that was looked at
  std::optional<PlanScan> scan;         ///< of all equilibria, where the search made one
  std::vector<PlanMinimum> minima;      ///< the distinct ones that were found, best first; none of two planned fingers
  std::vector<std::string> notes;       ///< what a reader should know first, in words
  std::vector<LeftOut> left_out;        ///< what the scene could have needed and did not
  std::vector<BackbonePoint> backbone;  ///< of the plan, from the base on
  /// of the shape that the search started from; empty for a grasp
  std::vector<BackbonePoint> start_backbone;
  /// Arc lengths (m) at which the rod first crosses or covers itself, which the model does not forbid (self_overlap()).
  std::optional<std::pair<double, double>> self_overlap;
  double seconds_assemble = 0.0;  ///< wall time to make the problem
  double seconds_solve = 0.0;     ///< of everything after that but the certificates
  double seconds_certify = 0.0;   ///< of the certificates
};

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

/// What a plan starts from and what may end it.
struct PlanControl {
  /// set to true from outside to end planning cleanly; null: nothing does
  const std::atomic<bool>* stop = nullptr;
  const Plan* start = nullptr;  ///< warm start: shape, moments and contacts of an earlier plan
  /// Try Newton on the earlier plan's active set first. If that is certified and no contact is about to come or go, no
  /// solver is called.
  bool follow = false;
  std::vector<std::string> without{};  ///< ways of being in contact (ModeRecord::mode) that are not tried
  /// Called by the thread that plans after every run of the solver, or of Newton's method instead; must not throw.
  std::function<void()> progress{};
};

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

}  // namespace tendril
