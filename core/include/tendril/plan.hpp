#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tendril/geometry.hpp"
#include "tendril/solver.hpp"

namespace tendril {

/// How a plan ended.
enum class PlanStatus { solved, infeasible, unstable, not_converged, diverged, time_limit, interrupted, failed };
TENDRIL_API std::string_view to_string(PlanStatus status);  ///< The status as results write it.

/// Quality of a plan, judged without asking the solver (model.md section 7). Everything dimensionless; each number is
/// the size of a defect except stability (a margin) and d_ss.
struct Certificate {
  double equilibrium = infinity;      ///< largest residual of the equilibrium rows
  double bounds = infinity;           ///< largest excess over a limit of a variable
  double penetration = infinity;      ///< certified depth: the true one is not larger
  double complementarity = infinity;  ///< largest min(g, f)
  double closest_point = infinity;    ///< largest tangent . normal at a contact
  double balance = infinity;          ///< force along a grasp's axis that one finger leaves; 0 where none is asked for
  double stationarity = infinity;     ///< gradient of the Lagrangian of the tightened program
  std::string stationarity_kind = "none";  ///< "S", "M", "C" or "none"
  double moment_balance = infinity;        ///< strong form: a direct measure of model error
  double stability = -infinity;            ///< margin mu
  double contact_convexity = infinity;     ///< smallest d_ss of interior contacts with force; infinity: none
  double quadrature = infinity;            ///< largest change of any row when the rule is doubled
  /// One line for each requirement that is not met; empty: certified.
  std::vector<std::string> failures{"no point was judged"};
  /// Every requirement is met.
  bool valid() const { return failures.empty(); }
};

/// A contact of a plan, SI units.
struct PlannedContact {
  int obstacle = 0;           ///< index in the scene
  std::string obstacle_name;  ///< as the scene names it
  bool at_tip = false;        ///< at the rod's end; else inside
  double arc_length = 0.0;    ///< m
  Vec2 point{};               ///< m
  Vec2 normal{};              ///< unit vector out of the obstacle
  double force = 0.0;         ///< N
  double gap = 0.0;           ///< m
  /// The rod lies along the obstacle here: one of a run of contacts that stands for the stretch, or, in a plan that is
  /// not solved for that reason, the point whose force would be spread.
  bool extended = false;
};

/// s (m), x, y (m), angle (rad), curvature (1/m).
using BackbonePoint = std::array<double, 5>;

/// Something that a scene could have needed and did not.
struct LeftOut {
  std::string what;  ///< what is not there
  std::string why;   ///< a reason for a user
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
};

/// What only a grasp has. The plan's rod and contacts are those of the upper finger.
struct GraspPlan {
  std::optional<FingerPlan> lower;      ///< none: the lower finger is the mirror image of the upper one
  double palm_distance = 0.0;           ///< m
  Vec2 object_center{};                 ///< m
  double object_radius = 0.0;           ///< m
  Vec2 net_force{};                     ///< N, of both fingers on the object
  double axial_force = 0.0;             ///< N, the same along the axis; positive: away from the palm
  double lateral_force = 0.0;           ///< N, with which each finger presses across the axis; the mean of both
  std::optional<GraspQuality> quality;  ///< of plans; an execution has none
};

/// A plan in SI units, except where said.
struct Plan {
  PlanStatus status = PlanStatus::failed;  ///< how it ended
  std::string message;                     ///< why it is not solved; empty if it is
  std::string coordinates_name;            ///< the coordinate model
  int order = 0;                           ///< functions per piece
  bool split_at_contact = false;           ///< interior contacts have knots of their own
  std::vector<double> coordinates;         ///< dimensionless
  std::vector<double> moments;             ///< N m, one per actuator of the scene
  double tip_x = 0.0;                      ///< m
  double tip_y = 0.0;                      ///< m
  double tip_angle = 0.0;                  ///< rad
  std::optional<double> target_error;      ///< m
  /// Distance of the tip to where executing the moments takes it (verify() in execute.hpp), m, loaded from the start.
  std::optional<double> model_error;
  /// The same, settled from the plan's own shape, m.
  std::optional<double> local_model_error;
  std::string verification;                           ///< what execution found, in words; empty: not asked for
  std::optional<GraspPlan> grasp;                     ///< of a grasp
  double objective = 0.0;                             ///< dimensionless, without penalty
  std::vector<std::pair<std::string, double>> terms;  ///< weighted, dimensionless; they sum to the objective
  std::vector<PlannedContact> contacts;               ///< all planned ones, with force or without
  Certificate certificate;                            ///< of the coordinates above
  std::string solver_name;                            ///< the backend
  OptimalityReport solver;  ///< of the winning mode's last solve; iterations and evaluations are sums over all modes
  EvaluationCounts evaluations;         ///< of all programs: by solvers, polishes and restorations
  std::vector<ModeRecord> modes;        ///< every program that was looked at
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

}  // namespace tendril
