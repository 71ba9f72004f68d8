#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tendril/backbone_point.hpp"
#include "tendril/geometry.hpp"
#include "tendril/nonlinear_program.hpp"
#include "tendril/options.hpp"
#include "tendril/scale.hpp"

namespace tendril {

// A scene as a user means it, in SI units, before anything is made dimensionless. Every field has the value that holds
// when the scene says nothing. Options of components stay raw: their schemas belong to the components.

/// What is asked for.
enum class ProblemKind { pose, trajectory, grasp, execute, estimate };
/// How contact is planned.
enum class ContactModeName { ignore, avoid, allow, require };
/// How far a search looks for a better plan.
enum class SearchEffort {
  fast,     ///< one start for each way of being in contact, as loops want it
  normal,   ///< starts on the sides of obstacles, and more where there is no plan
  thorough  ///< many times as many, whether or not there is a plan
};
TENDRIL_API std::string_view to_string(ProblemKind kind);      ///< The word that scenes use.
TENDRIL_API std::string_view to_string(ContactModeName mode);  ///< The word that scenes use.
TENDRIL_API std::string_view to_string(SearchEffort effort);   ///< The word that scenes use.

/// A stretch of the rod whose properties are polynomials of the arc length, most often constants.
struct SegmentSpec {
  double length = 0.0;             ///< m, > 0
  double bending_stiffness = 0.0;  ///< N m^2, > 0, where the segment begins
  double linear_density = 0.0;     ///< kg/m, >= 0, there
  double rest_curvature = 0.0;     ///< 1/m, there
  /// N m^2: coefficients of x, x^2, ..., x the share of the segment's length; empty: it does not change. All others
  /// likewise.
  std::vector<double> more_bending_stiffness{};
  std::vector<double> more_linear_density{};  ///< kg/m
  std::vector<double> more_rest_curvature{};  ///< 1/m
  double thickness = 0.0;                     ///< m, diameter of the body where the segment begins, >= 0
  std::vector<double> more_thickness{};       ///< m
  /// N m^2, > 0, where the segment begins; along it it goes with the bending stiffness. 0: not known.
  double torsional_stiffness = 0.0;
  double out_of_plane_stiffness = 0.0;  ///< N m^2, likewise, for bending out of the plane; 0: as in the plane
  double axial_stiffness = 0.0;         ///< N, where the segment begins; only CoordinatesSpec::stretch_order reads it
  std::vector<double> more_axial_stiffness{};  ///< N
};

/// From the least coordinates of something to the largest ones.
using LoadRange = std::pair<Vec2, Vec2>;

/// A dead load between two arc lengths of the rod, or at one of them where these are equal.
struct RodLoadSpec {
  double from = 0.0;  ///< m
  double to = 0.0;    ///< m
  Vec2 force{};       ///< N; between two arc lengths N/m
  double mass = 0.0;  ///< kg, >= 0, at one arc length only
  /// N, or N/m, as RodSpec::calibrated_tip_force: the force with the weight of the mass.
  std::optional<LoadRange> calibrated{};
};

/// What an actuator is told: a moment, the tension of a tendon, or a pressure.
enum class ActuatorKind { moment, tendon, pressure };
TENDRIL_API std::string_view to_string(ActuatorKind kind);  ///< The word that scenes use.

/// Where a tendon runs beside the backbone.
struct OffsetPoint {
  double arc_length = 0.0;  ///< m
  double offset = 0.0;      ///< m, positive: to the left
};

/// What bends the rod between two arc lengths, and its limits. Core knows moments only: that of a tendon is the tension
/// times its largest offset, or what a law has, and along the rod it goes with the offset.
struct TENDRIL_API ActuatorSpec {
  double from = 0.0;                         ///< m
  double to = 0.0;                           ///< m; the reader fills in the rod's length
  double minimum = -infinity;                ///< N m
  double maximum = infinity;                 ///< N m
  double moment_per_pressure = 0.0;          ///< N m / Pa, of a tendon's law N m / N of tension; 0: not given
  ActuatorKind kind = ActuatorKind::moment;  ///< as the scene has it
  std::vector<OffsetPoint> offset{};         ///< of a tendon, linear in between; one: the same all along
  /// A tendon is told its length, and its tension follows: what it is shorter by than along the straight rod of its own
  /// length. Slack, it is longer than its way along the rod.
  bool by_length = false;
  double least_shortening = -infinity;  ///< m, of such a tendon
  double most_shortening = infinity;    ///< m, likewise
  /// N m / Pa^2, N m / Pa^3, ...: what the moment has beyond the share that goes with the pressure. It rises, or falls,
  /// all the way between the two pressures; beyond them it goes on along its tangents. Empty: nothing. Likewise of
  /// tensions.
  std::vector<double> more_moment_per_pressure{};
  double least_pressure = -infinity;  ///< Pa, of a tendon N
  double most_pressure = infinity;    ///< Pa, of a tendon N
  /// N / Pa, N / Pa^2, ...: the axial force that comes with a pressure on a rod that stretches, positive if it makes it
  /// longer, likewise beyond the two pressures. Empty: none.
  std::vector<double> force_per_pressure{};
  /// What its rod was calibrated with, of what its kind is told (SI): beyond it nothing is known of the rod's numbers.
  double calibrated_from = -infinity;
  double calibrated_to = infinity;  ///< likewise

  /// What it is told: also a pressure if it is known what moment that gives.
  ActuatorKind input() const;
  /// Of what it is told.
  Dimension input_dimension() const;
  /// Of the tension, pressure or moment itself.
  Dimension effort_dimension() const;
  /// The offset of largest size, m.
  double largest_offset() const;
  /// Whether it is known what moment a pressure gives, or a tension beside what its offset says.
  bool has_law() const { return moment_per_pressure != 0.0 || !more_moment_per_pressure.empty(); }
  bool knows_pressure() const { return kind != ActuatorKind::tendon && has_law(); }  ///< Of a pressure.
  double moment_of(double input) const;  ///< N m, under a pressure, a tension or a moment.
  /// The axial force (N) that comes with a moment (N m), and its derivatives by it.
  struct Pull {
    double force = 0.0;  ///< N
    double slope = 0.0;  ///< 1/m
    double bend = 0.0;   ///< 1/(N m^2)
  };
  Pull pull_of(double moment) const;     ///< Of a pressure; no force where none is given.
  bool pulls_in_proportion() const;      ///< Whether that force goes with the moment.
  double input_of(double moment) const;  ///< Pressure, tension or moment under a moment.
  /// How the moment goes with a number of its law while its input is held.
  struct Gain {
    double rate = 0.0;   ///< N m per SI unit of the number
    double slope = 0.0;  ///< its derivative by the moment
  };
  /// `power`: of the pressure, whose coefficient the number is; 0: it is the offset of a tendon that has one all along.
  /// Nothing for another number.
  std::optional<Gain> gain_of(int power, double moment) const;
  /// What execute() holds where it has this moment (N m) and this turn (Plan::turns): the moment, or of a tendon told
  /// its length its shortening (m).
  double held(double moment, double turn) const { return by_length ? turn * largest_offset() : moment; }
  /// What its kind is told under this moment (N m) and this turn (Plan::turns): moment, pressure, tension or
  /// shortening.
  double told(double moment, double turn) const {
    return by_length ? held(moment, turn) : kind == ActuatorKind::moment ? moment : input_of(moment);
  }
};

/// N m by which `moment` exceeds the limits of `actuator`; negative: its distance to the nearer one.
TENDRIL_API double excess(const ActuatorSpec& actuator, double moment);

/// The rod: its segments from the base on, what bends it, and where it is clamped.
struct TENDRIL_API RodSpec {
  std::vector<SegmentSpec> segments;    ///< at least one; a uniform rod has one
  std::vector<ActuatorSpec> actuators;  ///< what bends it; may be empty
  std::vector<RodLoadSpec> loads;       ///< what pulls at it between base and tip; may be empty
  Vec2 base_position{};                 ///< m
  double base_angle = 0.0;              ///< rad
  /// m: where the base may be moved to, from the least to the largest coordinates; absent: it stands still.
  std::optional<std::pair<Vec2, Vec2>> base_position_range{};
  std::optional<std::pair<double, double>> base_angle_range{};  ///< rad, likewise
  double most_drawn_in = 0.0;  ///< m of it that may be drawn into a port at the base, where they are straight
  double drawn_in = 0.0;       ///< m of it where searches begin
  /// What it was calibrated with, along the rod's direction at its base and to the left of that: beyond it nothing is
  /// known of its numbers. Absent: not known. m/s^2.
  std::optional<LoadRange> calibrated_gravity{};
  std::optional<LoadRange> calibrated_tip_force{};  ///< N, likewise, with the weight of a mass there
  double length() const;                            ///< Sum over the segments, m.
  BodyRadius body() const;                          ///< Around its backbone; empty: it has none. Refers to this rod.
};

/// The last `length` (m) of a rod, all that is out of its port: what lies before is without effect. Throws SceneError
/// for a length that it has not, and for an actuator that is all inside.
TENDRIL_API RodSpec out_of_port(const RodSpec& rod, double length);

/// What hangs at the tip.
struct TipLoadSpec {
  double mass = 0.0;  ///< kg
  Vec2 force{};       ///< N, dead
};

/// Where an obstacle is, seen from where the options of its shape put it.
struct ObstaclePlace {
  double turn = 0.0;  ///< rad, about its pivot
  Vec2 shift{};       ///< m, after that
  /// Whether it is anywhere else.
  bool moves() const { return turn != 0.0 || shift.x != 0.0 || shift.y != 0.0; }
};

/// An obstacle: its shape by name, and the options of that shape.
struct ObstacleSpec {
  std::string name;      ///< "obstacle 1", ... if not given
  std::string shape;     ///< an obstacle component
  RawOptions options{};  ///< of the shape, not checked yet
  /// Coefficient of friction of its contacts; absent: that of ContactSpec.
  std::optional<double> friction{};
  ObstaclePlace place{};  ///< where it is instead
};

/// What becomes of the unknown state of friction (docs/model.md section 11).
enum class FrictionState {
  range,  ///< planned without, then followed over the cone of every contact
  any,    ///< tangential forces are planned, anywhere in their cones
  none,   ///< left out
  worst   ///< planned for the state within the cones that costs most, then followed as above
};

/// How contact with obstacles is planned.
struct ContactSpec {
  /// whether contact is planned, kept away from, or not looked at
  ContactModeName mode = ContactModeName::allow;
  double min_force = 0.0;                    ///< N
  double max_force = infinity;               ///< N; 0 means avoid
  int count = 1;                             ///< contacts at most
  Treatment treatment = Treatment::penalty;  ///< of complementarity
  double beta = 1.0;                         ///< first penalty weight, dimensionless
  int check_points = 0;                      ///< fixed number, without exchange; 0: core chooses and exchanges
  double friction = 0.0;                     ///< coefficient, of obstacles that have none of their own
  FrictionState friction_state = FrictionState::range;  ///< what is looked at
};

/// Where an obstacle of a scene is at a step of a trajectory.
struct MovedObstacle {
  int obstacle = 0;       ///< index in the scene
  ObstaclePlace place{};  ///< where it is then
};

/// The pose that the tip should have; either part may be absent.
struct TargetSpec {
  std::optional<Vec2> position;  ///< m
  std::optional<double> angle;   ///< rad; a direction, so that full turns do not count
  /// Full turns of the tip against the base's direction, beyond the half turn at most that leads to `angle`; absent:
  /// whatever suits.
  std::optional<int> turns{};
  double position_tolerance = infinity;  ///< m; how far the tip may be from `position`
  double angle_tolerance = infinity;     ///< rad; and from `angle`
  /// Of a step of a trajectory: the obstacles that move. Whoever plans the step makes the problem with them there.
  std::vector<MovedObstacle> obstacles{};
};

/// Targets in order; for the problem kind "trajectory".
struct TrajectorySpec {
  std::vector<TargetSpec> targets;  ///< at least one
  int replan_every = 0;             ///< steps between full plans; 0: only where needed
  bool cold_starts = false;         ///< plan every target from the scene's own start too, to compare
};

/// A term of the objective by name, its weight, and its options.
struct ObjectiveSpec {
  std::string plugin;         ///< an objective component
  double weight = 1.0;        ///< dimensionless, >= 0; 0 leaves the term out
  RawOptions options{};       ///< of the component, not checked yet
  SourcePosition position{};  ///< for messages
};

/// The coordinate model by name, and its options.
struct CoordinatesSpec {
  std::string plugin;            ///< whoever makes the scene names one; core knows none
  bool split_at_contact = true;  ///< each interior contact gets a knot of its own
  int stretch_order = 0;         ///< Legendre coefficients of the rod's stretch per piece; 0: it does not stretch
  RawOptions options{};          ///< of the component, not checked yet
  SourcePosition position{};     ///< for messages
};

/// The solver by name, what is asked of it, and its own options.
struct SolverSpec {
  std::string plugin;         ///< likewise
  double tolerance = 1e-9;    ///< on feasibility and stationarity, dimensionless
  double time_limit = 10.0;   ///< s
  int max_iterations = 500;   ///< of one solve
  RawOptions options{};       ///< native names
  SourcePosition position{};  ///< for messages
};

/// A point of the backbone that was measured.
struct MeasuredPoint {
  double arc_length = 0.0;  ///< m
  Vec2 position{};          ///< m
};

/// What was measured of a rod in contact with unknown obstacles.
struct MeasurementSpec {
  std::vector<MeasuredPoint> points;  ///< where the backbone was seen
  double noise = 0.0;                 ///< m, standard deviation of each coordinate; 0: not known
  std::vector<double> moments;        ///< N m, one per actuator; empty: not given
  bool equal_spacing = false;         ///< arc lengths were not measured: the points are taken to be equally far apart
};

/// Something that a scene could have needed and did not.
struct LeftOut {
  std::string what;  ///< what is not there
  std::string why;   ///< a reason for a user
};

/// Which fingers of a grasp are planned.
enum class Fingers {
  as_needed,  ///< both if one mirrored finger cannot stand for the two: they differ, or gravity acts across the axis
  mirrored,   ///< one; the other is its mirror image
  both        ///< each on its own
};

/// A finger that is not like the other one. Everything is said as of an upper finger: of the lower one it is the mirror
/// image that is described.
struct FingerSpec {
  RodSpec rod;                ///< instead of the scene's, without its place
  double finger_angle = 0.0;  ///< rad, of its base against the axis, as GripperSpec::finger_angle
  std::optional<std::pair<double, double>> finger_angle_range{};  ///< rad, as GripperSpec::finger_angle_range
  double min_force = 0.0;                                         ///< N, of its contact
  double max_force = infinity;                                    ///< N, of its contact
};

/// Two fingers on a palm and the round object between them (docs/model.md section 6, "grasp").
struct GripperSpec {
  double half_palm = 0.0;     ///< m, from the axis of symmetry to the base of either finger
  double finger_angle = 0.0;  ///< rad, of the upper finger's base against the axis; the lower is mirrored
  /// m: between which a plan may move the base of either finger across the axis, each by itself; absent: it stands.
  std::optional<std::pair<double, double>> half_palm_range{};
  /// rad: between which a plan may turn the base of either finger, each by itself; absent: it does not turn.
  std::optional<std::pair<double, double>> finger_angle_range{};
  double object_diameter = 0.0;         ///< m
  double object_mass = 0.0;             ///< kg, >= 0; weighs where the scene has gravity
  Vec2 object_force{};                  ///< N, dead, on the object's centre, in the world
  std::optional<double> palm_distance;  ///< m, from the palm to the object's centre, if it is fixed
  std::optional<std::pair<double, double>> palm_distance_range;  ///< m; neither: free
  Vec2 position{};                                               ///< m, the palm's middle
  double angle = 0.0;                                            ///< rad, direction of the axis, away from the palm
  bool exact_balance = true;             ///< no net force on the object, as a constraint; else an objective sees to it
  Fingers fingers = Fingers::as_needed;  ///< which of them are planned
};

/// A unit that a scene is written in.
struct WrittenUnit {
  std::string name;   ///< as the scene writes it
  double size = 1.0;  ///< SI
};

/// A number that is known to a standard deviation only. It moves numbers of scene_numbers(), most often
/// one.
struct Spread {
  std::string key;         ///< path in the scene file
  double deviation = 0.0;  ///< standard deviation, SI
  /// A number that it moves.
  struct Part {
    std::string key;    ///< of scene_numbers()
    double rate = 1.0;  ///< of that number by this one, SI
  };
  std::vector<Part> parts{};  ///< most often one
  /// Of the law by which an actuator's moment follows what it is told: under held inputs it moves the moment, too.
  struct Law {
    std::size_t actuator = 0;  ///< of the scene
    int power = 0;             ///< as ActuatorSpec::gain_of() takes it
  };
  std::optional<Law> law{};  ///< absent: it is in none
  /// Its correlations with others, by their keys, said of both of them; of those that are not named 0.
  std::map<std::string, double, std::less<>> correlations{};
};

/// Everything that a scene file says.
struct Scene {
  std::string file;                         ///< as named by the user; empty if made in code
  std::string title;                        ///< for reports
  ProblemKind problem = ProblemKind::pose;  ///< what is asked for
  std::optional<Vec2> gravity;              ///< m/s^2
  RodSpec rod;                              ///< the rod, from the base on
  CoordinatesSpec coordinates;              ///< how its shape is described
  double start_tip_angle = 0.0;             ///< rad, of a constant-curvature start
  std::vector<Vec2> start_points{};         ///< m, instead: along the start from the base on, the last one its tip
  std::vector<ObstacleSpec> obstacles;      ///< in the order of the file
  ContactSpec contact;                      ///< how contact is planned
  TipLoadSpec tip_load;                     ///< at the tip
  TargetSpec target;                        ///< of the tip; may be empty
  MeasurementSpec measurement;              ///< for an estimate
  TrajectorySpec trajectory;                ///< for a trajectory
  std::optional<GripperSpec> gripper;       ///< for a grasp
  std::vector<FingerSpec> fingers;          ///< of a grasp: none (both are like `rod`), or the upper and the lower one
  std::vector<ObjectiveSpec> objectives;    ///< their sum is minimized
  std::vector<Spread> spreads;              ///< numbers with error bars, for objectives that read these
  SolverSpec solver;                        ///< who solves the programs
  SearchEffort effort = SearchEffort::normal;  ///< how far is looked for a better plan
  bool guided_in_plane = false;                ///< the robot cannot leave its plane, whatever its torsion
  QuantityReader read_quantity;                ///< for numbers with units inside raw options; may be empty
  std::vector<LeftOut> left_out;               ///< what its files hold beyond this, and why it is not read
  std::vector<std::string> warnings;           ///< what its reader would ask about
  /// The units that the file uses most, by the SI unit of the dimension ("m", "N m"); for reports. May be empty.
  std::map<std::string, WrittenUnit, std::less<>> units;
};

/// Which of a scene's components have to be opened at all (a weight of 0 opens nothing).
TENDRIL_API bool needs_term(const ObjectiveSpec& objective);
/// Whether the obstacles have to be made: not with contact mode "ignore".
TENDRIL_API bool needs_obstacles(const Scene& scene);

/// The coefficient of friction of obstacle `i`; 0 where friction is left out.
TENDRIL_API double friction_of(const Scene& scene, std::size_t i);

/// Refuses a scene that makes no sense (lengths, limits, ranges). Throws SceneError with the key's path. Call it before
/// anything else.
TENDRIL_API void validate(const Scene& scene);

/// The scale of a valid scene: L and EI at the base.
TENDRIL_API Scale scale_of(const Scene& scene);

}  // namespace tendril
