#include "tendril/app/scene_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "keys.hpp"
#include "measurement_reader.hpp"
#include "tendril/app/input_error.hpp"

namespace tendril::app {

namespace {

/// What a scene plans with if it names no plugin; core itself knows none.
constexpr const char* default_coordinates = "legendre";
constexpr const char* default_solver = "nlopt";

// What a scene says before defaults that depend on other keys are filled in.

struct ActuatorDraft {
  std::optional<double> from, to, limit, minimum, maximum, smallest_pressure, largest_pressure;
  double moment_per_pressure = 0.0;
  SourcePosition position{};
};

struct RodDraft {
  std::optional<double> length, bending_stiffness, linear_density, rest_curvature;
  std::vector<SegmentSpec> segments;
  std::vector<ActuatorDraft> actuators;
  Vec2 base_position{};
  double base_angle = 0.0;
};

/// What one finger of a grasp states; the rest is that of [rod], [contact] and [gripper].
struct FingerDraft : RodDraft {
  std::optional<double> angle, min_force, max_force;
};

struct TrajectoryDraft {
  std::vector<Vec2> positions;
  std::vector<double> angles;
};

struct SceneDraft {
  Scene scene;
  RodDraft rod;
  std::vector<FingerDraft> fingers;
  MeasurementDraft measurement;
  TrajectoryDraft trajectory;
  std::optional<StudySpec> study;
};

Table<SegmentSpec> segment_table() {
  using T = SegmentSpec;
  return {{quantity<T>(
               "length", dimension::length, positive, "", "Length of the segment.",
               [](T& t, double v) { t.length = v; }, Need::required),
           quantity<T>(
               "bending_stiffness", dimension::stiffness, positive, "", "Bending stiffness EI of the segment.",
               [](T& t, double v) { t.bending_stiffness = v; }, Need::required),
           quantity<T>("linear_density", dimension::linear_density, not_negative, "0",
                       "Mass per length; without it gravity does not act on the segment.",
                       [](T& t, double v) { t.linear_density = v; }),
           quantity<T>("rest_curvature", dimension::curvature, any, "0", "Curvature of the unloaded segment.",
                       [](T& t, double v) { t.rest_curvature = v; })}};
}

Table<ActuatorDraft> actuator_table() {
  using T = ActuatorDraft;
  return {
      {quantity<T>("from", dimension::length, not_negative, "0", "Arc length at which the actuator begins.",
                   [](T& t, double v) { t.from = v; }),
       quantity<T>("to", dimension::length, not_negative, "the rod's length", "Arc length at which the actuator ends.",
                   [](T& t, double v) { t.to = v; }),
       quantity<T>("limit", dimension::moment, not_negative, "no limit",
                   "Largest moment in either direction; instead of min and max. 0 removes the actuator.",
                   [](T& t, double v) { t.limit = v; }),
       quantity<T>("min", dimension::moment, any, "no limit", "Smallest moment (positive moments bend to the left).",
                   [](T& t, double v) { t.minimum = v; }),
       quantity<T>("max", dimension::moment, any, "no limit", "Largest moment.", [](T& t, double v) { t.maximum = v; }),
       quantity<T>("moment_per_pressure", dimension::moment_per_pressure, any, "",
                   "Moment that a unit of pressure gives; negative if pressure bends to the right.",
                   [](T& t, double v) { t.moment_per_pressure = v; }),
       quantity<T>("min_pressure", dimension::pressure, any, "no limit",
                   "Smallest pressure; with moment_per_pressure, instead of limits of the moment.",
                   [](T& t, double v) { t.smallest_pressure = v; }),
       quantity<T>("max_pressure", dimension::pressure, any, "no limit", "Largest pressure.",
                   [](T& t, double v) { t.largest_pressure = v; })}};
}

/// What a rod is made of, in the table at `path`. `unstated`: where values come from that are not given; empty:
/// defaults.
template <class T>
std::vector<Key<T>> rod_keys(const std::string& path, const std::string& unstated = "") {
  const std::string zero = unstated.empty() ? "0" : unstated;
  return {
      quantity<T>("length", dimension::length, positive, unstated, "Length of a uniform rod.",
                  [](T& t, double v) { t.length = v; }),
      quantity<T>("bending_stiffness", dimension::stiffness, positive, unstated,
                  "Bending stiffness EI of a uniform rod.", [](T& t, double v) { t.bending_stiffness = v; }),
      quantity<T>("linear_density", dimension::linear_density, not_negative, zero, "Mass per length of a uniform rod.",
                  [](T& t, double v) { t.linear_density = v; }),
      quantity<T>("rest_curvature", dimension::curvature, any, zero, "Curvature of an unloaded uniform rod.",
                  [](T& t, double v) { t.rest_curvature = v; }),
      tables<T>(
          "segment", path + ".segment", "A rod of several segments, from the base on; instead of the uniform values.",
          segment_table(), [](T & t) -> auto& { return t.segments; }),
      tables<T>(
          "actuator", path + ".actuator", "A moment between two arc lengths.", actuator_table(),
          [](T & t) -> auto& { return t.actuators; })};
}

Table<RodDraft> rod_table() {
  using T = RodDraft;
  Table<RodDraft> base{
      {point<T>("position", dimension::length, "[0, 0]", "Where the rod is clamped.",
                [](T& t, Vec2 v) { t.base_position = v; }),
       quantity<T>("angle", dimension::angle, any, "0", "Direction of the rod at the clamp, from the x axis.",
                   [](T& t, double v) { t.base_angle = v; })}};
  Table<RodDraft> rod{rod_keys<T>("rod")};
  rod.keys.insert(rod.keys.begin() + 4,
                  table<T>("base", "rod.base", "The clamp.", std::move(base), [](T& t) -> T& { return t; }));
  return rod;
}

Table<FingerDraft> finger_table() {
  using T = FingerDraft;
  Table<FingerDraft> finger{rod_keys<T>("finger", "as in [rod]")};
  finger.keys.push_back(quantity<T>("angle", dimension::angle, any, "finger_angle of [gripper]",
                                    "Angle of the finger's base against the axis.",
                                    [](T& t, double v) { t.angle = v; }));
  finger.keys.push_back(quantity<T>("min_force", dimension::force, not_negative, "as in [contact]",
                                    "Smallest force of its contact.", [](T& t, double v) { t.min_force = v; }));
  finger.keys.push_back(quantity<T>("max_force", dimension::force, not_negative, "as in [contact]",
                                    "Largest force of its contact.", [](T& t, double v) { t.max_force = v; }));
  return finger;
}

Table<ObstacleSpec> obstacle_table() {
  using T = ObstacleSpec;
  return {{text<T>("name", "obstacle 1, ...", "Name in reports.", [](T& t, const std::string& v) { t.name = v; }),
           text<T>(
               "shape", "", "the name of an obstacle shape, such as \"circle\"",
               [](T& t, const std::string& v) { t.shape = v; }, {}, Need::required)},
          [](T& t, const std::string& name, RawValue value) { t.options[name] = std::move(value); }};
}

Table<ObjectiveSpec> objective_table() {
  using T = ObjectiveSpec;
  return {{text<T>(
               "plugin", "", "the name of an objective plugin, such as \"tip_pose\"",
               [](T& t, const std::string& v) { t.plugin = v; }, {}, Need::required),
           quantity<T>("weight", none, not_negative, "1", "Factor of the dimensionless term; 0 leaves the term out.",
                       [](T& t, double v) { t.weight = v; })},
          [](T& t, const std::string& name, RawValue value) { t.options[name] = std::move(value); }};
}

Table<CoordinatesSpec> coordinates_table() {
  using T = CoordinatesSpec;
  return {
      {text<T>("plugin", default_coordinates, "Coordinate plugin.", [](T& t, const std::string& v) { t.plugin = v; }),
       boolean<T>("split_at_contact", "true", "Puts a knot at each contact point: exact there, at little cost.",
                  [](T& t, bool v) { t.split_at_contact = v; })},
      [](T& t, const std::string& name, RawValue value) { t.options[name] = std::move(value); }};
}

Table<ContactSpec> contact_table() {
  using T = ContactSpec;
  return {{text<T>("mode", "allow", "Whether contact is ignored, avoided, allowed or required.",
                   [](T& t, const std::string& v) {
                     t.mode = v == "ignore"  ? ContactModeName::ignore
                              : v == "avoid" ? ContactModeName::avoid
                              : v == "allow" ? ContactModeName::allow
                                             : ContactModeName::require;
                   },
                   {"ignore", "avoid", "allow", "require"}),
           quantity<T>("min_force", dimension::force, not_negative, "0",
                       "Smallest contact force; for mode \"require\".", [](T& t, double v) { t.min_force = v; }),
           quantity<T>("max_force", dimension::force, not_negative, "no limit", "Largest contact force; 0 means avoid.",
                       [](T& t, double v) { t.max_force = v; }),
           integer<T>("count", 1, "1", "Contacts at most.", [](T& t, int v) { t.count = v; }),
           text<T>("treatment", "penalty", "How complementarity is brought into the program.",
                   [](T& t, const std::string& v) {
                     t.treatment = v == "penalty"    ? Treatment::penalty
                                   : v == "slack"    ? Treatment::slack
                                   : v == "scholtes" ? Treatment::scholtes
                                                     : Treatment::fischer_burmeister;
                   },
                   {"penalty", "slack", "scholtes", "fischer_burmeister"}),
           quantity<T>("beta", none, positive, "1", "First weight of the complementarity penalty, dimensionless.",
                       [](T& t, double v) { t.beta = v; }),
           integer<T>("check_points", 0, "0",
                      "A fixed number of clearance points, without refinement; 0: chosen and refined.",
                      [](T& t, int v) { t.check_points = v; })}};
}

Table<SolverSpec> solver_table() {
  using T = SolverSpec;
  return {
      {text<T>("plugin", default_solver, "Solver plugin.", [](T& t, const std::string& v) { t.plugin = v; }),
       quantity<T>("tolerance", none, positive, "1e-9",
                   "Feasibility and stationarity asked of the solver, dimensionless.",
                   [](T& t, double v) { t.tolerance = v; }),
       quantity<T>("time_limit", dimension::time, positive, "10 s", "Wall time for one plan.",
                   [](T& t, double v) { t.time_limit = v; }),
       integer<T>("max_iterations", 1, "500", "Iterations of one solve.", [](T& t, int v) { t.max_iterations = v; }),
       options<T>(
           "options", "solver.options", "The solver's own options, by their native names.",
           [](T & t) -> auto& { return t.options; })}};
}

/// Keys of [measurement]; lists of rows have a reader of their own.
Table<MeasurementDraft> measurement_table() {
  using T = MeasurementDraft;
  const auto list = [](std::string name, KeyType type, const Dimension& dimension, std::string description, auto read) {
    return Key<T>{
        {std::move(name), type, dimension, "", std::move(description)},
        [read](const Context& context, const Node& node, T& t) { read(context.document, context.units, node, t); }};
  };
  return {{list("points", KeyType::points, dimension::length,
                "Measured backbone points: [s, x, y] each, or [x, y] at equal distances along the rod, the last one at "
                "the tip.",
                read_measured_points),
           text<T>("file", "", "CSV file with the points instead, beside the scene; columns x, y or s, x, y.",
                   [](T& t, const std::string& v) { t.file = v; }),
           quantity<T>("noise", dimension::length, positive, "estimated from the residuals",
                       "Standard deviation of each measured coordinate.", [](T& t, double v) { t.noise = v; }),
           list("moments", KeyType::quantities, dimension::moment,
                "Moment of each actuator while the points were measured; not needed where min and max are equal.",
                read_known_moments)}};
}

Table<SceneDraft> trajectory_table() {
  using T = SceneDraft;
  return {{points<T>("positions", KeyType::points, dimension::length, "Where the tip should be, step by step.",
                     [](T& t, std::vector<Vec2> v) { t.trajectory.positions = std::move(v); }),
           quantities<T>("angles", dimension::angle, any, "Directions that the tip should have, step by step.",
                         [](T& t, std::vector<double> v) { t.trajectory.angles = std::move(v); }),
           integer<T>("replan_every", 0, "0",
                      "Steps between full plans, which may jump to another way of being in contact; 0: full plans only "
                      "where a contact comes or goes or Newton's method fails.",
                      [](T& t, int v) { t.scene.trajectory.replan_every = v; }),
           boolean<T>("cold_starts", "false", "Plans each step from the scene's own start as well, to compare.",
                      [](T& t, bool v) { t.scene.trajectory.cold_starts = v; })}};
}

Table<GripperSpec> gripper_table() {
  using T = GripperSpec;
  return {
      {quantity<T>(
           "half_palm", dimension::length, positive, "", "Distance from the axis of symmetry to either finger's base.",
           [](T& t, double v) { t.half_palm = v; }, Need::required),
       quantity<T>("finger_angle", dimension::angle, any, "0",
                   "Angle of the upper finger's base against the axis; that of the lower one is mirrored.",
                   [](T& t, double v) { t.finger_angle = v; }),
       quantity<T>(
           "object_diameter", dimension::length, positive, "", "Diameter of the round object.",
           [](T& t, double v) { t.object_diameter = v; }, Need::required),
       quantity<T>("palm_distance", dimension::length, positive, "free",
                   "Fixed distance from the palm to the object's centre.", [](T& t, double v) { t.palm_distance = v; }),
       quantities<T>("palm_distance_range", dimension::length, not_negative,
                     "Smallest and largest distance from the palm to the object's centre.",
                     [](T& t, std::vector<double> v) {
                       // Two entries are asked for below, where the place in the file is known.
                       t.palm_distance_range = {v.front(), v.size() == 2 ? v.back() : std::nan("")};
                     }),
       point<T>("position", dimension::length, "[0, 0]", "The palm's middle.", [](T& t, Vec2 v) { t.position = v; }),
       quantity<T>("angle", dimension::angle, any, "0", "Direction of the axis of symmetry, away from the palm.",
                   [](T& t, double v) { t.angle = v; }),
       text<T>("balance", "exact", "Forces along the axis: none at all, or as an objective has it.",
               [](T& t, const std::string& v) { t.exact_balance = v == "exact"; }, {"exact", "objective"}),
       text<T>("fingers", "both where they differ or gravity acts across the axis",
               "Which fingers are planned: one, whose mirror image the other one is, or both.",
               [](T& t, const std::string& v) { t.fingers = v == "both" ? Fingers::both : Fingers::mirrored; },
               {"mirrored", "both"})}};
}

Table<StudySpec> study_table() {
  using T = StudySpec;
  const auto modes_of = [](const std::vector<std::string>& names) {
    std::vector<StudyMode> modes;
    modes.reserve(names.size());
    for (const std::string& name : names) modes.push_back(study_mode(name));
    return modes;
  };
  return {{points<T>("targets", KeyType::targets, dimension::length,
                     "Target positions: a list of points, or {x = [...], y = [...]} for all pairs.",
                     [](T& t, std::vector<Vec2> v) { t.targets = std::move(v); }),
           texts<T>("modes",
                    "Paradigms: contact modes, and \"ignore_then_execute\" for plans that ignore obstacles and are "
                    "carried out among them.",
                    study_mode_names(), [modes_of](T& t, const std::vector<std::string>& v) { t.modes = modes_of(v); }),
           quantities<T>("limits", dimension::moment, positive,
                         "Largest moments in either direction, for all actuators; a side that is 0 stays 0.",
                         [](T& t, std::vector<double> v) { t.limits = std::move(v); }),
           quantities<T>("force_limits", dimension::force, positive, "Largest contact forces.",
                         [](T& t, std::vector<double> v) { t.force_limits = std::move(v); }),
           quantities<T>("diameters", dimension::length, positive, "Diameters of a grasp's object.",
                         [](T& t, std::vector<double> v) { t.diameters = std::move(v); }),
           quantities<T>("moments", dimension::moment, any,
                         "Changes of the planned moment of a grasp's last actuator, each carried out with the object "
                         "where it was planned.",
                         [](T& t, std::vector<double> v) { t.moments = std::move(v); }),
           texts<T>("starts", "Paradigms whose results \"allow\" and \"require\" start from as well.",
                    {"ignore", "ignore_then_execute", "avoid"},
                    [modes_of](T& t, const std::vector<std::string>& v) { t.starts = modes_of(v); })}};
}

Table<SceneDraft> scene_table() {
  using T = SceneDraft;
  const std::vector<std::string> problems{"pose", "trajectory", "grasp", "execute", "estimate"};
  Table<T> scene;
  scene.keys = {
      text<T>("title", "", "Title of reports and figures.", [](T& t, const std::string& v) { t.scene.title = v; }),
      text<T>(
          "problem", "pose", "Kind of problem.",
          [](T& t, const std::string& v) {
            for (const ProblemKind kind :
                 {ProblemKind::trajectory, ProblemKind::grasp, ProblemKind::execute, ProblemKind::estimate}) {
              if (v == to_string(kind)) t.scene.problem = kind;
            }
          },
          problems),
      point<T>("gravity", dimension::acceleration, "no gravity", "Gravity.", [](T& t, Vec2 v) { t.scene.gravity = v; }),
      table<T>(
          "rod", "rod", "the rod", rod_table(), [](T & t) -> auto& { return t.rod; }, Need::required),
      table<T>(
          "tip_load", "tip_load", "A load at the tip.",
          Table<TipLoadSpec>{
              {quantity<TipLoadSpec>("mass", dimension::mass, not_negative, "0", "Point mass at the tip.",
                                     [](TipLoadSpec& t, double v) { t.mass = v; }),
               point<TipLoadSpec>("force", dimension::force, "[0, 0]",
                                  "Dead force at the tip; of a grasp at that of the upper finger, and mirrored at the "
                                  "other one.",
                                  [](TipLoadSpec& t, Vec2 v) { t.force = v; })}},
          [](T & t) -> auto& { return t.scene.tip_load; }),
      table<T>(
          "coordinates", "coordinates", "How the backbone is described. Further keys are options of the plugin.",
          coordinates_table(), [](T & t) -> auto& { return t.scene.coordinates; }),
      table<T>(
          "start", "start", "Where the search begins.",
          Table<Scene>{
              {quantity<Scene>("tip_angle", dimension::angle, any, "0", "Tip angle of a constant-curvature start.",
                               [](Scene& t, double v) { t.start_tip_angle = v; })}},
          [](T & t) -> auto& { return t.scene; }),
      tables<T>(
          "obstacle", "obstacle", "An obstacle. Further keys are options of its shape.", obstacle_table(),
          [](T & t) -> auto& { return t.scene.obstacles; }),
      table<T>(
          "contact", "contact", "How contact with obstacles is planned.", contact_table(),
          [](T & t) -> auto& { return t.scene.contact; }),
      table<T>(
          "target", "target", "The pose asked for.",
          Table<TargetSpec>{
              {point<TargetSpec>("position", dimension::length, "", "Where the tip should be.",
                                 [](TargetSpec& t, Vec2 v) { t.position = v; }),
               quantity<TargetSpec>("angle", dimension::angle, any, "", "Direction that the tip should have.",
                                    [](TargetSpec& t, double v) { t.angle = v; })}},
          [](T & t) -> auto& { return t.scene.target; }),
      tables<T>(
          "objective", "objective", "A term of the objective. Further keys are options of the plugin.",
          objective_table(), [](T & t) -> auto& { return t.scene.objectives; }),
      table<T>(
          "solver", "solver", "The solver.", solver_table(), [](T & t) -> auto& { return t.scene.solver; }),
      table<T>(
          "gripper", "gripper", "Palm, fingers and object; for the problem kind \"grasp\".", gripper_table(),
          [](T & t) -> auto& { return t.scene.gripper.emplace(); }),
      tables<T>(
          "finger", "finger",
          "Fingers of a grasp that differ: the upper one, then the lower one. Everything is said as of an upper "
          "finger: "
          "of the lower one it is the mirror image that is described. Segments or actuators replace those of [rod].",
          finger_table(), [](T & t) -> auto& { return t.fingers; }),
      table<T>("trajectory", "trajectory", "The targets of a trajectory.", trajectory_table(),
               [](T& t) -> T& { return t; }),
      table<T>(
          "measurement", "measurement", "What was measured of the rod; for the problem kind \"estimate\".",
          measurement_table(), [](T & t) -> auto& { return t.measurement; }),
      table<T>(
          "study", "study", "Sweeps for 'tendril study': every combination is one case.", study_table(),
          [](T & t) -> auto& { return t.study.emplace(); })};
  return scene;
}

/// A kind of problem that exists in the format but not in this version deserves a better answer than "unknown word".
void refuse_other_problems(const Document& document) {
  const Node* node = document.root().find("problem");
  if (node == nullptr) return;
  const auto* kind = std::get_if<std::string>(&node->value);
  if (kind == nullptr) return;
  for (const std::string_view other : {"study"}) {
    if (*kind == other) {
      document.fail(node->position, "found problem = \"" + *kind +
                                        "\", which is not available in this version, expected one of \"pose\", "
                                        "\"trajectory\", \"grasp\", \"execute\", \"estimate\"");
    }
  }
}

/// `table`: where the rod is described.
RodSpec finish_rod(const Document& document, const std::string& table, const RodDraft& draft) {
  const std::string name = table == "rod" ? "[rod]" : "[[finger]]";
  RodSpec rod;
  rod.base_position = draft.base_position;
  rod.base_angle = draft.base_angle;
  if (!draft.segments.empty()) {
    const auto refuse = [&](const char* key, const std::optional<double>& value) {
      if (!value) return;
      document.fail(document.find(table + '.' + key),
                    fmt::format("found '{}' beside [[{}.segment]], expected either uniform values or segments", key,
                                table.substr(0, table.find('['))));
    };
    refuse("length", draft.length);
    refuse("bending_stiffness", draft.bending_stiffness);
    refuse("linear_density", draft.linear_density);
    refuse("rest_curvature", draft.rest_curvature);
    rod.segments = draft.segments;
  } else {
    if (!draft.length)
      document.fail(document.find(table), name + " has no 'length' and no [[" + table.substr(0, table.find('[')) +
                                              ".segment]], expected " + expected_quantity(dimension::length));
    if (!draft.bending_stiffness)
      document.fail(document.find(table),
                    name + " has no 'bending_stiffness', expected " + expected_quantity(dimension::stiffness));
    rod.segments = {{*draft.length, *draft.bending_stiffness, draft.linear_density.value_or(0.0),
                     draft.rest_curvature.value_or(0.0)}};
  }
  double length = 0.0;
  for (const SegmentSpec& segment : rod.segments) length += segment.length;
  for (std::size_t i = 0; i < draft.actuators.size(); ++i) {
    const ActuatorDraft& actuator = draft.actuators[i];
    const std::string path = fmt::format("{}.actuator[{}].", table, i);
    if (actuator.limit && (actuator.minimum || actuator.maximum)) {
      document.fail(document.find(path + "limit"),
                    "found 'limit' beside 'min' or 'max', expected either limit or min and max");
    }
    ActuatorSpec spec;
    spec.from = actuator.from.value_or(0.0);
    spec.to = actuator.to.value_or(length);
    spec.moment_per_pressure = actuator.moment_per_pressure;
    if (actuator.limit) {
      spec.minimum = -*actuator.limit;
      spec.maximum = *actuator.limit;
    }
    if (actuator.smallest_pressure || actuator.largest_pressure) {
      const std::string key = path + (actuator.smallest_pressure ? "min_pressure" : "max_pressure");
      if (actuator.limit || actuator.minimum || actuator.maximum) {
        document.fail(document.find(key),
                      "found a limit of the pressure beside one of the moment, expected one of them");
      }
      if (actuator.moment_per_pressure == 0.0) {
        document.fail(document.find(key), "found a limit of the pressure, expected 'moment_per_pressure' beside it");
      }
      const double low = actuator.smallest_pressure.value_or(-infinity) * actuator.moment_per_pressure;
      const double high = actuator.largest_pressure.value_or(infinity) * actuator.moment_per_pressure;
      spec.minimum = actuator.moment_per_pressure > 0.0 ? low : high;
      spec.maximum = actuator.moment_per_pressure > 0.0 ? high : low;
      if (spec.minimum > spec.maximum) document.fail(document.find(key), "found min_pressure above max_pressure");
    }
    if (actuator.minimum) spec.minimum = *actuator.minimum;
    if (actuator.maximum) spec.maximum = *actuator.maximum;
    if (spec.minimum > spec.maximum) {
      document.fail(document.find(path + "min"),
                    fmt::format("found min {} N m above max {} N m, expected min <= max", spec.minimum, spec.maximum));
    }
    if (spec.from >= spec.to) {
      document.fail(document.find(path + (actuator.from ? "from" : "to")),
                    fmt::format("found an actuator from {} m to {} m, expected from < to", spec.from, spec.to));
    }
    rod.actuators.push_back(spec);
  }
  return rod;
}

/// What a finger does not state is taken from `rod`.
RodDraft with_inherited(const RodDraft& rod, const RodDraft& finger) {
  RodDraft whole = finger;
  const bool uniform = finger.length || finger.bending_stiffness || finger.linear_density || finger.rest_curvature;
  if (finger.segments.empty() && !uniform) whole.segments = rod.segments;
  if (whole.segments.empty()) {
    const auto inherit = [](std::optional<double>& own, const std::optional<double>& from) {
      if (!own) own = from;
    };
    inherit(whole.length, rod.length);
    inherit(whole.bending_stiffness, rod.bending_stiffness);
    inherit(whole.linear_density, rod.linear_density);
    inherit(whole.rest_curvature, rod.rest_curvature);
  }
  if (finger.actuators.empty()) whole.actuators = rod.actuators;
  return whole;
}

std::vector<FingerSpec> finish_fingers(const Document& document, const SceneDraft& draft, const Scene& scene) {
  std::vector<FingerSpec> fingers;
  for (std::size_t i = 0; i < draft.fingers.size(); ++i) {
    const FingerDraft& own = draft.fingers[i];
    const std::string table = fmt::format("finger[{}]", i);
    FingerSpec finger;
    finger.rod = finish_rod(document, table, with_inherited(draft.rod, own));
    finger.finger_angle = own.angle.value_or(scene.gripper ? scene.gripper->finger_angle : 0.0);
    finger.min_force = own.min_force.value_or(scene.contact.min_force);
    finger.max_force = own.max_force.value_or(scene.contact.max_force);
    if (finger.min_force > finger.max_force) {
      document.fail(document.find(table + (own.min_force ? ".min_force" : ".max_force")),
                    fmt::format("found min_force {} N above max_force {} N, expected min_force <= max_force",
                                finger.min_force, finger.max_force));
    }
    fingers.push_back(std::move(finger));
  }
  return fingers;
}

std::vector<TargetSpec> finish_trajectory(const Document& document, const TrajectoryDraft& draft) {
  const std::size_t positions = draft.positions.size();
  const std::size_t angles = draft.angles.size();
  if (positions > 0 && angles > 0 && positions != angles) {
    document.fail(document.find("trajectory.angles"),
                  fmt::format("found {} angles for {} positions, expected one for each", angles, positions));
  }
  if (positions == 0 && angles == 0 && document.root().find("trajectory") != nullptr) {
    document.fail(document.find("trajectory"),
                  "[trajectory] has neither 'positions' nor 'angles', expected one of them");
  }
  std::vector<TargetSpec> targets(std::max(positions, angles));
  for (std::size_t i = 0; i < positions; ++i) targets[i].position = draft.positions[i];
  for (std::size_t i = 0; i < angles; ++i) targets[i].angle = draft.angles[i];
  return targets;
}

}  // namespace

std::vector<KeySpec> scene_keys() { return scene_table().specs(); }

Scene read_scene(const Document& document, std::shared_ptr<const Units> units) {
  const Context context{document, *units};
  refuse_other_problems(document);
  SceneDraft draft;
  draft.scene.coordinates.plugin = default_coordinates;
  draft.scene.solver.plugin = default_solver;
  draft.scene.coordinates.position = document.find("coordinates");
  draft.scene.solver.position = document.find("solver");
  read_table(context, document.root(), "", scene_table(), draft);
  Scene scene = std::move(draft.scene);
  scene.rod = finish_rod(document, "rod", draft.rod);
  scene.fingers = finish_fingers(document, draft, scene);
  if (scene.gripper && scene.gripper->palm_distance_range && std::isnan(scene.gripper->palm_distance_range->second)) {
    document.fail(document.find("gripper.palm_distance_range"), "expected two lengths: the smallest and the largest");
  }
  scene.measurement = finish_measurement(document, *units, draft.measurement, scene);
  scene.trajectory.targets = finish_trajectory(document, draft.trajectory);
  if (scene.contact.min_force > scene.contact.max_force) {
    document.fail(document.find("contact.min_force"),
                  fmt::format("found min_force {} N above max_force {} N, expected min_force <= max_force",
                              scene.contact.min_force, scene.contact.max_force));
  }
  for (std::size_t i = 0; i < scene.obstacles.size(); ++i) {
    if (scene.obstacles[i].name.empty()) scene.obstacles[i].name = fmt::format("obstacle {}", i + 1);
  }
  scene.file = document.file();
  scene.read_quantity = [units = std::move(units)](std::string_view number, const Dimension& wanted) {
    try {
      return units->read(number, wanted);
    } catch (const QuantityError& error) {
      // Whoever resolves options says what was found and expected.
      throw InputError(error.why());
    }
  };
  return scene;
}

StudySpec read_study(const Document& document, const Units& units) {
  SceneDraft draft;
  read_table(Context{document, units}, document.root(), "", scene_table(), draft);
  if (!draft.study) document.fail({1, 1}, "the scene has no [study], expected one with targets, modes or limits");
  return std::move(*draft.study);
}

}  // namespace tendril::app
