#include "scene/scene_tables.hpp"

#include <algorithm>
#include <cmath>

namespace tendril::app {

namespace {

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
                  [](T& t, bool v) { t.split_at_contact = v; }),
       integer<T>(
           "stretch_order", 0, "0",
           "Legendre coefficients per piece with which the rod stretches: 1 is a uniform stretch of each piece, 0 "
           "none.",
           [](T& t, int v) { t.stretch_order = v; })},
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
           quantity<T>("friction", none, not_negative, "0", "Coefficient of friction of all contacts.",
                       [](T& t, double v) { t.friction = v; }),
           text<T>("friction_state", "range",
                   "Where contacts rub: \"range\" plans without friction and then follows every state that it allows; "
                   "\"worst\" plans for the state that costs most; \"any\" plans with tangential forces.",
                   [](T& t, const std::string& v) {
                     t.friction_state = v == "none"    ? FrictionState::none
                                        : v == "any"   ? FrictionState::any
                                        : v == "worst" ? FrictionState::worst
                                                       : FrictionState::range;
                   },
                   {"range", "worst", "any", "none"}),
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

Table<ObstaclePlaces> obstacle_places_table() {
  using T = ObstaclePlaces;
  return {
      {text<T>(
           "name", "", "The name of an obstacle.", [](T& t, const std::string& v) { t.name = v; }, {}, Need::required),
       points<T>("shifts", KeyType::points, dimension::length, "Each takes the place of the obstacle's `shift`.",
                 [](T& t, std::vector<Vec2> v) { t.shifts = std::move(v); }),
       quantities<T>("turns", dimension::angle, any, "Each takes the place of the obstacle's `turn`.",
                     [](T& t, const std::vector<double>& v) { t.turns = std::move(v); })}};
}

Table<SceneDraft> trajectory_table() {
  using T = SceneDraft;
  return {
      {points<T>("positions", KeyType::points, dimension::length, "Where the tip should be, step by step.",
                 [](T& t, std::vector<Vec2> v) { t.trajectory.positions = std::move(v); }),
       quantities<T>("angles", dimension::angle, any,
                     "Directions that the tip should have, step by step, each the shorter way round from the one "
                     "before.",
                     [](T& t, const std::vector<double>& v) { t.trajectory.angles = std::move(v); }),
       text<T>("file", "",
               "CSV file with the targets instead, beside the scene; columns x, y, or x, y, angle, or angle.",
               [](T& t, const std::string& v) { t.trajectory.file = v; }),
       integer<T>("replan_every", 0, "0",
                  "Steps between full plans, which may jump to another way of being in contact; 0: full plans only "
                  "where a contact comes or goes or Newton's method fails.",
                  [](T& t, int v) { t.scene.trajectory.replan_every = v; }),
       boolean<T>("cold_starts", "false", "Plans each step from the scene's own start as well, to compare.",
                  [](T& t, bool v) { t.scene.trajectory.cold_starts = v; }),
       tables<T>(
           "obstacle", "trajectory.obstacle",
           "An obstacle that moves: a shift or a turn for each step. Without targets there is a step for each, with "
           "that of [target].",
           obstacle_places_table(), [](T & t) -> auto& { return t.trajectory.obstacles; })}};
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
       quantities<T>("half_palm_range", dimension::length, positive,
                     "Between which a plan may move either finger's base across the axis, each by itself; `half_palm` "
                     "is then where it begins.",
                     [](T& t, const std::vector<double>& v) { t.half_palm_range = two_of(v); }),
       quantities<T>("finger_angle_range", dimension::angle, any,
                     "Between which a plan may turn either finger's base, each by itself: a finger on a wrist. "
                     "`finger_angle` is then where it begins.",
                     [](T& t, const std::vector<double>& v) { t.finger_angle_range = two_of(v); }),
       quantity<T>(
           "object_diameter", dimension::length, positive, "", "Diameter of the round object.",
           [](T& t, double v) { t.object_diameter = v; }, Need::required),
       quantity<T>("object_mass", dimension::mass, not_negative, "0", "Mass of the object, which gravity pulls at.",
                   [](T& t, double v) { t.object_mass = v; }),
       point<T>("object_force", dimension::force, "[0, 0]", "Dead force on the object's centre.",
                [](T& t, Vec2 v) { t.object_force = v; }),
       quantity<T>("palm_distance", dimension::length, positive, "free",
                   "Fixed distance from the palm to the object's centre.", [](T& t, double v) { t.palm_distance = v; }),
       quantities<T>("palm_distance_range", dimension::length, not_negative,
                     "Smallest and largest distance from the palm to the object's centre.",
                     [](T& t, const std::vector<double>& v) { t.palm_distance_range = two_of(v); }),
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

/// What all entries of a list measure: moments unless their units are those of something else that actuators are told.
Dimension told_in(const Context& context, const Node::List& list) {
  const auto measures = [&](const Node& item, const Dimension& dimension) {
    const auto* text = std::get_if<std::string>(&item.value);
    if (text == nullptr) return false;
    try {
      context.units.read(*text, dimension);
      return true;
    } catch (const QuantityError&) {
      return false;
    }
  };
  for (const Dimension& other : {dimension::pressure, dimension::force, dimension::length}) {
    if (std::all_of(list.begin(), list.end(), [&](const Node& item) { return measures(item, other); })) return other;
  }
  return dimension::moment;
}

Key<StudySpec> limits_key() {
  using T = StudySpec;
  Key<T> key =
      quantities<T>("limits", dimension::moment, positive,
                    "Largest moments in either direction, for all actuators, or pressures, tensions or shortenings "
                    "with their unit; a side that is 0 stays 0.",
                    [](T& t, const std::vector<double>& v) { t.limits = std::move(v); });
  key.read = [spec = key.spec, read = key.read](const Context& context, const Node& node, T& study) {
    const auto* list = std::get_if<Node::List>(&node.value);
    if (list == nullptr || list->empty()) return read(context, node, study);
    KeySpec own = spec;
    own.dimension = study.limited = told_in(context, *list);
    study.limits = read_list(context, node, expected_quantity(own.dimension),
                             [&](const Node& item) { return read_quantity(context, item, own); });
  };
  return key;
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
           limits_key(),
           quantities<T>("force_limits", dimension::force, positive, "Largest contact forces.",
                         [](T& t, const std::vector<double>& v) { t.force_limits = std::move(v); }),
           quantities<T>("insertions", dimension::length, positive,
                         "Lengths of the rod that are out of its port, each held, at most [rod.insertion] `max`.",
                         [](T& t, const std::vector<double>& v) { t.insertions = std::move(v); }),
           points<T>("base_positions", KeyType::points, dimension::length, "Where the rod is clamped, each held.",
                     [](T& t, std::vector<Vec2> v) { t.base_positions = std::move(v); }),
           quantities<T>("base_angles", dimension::angle, any, "Directions of the clamp, each held.",
                         [](T& t, const std::vector<double>& v) { t.base_angles = std::move(v); }),
           table<T>(
               "obstacle", "study.obstacle", "An obstacle that is moved: every shift with every turn.",
               obstacle_places_table(), [](T & t) -> auto& { return t.obstacle; }),
           quantities<T>("diameters", dimension::length, positive, "Diameters of a grasp's object.",
                         [](T& t, const std::vector<double>& v) { t.diameters = std::move(v); }),
           quantities<T>("moments", dimension::moment, any,
                         "Changes of the planned moment of a grasp's last actuator, each carried out with the object "
                         "where it was planned.",
                         [](T& t, const std::vector<double>& v) { t.moments = std::move(v); }),
           quantities<T>("pressures", dimension::pressure, any,
                         "Changes of its pressure, instead of moments; with moment_per_pressure.",
                         [](T& t, const std::vector<double>& v) { t.pressures = std::move(v); }),
           texts<T>("starts", "Paradigms whose results \"allow\" and \"require\" start from as well.",
                    {"ignore", "ignore_then_execute", "avoid"},
                    [modes_of](T& t, const std::vector<std::string>& v) { t.starts = modes_of(v); })}};
}

Table<Scene> search_table() {
  return {{text<Scene>(
      "effort", "normal",
      "\"fast\": one start for each way of being in contact; \"thorough\": ten times as many as \"normal\".",
      [](Scene& t, const std::string& v) {
        for (const SearchEffort effort : {SearchEffort::fast, SearchEffort::thorough}) {
          if (v == to_string(effort)) t.effort = effort;
        }
      },
      {"fast", "normal", "thorough"})}};
}

Table<TipLoadSpec> tip_load_table() {
  return {{quantity<TipLoadSpec>("mass", dimension::mass, not_negative, "0", "Point mass at the tip.",
                                 [](TipLoadSpec& t, double v) { t.mass = v; }),
           point<TipLoadSpec>("force", dimension::force, "[0, 0]",
                              "Dead force at the tip; of a grasp at that of the upper finger, and mirrored at the "
                              "other one.",
                              [](TipLoadSpec& t, Vec2 v) { t.force = v; })}};
}

Table<SceneDraft> start_table() {
  using T = SceneDraft;
  return {{quantity<T>("tip_angle", dimension::angle, any, "0", "Tip angle of a constant-curvature start.",
                       [](T& t, double v) { t.scene.start_tip_angle = v; }),
           points<T>("points", KeyType::points, dimension::length,
                     "Points along the start from the base on, the last one at the tip, instead of a tip angle.",
                     [](T& t, std::vector<Vec2> v) { t.scene.start_points = std::move(v); }),
           text<T>("file", "", "CSV file with these points instead, beside the scene; columns x, y.",
                   [](T& t, const std::string& v) { t.start_file = v; })}};
}

Table<TargetSpec> target_table() {
  return {{point<TargetSpec>("position", dimension::length, "", "Where the tip should be.",
                             [](TargetSpec& t, Vec2 v) { t.position = v; }),
           quantity<TargetSpec>("angle", dimension::angle, any, "",
                                "Direction that the tip should have; full turns do not count.",
                                [](TargetSpec& t, double v) { t.angle = v; }),
           integer<TargetSpec>("turns", -100, "whatever suits",
                               "Full turns of the tip against the base, beyond the half turn at most that leads to "
                               "'angle'.",
                               [](TargetSpec& t, int v) { t.turns = v; }),
           quantity<TargetSpec>("position_tolerance", dimension::length, positive, "none",
                                "How far the tip may be from 'position'; a plan that cannot keep it is no plan.",
                                [](TargetSpec& t, double v) { t.position_tolerance = v; }),
           quantity<TargetSpec>("angle_tolerance", dimension::angle, positive, "none",
                                "How far the tip's direction may be from 'angle', likewise.",
                                [](TargetSpec& t, double v) { t.angle_tolerance = v; })}};
}

Table<CorrelationDraft> correlation_table() {
  using T = CorrelationDraft;
  return {{texts<T>("between", "Two keys, such as \"rod.bending_stiffness\".", {},
                    [](T& t, const std::vector<std::string>& v) { t.between = v; }),
           quantity<T>(
               "value", none, Range{-1.0}, "", "Their correlation, from -1 to 1.", [](T& t, double v) { t.value = v; },
               Need::required)}};
}

Table<SceneDraft> make_scene_table() {
  using T = SceneDraft;
  const std::vector<std::string> problems{"pose", "trajectory", "grasp", "execute", "estimate"};
  Table<T> scene;
  scene.keys = {
      text<T>("include", "",
              "Another file beside the scene: whatever this one does not say is taken from it. Files that it names are "
              "looked for beside the scene.",
              [](T&, const std::string&) {}),
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
      boolean<T>("guided_in_plane", "false",
                 "The robot cannot leave its plane: a margin out of it is told and refuses no plan.",
                 [](T& t, bool v) { t.scene.guided_in_plane = v; }),
      table<T>(
          "rod", "rod", "the rod", rod_table(), [](T & t) -> auto& { return t.rod; }, Need::required),
      table<T>(
          "tip_load", "tip_load", "A load at the tip.", tip_load_table(),
          [](T & t) -> auto& { return t.scene.tip_load; }),
      table<T>(
          "coordinates", "coordinates", "How the backbone is described. Further keys are options of the plugin.",
          coordinates_table(), [](T & t) -> auto& { return t.scene.coordinates; }),
      table<T>(
          "start", "start", "Where the search begins.", start_table(), [](T & t) -> auto& { return t; }),
      tables<T>(
          "obstacle", "obstacle", "An obstacle. Further keys are options of its shape.", obstacle_table(),
          [](T & t) -> auto& { return t.obstacles; }),
      table<T>(
          "contact", "contact", "How contact with obstacles is planned.", contact_table(),
          [](T & t) -> auto& { return t.scene.contact; }),
      table<T>(
          "target", "target", "The pose asked for.", target_table(), [](T & t) -> auto& { return t.scene.target; }),
      tables<T>(
          "objective", "objective", "A term of the objective. Further keys are options of the plugin.",
          objective_table(), [](T & t) -> auto& { return t.scene.objectives; }),
      table<T>(
          "solver", "solver", "The solver.", solver_table(), [](T & t) -> auto& { return t.scene.solver; }),
      table<T>(
          "search", "search", "How far is looked for a better plan.", search_table(),
          [](T & t) -> auto& { return t.scene; }),
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
      tables<T>(
          "correlation", "correlation", "How two numbers with error bars go together, as a calibration finds them.",
          correlation_table(), [](T & t) -> auto& { return t.correlations; }),
      table<T>(
          "study", "study", "Sweeps for 'tendril study': every combination is one case.", study_table(),
          [](T & t) -> auto& { return t.study.emplace(); }),
      table<T>(
          "calibrate", "calibrate", "Measured shapes for 'tendril calibrate', and what is looked for.",
          calibration_table(), [](T & t) -> auto& { return t.calibration.emplace(); })};
  return scene;
}

}  // namespace

const Table<SceneDraft>& scene_table() {
  static const Table<SceneDraft> table = make_scene_table();
  return table;
}

}  // namespace tendril::app
