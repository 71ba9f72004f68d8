#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "program/pose_program.hpp"
#include "rod/rod.hpp"
#include "search/grip.hpp"
#include "tendril/plan.hpp"
#include "tendril/registrar.hpp"
#include "tendril/scene.hpp"

namespace tendril {

class Follower;
class FreeReach;
struct Beginning;
struct SideStart;

/// One way of being in contact: a small program of its own. Regions of interior contacts are stretches between fixed
/// knots.
struct Mode {
  std::string name;
  std::vector<ContactSetup> contacts;
  std::string skip{};  ///< why it need not be solved, known before anything is; empty: it must be
};

/// What is searched for: a scene made dimensionless and assembled, only the blocks that it needs.
struct Task {
  Scene scene;
  Components components;
  const CoordinateModel* model = nullptr;  ///< of the components; of a lower finger those of the upper one
  Scale scale;
  Scale scene_scale;       ///< in which terms see everything; another one where fingers of a grasp differ
  TermUnits term_units{};  ///< units of `scale` in those of `scene_scale`
  Rod rod;
  std::vector<Rod> windows;  ///< of a rod whose port may pass fixed knots: one of them is `rod`; else that alone
  std::vector<std::unique_ptr<Obstacle>> own_obstacles;  ///< of a grasp
  std::vector<const Obstacle*> obstacles;                ///< those that the plan respects
  std::vector<bool> pocketed;                            ///< of each: has_pockets(); empty: none is
  int contact_obstacles = 0;                             ///< the first so many may be touched
  std::optional<PalmSetup> palm;                         ///< of a grasp
  std::unique_ptr<const Grip> grip;                      ///< of a grasp
  int carried = 0;                                       ///< obstacles that stand on the palm: the last ones
  std::vector<std::string> obstacle_names;
  std::vector<PoseProgramTerm> terms;  ///< weights divided by `objective_scale`
  double objective_scale = 1.0;
  std::shared_ptr<const Uncertainties> uncertainties;  ///< where a term reads them
  Target target;
  TargetTolerance tolerance;
  std::function<double(double)> start_points;  ///< curvature of a start that the scene gives by points; empty: none
  std::optional<double> direction;             ///< rad, of the target, of which target.angle is one of many angles
  double min_force = 0.0, max_force = infinity;
  std::vector<double> friction;  ///< of each obstacle, a coefficient: tangential forces are planned; empty: none are
  std::optional<double> least_margin;     ///< of stability, while plans are held at its limit
  std::optional<double> least_convexity;  ///< of contacts, while plans are held where they would spread
  std::shared_ptr<TableStore> tables = std::make_shared<TableStore>();
  std::vector<Mode> modes;  ///< all, or those that a search begins with
  bool enumerated = true;   ///< `modes` are all there are
  std::vector<LeftOut> left_out;
  int nodes = 0;
  double seconds_assemble = 0.0;
  std::unique_ptr<Follower> follower;  ///< of the plan that was followed last
  std::unique_ptr<FreeReach> reach;    ///< of the rod without contacts, once it was asked for
  std::unique_ptr<Task> lower;         ///< of a grasp whose fingers are both planned: this one is then the upper finger
  std::vector<SideStart> arcs;         ///< simple shapes beside obstacles, once they were asked for
  std::size_t unbent_arcs = 0;         ///< so many of them are as moments bend the rod
  std::vector<std::shared_ptr<Beginning>> beginnings;  ///< from these, and from the scene's own start
  bool solver_works = false;                           ///< it kept its promises in a program that Newton had solved

  Task();
  ~Task();

  /// Another rod instead; forgets what was found with the one before, modes included.
  void take_rod(const Rod& other);
  /// Where the port is, for names of modes; empty where it is in one stretch only.
  std::string port_name() const;
  /// The mode with these contacts: its name, and why it cannot be if that is known.
  Mode mode(std::vector<ContactSetup> contacts) const;
  Mode largest_mode() const;
  /// The program's parts that do not depend on check points. `regions` replaces the contacts' regions (for an unsplit
  /// rod: pieces).
  PoseProgramSpec spec(const Mode& mode, const std::vector<int>& regions, int with_nodes) const;
  /// The regions of a mode's contacts that lie at these arc lengths, as spec() takes them.
  std::vector<int> regions_of(const Mode& mode, const std::vector<double>& arc_lengths) const;
  /// Coordinates of the programs of a mode.
  int coordinate_count(const Mode& mode) const;
  /// Pieces of an unsplit rod in a stretch.
  std::vector<int> pieces_of_stretch(int stretch) const;
  std::vector<CheckPoint> first_checks(const PoseProgramSpec& spec, const StartShape& shape) const;
  /// The same where the program without check points is there, and x where it starts from the shape.
  std::vector<CheckPoint> first_checks(const PoseProgram& probe, ConstVectorRef x, const StartShape& shape) const;
  StartShape scene_start() const {
    return start_points ? StartShape{start_points} : constant_curvature(scene.start_tip_angle);
  }
  bool contact_planned() const;
  /// No plan can cost less (scaled) whose tip is at least `distance` (units of L) from the target's position.
  double least_cost(double distance = 0.0) const;
  /// A distance (units of L) from the target's position that the tip of no plan of a mode is nearer than, each contact
  /// touching; 0 where none is known. Made sharper until it is `enough`, or never will be.
  double least_distance(const Mode& mode, const std::function<bool(double)>& enough);
  /// Gauss nodes for what the moments can bend, or the start shows; the certificate checks the choice.
  int first_nodes() const;
  void take_target(const TargetSpec& wanted);
  /// A start along the scene's points, if there are any; a constant curvature of the same turn stands for it elsewhere.
  void take_start();
  /// Angles that the target's direction may stand for, those nearest to `reference` first, and none that moments within
  /// their limits, gravity and contact cannot turn the tip to; the first one whatever it is. Empty: turns are given, or
  /// no direction.
  std::vector<double> angles_near(double reference) const;
  /// Takes the target's direction for the angle nearest to `reference`.
  void face(double reference);
  /// Angle of the tip where a search without an earlier plan begins.
  double start_tip_angle() const;
};

}  // namespace tendril
